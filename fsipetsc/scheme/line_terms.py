"""What acts on a part of a block in one dimension beside its volume terms: its two ends, dissipation.

Each is a record whose method ``add`` adds it to the rates of a part, a record of
fsipetsc.scheme.line_parts; the loops are those of all dimensions.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from fsipetsc.scheme.faces import absorb, heat_face, open_face, push_face, tangent
from fsipetsc.scheme.gas_dissipation import gas_dissipation
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.solid_dissipation import solid_dissipation

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
