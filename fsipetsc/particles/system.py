"""The particles in which a rank takes part: their record for procedures, exchanges with other
ranks, prescribed data.

Owners of the members of a particle send each other what is extensive of them; each adds it up in
the same order and solves the same small system: see fsipetsc.particles.procedures. So the ranks
that own points of an interface exchange what the interface needs, and no sum is made by messages.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.kernels.kernel import unit
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.parallel.block_layout import PARTICLES_TAG, BlockLayout
from fsipetsc.parallel.exchange import RowExchange
from fsipetsc.particles import procedures as of
from fsipetsc.particles.constraints import weigh_heat
from fsipetsc.particles.members import GAS, ROLLS, SOLID, Particle
from fsipetsc.particles.prescribed import Data, Prescribed
from fsipetsc.scheme import normals as of_faces

Array = NDArray[Any]


class State(NamedTuple):
    """What sums and rates gave, for each of n particles in d dimensions."""

    mass: Array  #: (n,) of the gas
    solid_mass: Array  #: (n,)
    V: Array  #: (n,) volume of the gas
    U: Array  #: (n, d + 2) rho, rho u, E of the gas
    D: Array  #: (n, d) displacement of the solid
    v: Array  #: (n, d) velocity of the solid
    e: Array  #: (n,) energy per mass of the solid
    mean_energy: Array  #: (n,) that of its members before a change
    capacity: Array  #: (n,) mean specific heat of the solid
    potential: Array  #: (n,) its mean energy per mass that is neither kinetic nor heat
    U_t: Array  #: (n, d + 2)
    acceleration: Array  #: (n, d) of the solid


class Particles(NamedTuple):
    """The n particles of a rank in d dimensions, and their members, on this and other ranks: rows
    of tables, those of one particle together, in an order that all ranks have in common. A particle
    has K constraints at most.
    """

    like: Any  #: d zeros
    begin: Array  #: (n + 1,) particle p has the rows begin[p] … begin[p + 1] - 1
    mine: Array  #: (own,) rows of the members of this rank
    of_particle: Array  #: (rows,) particle of each member
    kind: Array  #: (rows,) GAS or SOLID
    at: Array  #: (rows,) place in the world vector of the first unknown of a member of this rank
    apart: Array  #: (rows,) how far its unknowns are apart there
    weight: Array  #: (rows,) H of a gas member, M_s of a solid one
    alpha: Array  #: (rows,) specific heat of solids
    inertia: Array  #: (rows,) M_s of members of this rank whose work is booked, else 0
    constraint: Array  #: (n, K) kinds of constraints
    facts: Array  #: (n,) records of what _facts says
    laws: Any  #: the different ones of gases
    data: Data
    state: State
    stored: Array  #: (rows, 1) energy per mass of members that is neither kinetic nor heat
    rows: Array  #: (rows, columns) what members add up
    stores: bool  #: whether energies that are neither kinetic nor heat change
    slips: bool  #: whether any particle has constraints
    normals: Array  #: (n, 2 d K) G and S of each constraint
    turning: Array  #: (n, 2 d K) how they turn
    of_normals: Array  #: (rows, 2 d K) area vectors of members
    matrix: Array  #: (K, K), (K,), (K,): room for the constraints of one particle
    pi: Array
    pivots: Array
    moves: Array  #: (n,) whether a wall there moves
    place: Array  #: (n, d) its displacement
    auxiliary: int  #: unknowns, at the end of a vector, of what came in


class ParticleSystem:
    """Particles with a member on this rank. Making one is collective on ``layout.comm``.

    inertia: block -> (ghosted nodes,), J0 m0 of solids. instant: says a time [s] in which little
    happens, for differences in time of what moves.

    record: all that procedures take. does: these by their names, once they are recorded. sums,
    areas, stored: exchanges of what members add up, of their area vectors, of their elastic
    energies. slips: whether there are constraints anywhere; stores: whether elastic energies matter
    to temperatures. nodes: block -> (numbers of this rank's nodes that are members, their particles
    here). telling: block of a solid -> (rows of tables, numbers of nodes) of those here whose
    elastic energy is wanted.
    """

    def __init__(
        self,
        layout: BlockLayout,
        particles: Sequence[Particle],
        inertia: dict[int, Array],
        instant: Callable[[], float],
    ) -> None:
        self._layout, d, me = layout, layout.problem.dimension, layout.comm.rank
        members, owners = _members(layout, particles)
        here = np.unique(members[owners == me, 0])
        taken = np.isin(members[:, 0], here)
        number, owners = np.searchsorted(here, members[taken, 0]), owners[taken]
        #: block and node of the members of the particles here, rows of those of this rank
        self._members, self._mine = members[taken, 1:], np.flatnonzero(owners == me)
        self._particles, n = [particles[p] for p in here], here.size
        self.stores = any(p.stores for p in particles)
        self.slips = any(p.constraints for p in particles)
        most = max([1, *(len(p.constraints) for p in particles)])
        ranks = {me, *owners.tolist()}
        wanted = {rank: np.isin(number, number[owners == rank]) for rank in sorted(ranks)}
        columns = max(d + 3, 2 * d + 1), 2 * most * d, 1
        self.sums, self.areas, self.stored = (
            RowExchange(layout.comm, tag, owners, wanted, c)
            for tag, c in enumerate(columns, PARTICLES_TAG)
        )
        self.prescribed = Prescribed(layout.problem, particles, here.tolist(), instant)
        moves = np.zeros(n, np.int64)
        moves[self.prescribed.moving] = 1
        sums = *np.zeros((3, n)), np.zeros((n, d + 2)), *np.zeros((2, n, d)), *np.zeros((4, n))
        self.record = Particles(
            like=(0.0,) * d,
            begin=np.searchsorted(number, np.arange(n + 1)),
            mine=self._mine,
            of_particle=number,
            **self._of_members(inertia),
            **self._of_particles(number, owners, most),
            laws=layout.problem.gas_laws,
            data=self.prescribed.data,
            state=State(*sums, U_t=np.zeros((n, d + 2)), acceleration=np.zeros((n, d))),
            stored=self.stored.table,
            rows=self.sums.table,
            stores=self.stores,
            slips=self.slips,
            normals=np.zeros((n, 2 * most * d)),
            turning=np.zeros((n, 2 * most * d)),
            of_normals=self.areas.table,
            matrix=np.zeros((most, most)),
            pi=np.zeros(most),
            pivots=np.zeros(most),
            moves=moves,
            place=self.prescribed.displaced,
            auxiliary=layout.auxiliary,
        )
        self.nodes, self.telling = {}, {}
        stored = np.array([p.stores for p in self._particles], bool)
        for k in layout.parts:
            rows, nodes = self._own_of(k)
            order = np.argsort(nodes)
            self.nodes[k] = nodes[order], number[rows[order]]
            if k in inertia:
                telling = stored[number[rows]]
                self.telling[k] = rows[telling], nodes[telling]
        self.does: dict[str, Procedure] = {}

    def procedures(self, gain: Any) -> Code:
        """What is done with particles, recorded; gain: fsipetsc.scheme.part.Gain. Once the code is
        loaded, and before anything else, ``does["weigh_heat"]()`` is to be called.
        """
        code, record = Code(unit({}, [])), self.record
        takes = {f.__name__: (f, record) for f in (of.weigh, of.begin_stored, weigh_heat)}
        taking_gain = of.end_sums, of.impose_conditions, of.end_rates
        takes |= {f.__name__: (f, record, gain) for f in taking_gain}
        for name, total in (("end_normals", record.normals), ("end_turning", record.turning)):
            takes[name] = of.gather, record, total
        self.does = {name: code.procedure(name, *given) for name, given in takes.items()}
        return code

    def _own_of(self, k: int) -> tuple[Array, Array]:
        """Rows of the tables and numbers of nodes of this rank's members of block k."""
        rows = self._mine[self._members[self._mine, 0] == k]
        return rows, self._members[rows, 1]

    def _of_members(self, inertia: dict[int, Array]) -> dict[str, Array]:
        """What the record has of members. Weights of others are 0 until `begin` is called."""
        blocks, of = self._layout.problem.blocks, self._members[:, 0]
        kind = np.array([SOLID if blocks[k].kind == "solid" else GAS for k in of], np.int64)
        alpha = np.array([getattr(blocks[k].material, "alpha", 0.0) for k in of])
        (at, apart), (weight, booked) = np.zeros((2, len(of)), np.int64), np.zeros((2, len(of)))
        for k, part in self._layout.parts.items():
            rows, numbers = self._own_of(k)
            nodes = part.patch.ghosted_rows(part.rows(numbers))
            weight[rows] = part.weights(nodes) * (inertia[k][nodes] if k in inertia else 1.0)
            at[rows], apart[rows] = part.at(numbers), part.numbers.size
            booked[rows] = weight[rows] * self._layout.problem.loses(k)
        found = {"kind": kind, "at": at, "apart": apart, "weight": weight, "alpha": alpha}
        return {**found, "inertia": booked}

    def _of_particles(self, number: Array, owners: Array, most: int) -> dict[str, Array]:
        """What the record has of particles: their facts and kinds of constraints."""
        problem, count, me = self._layout.problem, len(self._particles), self._layout.comm.rank
        gases = [k for k, block in enumerate(problem.blocks) if block.kind == "fluid"]
        first = np.searchsorted(number, np.arange(count))
        facts, constraint = np.zeros(count, FACTS), np.zeros((count, most), np.int64)
        for p, particle in enumerate(self._particles):
            constraint[p, : len(particle.constraints)] = [c.kind for c in particle.constraints]
            column = next((gases.index(k) for k, _ in particle.members if k in gases), 0)
            law = problem.law_at(particle.members)
            known = _facts(particle, owners[first[p]] == me, problem.column_of_face, column, law)
            facts[p] = tuple(known.values())
        return {"facts": facts, "constraint": constraint}

    def faces_at(self, k: int) -> of_faces.Faces:
        """The faces of block k at members here whose area vectors make the normals of constraints.

        A member's row has G and S of each constraint; a face of the gas at a solid is in both.
        """
        d, found, (rows, nodes) = self._layout.problem.dimension, [], self._own_of(k)
        row_of = dict(zip(nodes.tolist(), rows.tolist(), strict=True))
        for particle in self._particles:
            for c, (kind, walls, solids) in enumerate(particle.constraints):
                on_gas, on_solid = 2 * c * d, (2 * c + 1) * d
                parts = [(face, on_solid if kind == ROLLS else on_gas, 1.0) for face in walls]
                parts += [(face, on_gas, 1.0) for face in solids]
                parts += [(face, on_solid, -1.0) for face in solids]
                for (m, block, axis, side, _), column, sign in parts:
                    node = particle.members[m][1]
                    if block == k and node in row_of:
                        found.append((row_of[node], node, axis, sign if side else -sign, column))
        return of_faces.listed(self._layout.parts[k], found)

    def begin(self) -> None:
        """Learn weights of the members of others, and mean specific heats, once procedures and
        exchanges are loaded. Collective.
        """
        self.sums.table[:, 0] = self.record.weight
        self.sums()
        self.record.weight[:] = self.sums.table[:, 0]
        self.does["weigh_heat"]()

    def at_walls(self, k: int) -> tuple[Array, Array]:
        """Nodes of a gas block here that stick to walls, and velocities (n, d) of these."""
        nodes, particle = self.nodes[k]
        at_wall = self.record.facts["at_wall"][particle] == 1
        return nodes[at_wall], self.prescribed.data.wall[particle[at_wall]]

    def destroy(self) -> None:
        """Release the messages."""
        for exchange in (self.sums, self.areas, self.stored):
            exchange.destroy()


def _facts(
    p: Particle, mine: bool, through: Mapping[Any, int], column: int, law: int
) -> dict[str, int]:
    """What procedures know of a particle. mine: this rank adds what comes in there. through: face
    -> column of its energy in ``gain``. column: of the mass of its gas there. law: number of its.
    """
    flags = {
        "mine": mine,
        "free_gas": not (p.wall or p.given_gas or (p.sticks and (p.clamp or p.given_solid))),
        "free_solid": not (p.clamp or p.given_solid),
        "placed": p.clamp and p.clamp.x,  # a clamp gives the place
        "sticks": p.sticks,
        "at_wall": p.wall,
        "clamped": p.clamp,
        "given_gas": p.given_gas,
        "given_solid": p.given_solid,
        "warm_gas": p.warm_gas,  # its temperature is given
        "warm_solid": p.warm_solid or p.given_solid,
        "shares_heat": p.shares_heat,
        "one_T": p.one_T,
    }
    heats_solid = "given_solid" if "given_solid" in p.faces else "warm_solid"
    faces = {  # through which what moves it does work, and what gives it a temperature heats
        "moves_gas": p.mover(True),
        "moves_solid": p.mover(False),
        "heats_gas": "warm_gas",
        "heats_solid": heats_solid,
    }
    columns = {name: through.get(p.faces.get(by), len(through)) for name, by in faces.items()}
    numbers = {"count": len(p.constraints), "column": column, "law": law}
    return {name: int(bool(flag)) for name, flag in flags.items()} | columns | numbers


FACTS = np.dtype([(name, np.int64) for name in _facts(Particle([]), True, {}, 0, 0)], align=True)


def _members(layout: BlockLayout, particles: Sequence[Particle]) -> tuple[Array, Array]:
    """(n, 3), particle, block, node of all members, by particle; and the ranks that own them."""
    listed = [(p, k, n) for p, one in enumerate(particles) for k, n in one.members]
    members = np.array(listed, np.int64).reshape(-1, 3)
    owners = np.empty(len(members), np.int64)
    for k in range(len(layout.problem.blocks)):
        of_block = members[:, 1] == k
        owners[of_block] = layout.shares[k].owners(members[of_block, 2])
    return members, owners
