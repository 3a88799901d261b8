"""Parts of blocks in one dimension as one record each: what a compiled step takes of them.

A step of a few hundred nodes takes less time than the calls of its loops from Python. So each part
is a record with its laws, its arrays and the faces at its two ends; the loops are those of all
dimensions.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import overload_method

from fsipetsc.operators.boxed import BoxType
from fsipetsc.operators.loops import CALL, INNER_LOOP, MERGED_CALL
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.scheme.block_look import BAD, CONVECTION, J_ERROR, LEAST_J, gas_look, look_at_end
from fsipetsc.scheme.faces import absorb, heat_face, open_face, push_face, tangent
from fsipetsc.scheme.gas_dissipation import gas_dissipation
from fsipetsc.scheme.gas_rates import gas_rates
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.solid_dissipation import solid_dissipation
from fsipetsc.scheme.solid_look import solid_look
from fsipetsc.scheme.solid_rates import solid_rates

#: of functions that are compiled with what calls them
CALLED = {"error_model": "numpy", "boundscheck": False}
#: one dimension
LINE = (0.0,)


# what may be at an end of a part; ``gain`` of each: mass, impulse, energy


class Closed(NamedTuple):
    """Nothing passes."""

    kind: int = 0

    def add(self, part, q, rates, gain):
        """Nothing."""
        return None


class OpenEnd(NamedTuple):
    """An open end of a gas: see fsipetsc.scheme.faces.open_face."""

    face: Any
    outside: Array
    pressure: Array

    def add(self, part, q, rates, gain):
        """What passes."""
        data = self.outside, self.pressure
        open_face(part.gas.law, self.face, q, part.metrics, *data, rates, gain)


class HeatedEnd(NamedTuple):
    """heat: (n,) [W] comes in."""

    face: Any
    heat: Array

    def add(self, part, q, rates, gain):
        """Heat."""
        heat_face(self.face, self.heat, part.inertia, rates, rates.shape[1] - 1, gain)


class LoadedEnd(NamedTuple):
    """forces: (n, 1) [N] push an end of a solid, heat: (n,) [W] comes in."""

    face: Any
    forces: Array
    heat: Array

    def add(self, part, q, rates, gain):
        """Forces and heat."""
        push_face(self.face, self.forces, q, part.inertia, rates, gain)
        heat_face(self.face, self.heat, part.inertia, rates, 2, gain)


class AbsorbingEnd(NamedTuple):
    """An end of a solid that lets waves out; stress: (n,) [Pa] pulls from outside. S, weight: of
    the band; none: (1, N) zeros.
    """

    face: Any
    forces: Array
    heat: Array
    stress: Array
    S: Array
    weight: Array
    none: Array

    def add(self, part, q, rates, gain):
        """Forces and heat."""
        at, A = self.face.ghosted, part.metrics[0]
        F = tangent(at, self.S, self.weight, 1, q.shape[0], self.none, q)
        for i in range(at.size):
            F[i, 0] = 1.0 + F[i, 0] * A[at[i]] / part.metrics[1, at[i]]
        forces = self.forces.copy()
        absorb(part.solid, LINE, self.face, F.T, self.stress, q, part.metrics, forces)
        push_face(self.face, forces, q, part.inertia, rates, gain)
        heat_face(self.face, self.heat, part.inertia, rates, 2, gain)


# dissipation


class Undamped(NamedTuple):
    """No dissipation."""

    kind: int = 0

    def add(self, part, q, rates):
        """Nothing."""
        return None


class GasDamping(NamedTuple):
    """See fsipetsc.scheme.gas_dissipation."""

    sigma: float
    shock: float
    differences: Any
    room: Any

    def add(self, part, q, rates):
        """Both terms."""
        sizes, of_patch = (self.sigma, self.shock), (self.differences, part.patch)
        equations = part.gas, LINE, part.form
        more = *part.S, *of_patch, rates, self.room
        gas_dissipation(*equations, *sizes, q, part.metrics, *more)


class SolidDamping(NamedTuple):
    """See fsipetsc.scheme.solid_dissipation. after: the next term, or none."""

    damping: Any
    differences: Any
    room: Any
    after: Any

    def add(self, part, q, rates):
        """This term and the next one."""
        of_patch = self.differences, part.patch
        solid_dissipation(LINE, self.damping, q, part.metrics, *of_patch, rates, self.room)
        self.after.add(part, q, rates)


# parts


class GasLine(NamedTuple):
    """A part of a gas block.

    begin: of its unknowns in the world vector. halo: (N, 4), its nodes with a halo, or (0, 4).
    S, weight: of three bands. first: of its own nodes in the ghosted array. masses: (M,) weights.
    follows: (n,) particles by which its ends move, here: (n, 2) their displacement and velocity;
    known: (m, 2) those of all ranks, of the columns ``ends`` of moved, moving: (1, ends of the
    block). low, high: (N,) weights of the ends. reference: (M,) J of the reference map. forcing:
    (3, M), or (3, 0). column: of its mass in ``gain``; columns: of its sums in the record.
    """

    gas: Any
    form: Any
    friction: Any
    dissipation: Any
    at_low: Any
    at_high: Any
    block: int
    begin: int
    column: int
    halo: Array
    metrics: Array
    inertia: Array
    S: Any
    weight: Any
    patch: Any
    work: Any
    per_h: Array
    row: Array
    masses: Array
    follows: Array
    here: Array
    known: Array
    ends: Array
    moved: Array
    moving: Array
    low: Array
    high: Array
    reference: Array
    forcing: Array
    came: Array
    seen: Array
    sums: Array
    columns: Array


class SolidLine(NamedTuple):
    """A part of a solid block; what has the same name as in GasLine is the same.

    inertia: (N,) J0 m0, masses: (M,) weights times J0 m0. F: (1, M), as the last look found it.
    forcing: (3, M), or (3, 0), of velocity, temperature and place. interfaces: (n, 5) number of an
    interface at this part, owned and ghosted row of its node, X, prestress.
    """

    solid: Any
    dissipation: Any
    at_low: Any
    at_high: Any
    block: int
    begin: int
    halo: Array
    metrics: Array
    inertia: Array
    prestress: Array
    patch: Any
    work: Any
    per_h: Array
    masses: Array
    F: Array
    forcing: Array
    came: Array
    seen: Array
    sums: Array
    columns: Array
    interfaces: Array


# what is done with a part; each is in a fsipetsc.operators.boxed.Box


@njit(**MERGED_CALL)
def owned(part, s, dof):
    """(M, dof), this part of a world vector s."""
    n = part.patch.own[0]
    return s[part.begin : part.begin + n * dof].reshape((n, dof))


@njit(**MERGED_CALL)
def ghosted(part, s, dof):
    """(N, dof), the same with its halo, if it has one."""
    n = part.patch.own[0]
    own = s[part.begin : part.begin + n * dof].reshape((n, dof))
    return part.halo if part.halo.shape[0] > 0 else own


def follow_gas(box, particles):
    """Tell a gas displacement and velocity of the particles here by which it moves."""
    gas, p = box.value, particles.value
    for m in range(gas.follows.size):
        n = gas.follows[m]
        if p.moves[n] and p.state.solid_mass[n] == 0.0:
            gas.here[m, 0], gas.here[m, 1] = p.place[n], p.data.wall[n, 0]
        else:
            gas.here[m, 0], gas.here[m, 1] = p.state.D[n, 0], p.state.v[n, 0]


def move_gas(box):
    """Velocity of a gas's grid and J_t = D v."""
    gas = box.value
    for m in range(gas.ends.size):
        gas.moved[0, gas.ends[m]] = gas.known[m, 0]
        gas.moving[0, gas.ends[m]] = gas.known[m, 1]
    at_low, at_high = gas.moving[0, 0], gas.moving[0, -1]
    for i in range(gas.low.size):
        gas.metrics[1, i] = gas.low[i] * at_low + gas.high[i] * at_high
        gas.metrics[2, i] = at_high - at_low


def rates_of_gas(box, s, f, gain):
    """Fill a gas's part of f, from that of a completed s; what comes in goes to ``gain``."""
    gas = box.value
    q, rates, came, patch = ghosted(gas, s, 4), owned(gas, f, 4), gas.came, gas.patch
    (S0, S1, S2), (w0, w1, w2), metrics = gas.S, gas.weight, gas.metrics
    laws, form, friction = gas.gas, gas.form, gas.friction
    gas_rates(
        laws, LINE, form, friction, q, metrics, S0, S1, S2, w0, w1, w2, patch, rates, gas.work
    )
    gas.dissipation.add(gas, q, rates)
    came[0] = came[1] = came[2] = 0.0
    gas.at_low.add(gas, q, rates, came)
    gas.at_high.add(gas, q, rates, came)
    force, first = laws.force[0], patch.first[0]
    if force != 0.0:
        for i in range(gas.masses.size):
            came[1] += force * gas.masses[i] * q[first + i, 1]
            came[2] += force * gas.masses[i] * q[first + i, 2]
    for c in range(3 * min(gas.forcing.shape[1], 1)):
        for i in range(gas.masses.size):
            supplied = q[first + i, 0] * gas.forcing[c, i]
            rates[i, 1 + c] += supplied
            came[c] += gas.masses[i] * supplied
    gain[gas.column] += came[0]
    gain[gain.size - 2] += came[1]
    gain[gain.size - 1] += came[2]


def rates_of_solid(box, s, f, gain):
    """The same of a solid."""
    solid = box.value
    q, rates, came = ghosted(solid, s, 3), owned(solid, f, 3), solid.came
    laws, first, forced = solid.solid, solid.patch.first[0], solid.forcing.shape[1] > 0
    solid_rates(laws, LINE, q, solid.metrics, solid.prestress, rates, solid.work)
    solid.dissipation.add(solid, q, rates)
    came[0] = came[1] = came[2] = 0.0
    solid.at_low.add(solid, q, rates, came)
    solid.at_high.add(solid, q, rates, came)
    force = laws.force[0]
    if force != 0.0 or forced:
        for i in range(solid.masses.size):
            v, mass = q[first + i, 1], solid.masses[i]
            came[1] += mass * force
            came[2] += mass * force * v
            if forced:
                push = solid.forcing[0, i]
                heat = laws.alpha * solid.forcing[1, i] + v * push
                rates[i, 0] += solid.forcing[2, i]
                rates[i, 1] += push
                rates[i, 2] += heat
                came[1] += mass * push
                came[2] += mass * heat
    gain[gain.size - 2] += came[1]
    gain[gain.size - 1] += came[2]


def look_at_gas(box, s):
    """Fill seen and sums of a gas."""
    gas = box.value
    q, seen, first, (w0, w1, w2) = ghosted(gas, s, 4), gas.seen, gas.patch.first[0], gas.weight
    laws, metrics, stiffness = gas.gas, gas.metrics, STIFFNESS_OF_WIDE
    gas_look(
        laws, LINE, q, metrics, gas.per_h, stiffness, w0, w1, w2, gas.patch, gas.row, seen, gas.sums
    )
    if seen[BAD] != 0.0:  # no NaN may stay there for a step that is made again
        clear(gas.work.w)
    longer, error, least = gas.moved[0, -1] - gas.moved[0, 0], 0.0, np.inf
    for i in range(gas.reference.size):
        J, own = q[first + i, 0], gas.reference[i] + longer
        error = max(error, abs(J - own) / abs(own))
        least = min(least, J / gas.reference[i])
    seen[J_ERROR], seen[LEAST_J] = error, -least


def look_at_solid(box, s):
    """Fill seen, sums and F of a solid."""
    solid = box.value
    q, laws, seen, sums = ghosted(solid, s, 3), solid.solid, solid.seen, solid.sums
    metrics, prestress, per_h = solid.metrics, solid.prestress, solid.per_h
    masses, work, F, stiffness = solid.masses, solid.work, solid.F, STIFFNESS_OF_WIDE
    solid_look(laws, LINE, q, metrics, prestress, per_h, stiffness, masses, work, F, seen, sums)


@njit(**MERGED_CALL)
def note(part, found):
    """Put the extremes and sums of a look where they belong."""
    begin = 1 + part.seen.size * part.block
    for c in range(part.seen.size):
        found.extremes[begin + c] = part.seen[c]
    found.extremes[begin + CONVECTION] *= found.pace
    for c in range(part.sums.size):
        found.latest[part.columns[c]] += part.sums[c]


def note_gas(box, found):
    """Note what was seen of a gas; found: fsipetsc.scheme.line_steps.Found."""
    note(box.value, found)


def note_solid(box, found):
    """Note what was seen of a solid, and what is recorded of interfaces."""
    solid, at_ends = box.value, found.at_ends
    note(solid, found)
    q = ghosted(solid, found.y, 3)
    for m in range(solid.interfaces.shape[0]):
        number, own, at = solid.interfaces[m, 0], solid.interfaces[m, 1], solid.interfaces[m, 2]
        X, S = solid.interfaces[m, 3], solid.interfaces[m, 4]
        of_end = at_ends[:, int(number)]
        look_at_end(solid.solid, q, solid.F, int(at), int(own), S, of_end)
        of_end[0] += X


def stay(box):
    """Solids have no grid to move."""
    return None


def stay_as(box, particles):
    """Nor does it follow others."""
    return None


def _is_gas(box):
    return box.field_dict["value"].instance_class is GasLine


# methods of boxes in compiled code, compiled with what calls them


@overload_method(BoxType, "rates", jit_options=CALLED)
def _rates(box, s, f, gain):
    return rates_of_gas if _is_gas(box) else rates_of_solid


@overload_method(BoxType, "look", jit_options=CALLED)
def _look(box, s):
    return look_at_gas if _is_gas(box) else look_at_solid


@overload_method(BoxType, "note", jit_options=CALLED)
def _note(box, found):
    return note_gas if _is_gas(box) else note_solid


@overload_method(BoxType, "follow", jit_options=CALLED)
def _follow(box, particles):
    return follow_gas if _is_gas(box) else stay_as


@overload_method(BoxType, "move", jit_options=CALLED)
def _move(box):
    return move_gas if _is_gas(box) else stay


# the same from Python


@njit(**CALL)
def rates_of(box, s, f, gain):
    """Fill a part of f, from that of a completed s; what comes in goes to ``gain``."""
    box.rates(s, f, gain)


@njit(**CALL)
def look_at(box, s):
    """Fill seen and sums of a part."""
    box.look(s)


@njit(**CALL)
def follow(box, particles):
    """Tell a part displacement and velocity of the particles by which it moves."""
    box.follow(particles)


@njit(**CALL)
def move(box):
    """Let the grid of a part have the velocity of its ends."""
    box.move()


@njit(**INNER_LOOP)
def clear(numbers):
    """Zeros."""
    for i in range(numbers.size):
        numbers[i] = 0.0
