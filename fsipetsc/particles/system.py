"""The particles in which a rank takes part: tables for its procedures, exchanges with other
ranks, prescribed data.

Owners of the members of a particle send each other what is extensive of them; each adds it up in
the same order and solves the same small system: see fsipetsc.particles.procedures.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.kernels.unit import unit
from fsipetsc.parallel.block_layout import PARTICLES_TAG, BlockLayout
from fsipetsc.particles import procedures as of
from fsipetsc.particles import records
from fsipetsc.particles.members import ROLLS, Particle
from fsipetsc.particles.messages import ParticleExchange
from fsipetsc.particles.prescribed import Prescribed
from fsipetsc.particles.shared_heat import weigh_heat
from fsipetsc.scheme import normals as of_faces

Array = NDArray[Any]


class ParticleSystem:
    """Particles with a member on this rank. Making one is collective on ``layout.comm``.

    inertia: block -> (ghosted nodes,), J0 m0 of solids. instant: says a time [s] in which little
    happens, for differences in time of what moves.

    record: all that procedures take. does: these by their names, once they are recorded. sums,
    areas, stored: exchanges of what members add up, of their area vectors, of their elastic
    energies. slips: whether there are constraints anywhere; stores: whether elastic energies matter
    to temperatures. nodes: block -> (numbers of this rank's nodes that are members, their particles
    here). telling: block of a solid -> (rows of the table, numbers of nodes) of those here whose
    elastic energy is wanted.
    """

    def __init__(
        self,
        layout: BlockLayout,
        particles: Sequence[Particle],
        inertia: dict[int, Array],
        instant: Callable[[], float],
    ) -> None:
        self._layout, d = layout, layout.problem.dimension
        members, owners = _members(layout, particles)
        here = np.unique(members[owners == layout.comm.rank, 0])
        local = np.full(len(particles), -1)
        local[here] = np.arange(here.size)
        taken = local[members[:, 0]] >= 0
        #: block and node of the members of the particles here
        self._members, owners = members[taken, 1:], owners[taken]
        self._particles, number = [particles[p] for p in here], local[members[taken, 0]]
        self.stores = any(p.stores for p in particles)
        self.slips = any(p.constraints for p in particles)
        most = max([1, *(len(p.constraints) for p in particles)])
        columns = max(d + 3, 2 * d + 1), 2 * most * d, 1
        self.sums, self.areas, self.stored = [
            ParticleExchange(layout.comm, tag, number, owners, n)
            for tag, n in enumerate(columns, PARTICLES_TAG)
        ]
        self._mine, self.nodes, self.telling = self.sums.mine, {}, {}
        stored = np.array([p.stores for p in self._particles], bool)
        for k in layout.parts:
            rows = self._rows_of(k)
            nodes, own = self._nodes_at(rows), number[self._mine[rows]]
            order = np.argsort(nodes)
            self.nodes[k] = nodes[order], own[order]
            if k in inertia:
                self.telling[k] = rows[stored[own]], nodes[stored[own]]
        self.table = self._table(number, owners, most, inertia)
        n = here.size
        sums = *np.zeros((3, n)), np.zeros((n, d + 2)), *np.zeros((2, n, d)), *np.zeros((4, n))
        self.state = records.State(*sums, U_t=np.zeros((n, d + 2)), acceleration=np.zeros((n, d)))
        data = Prescribed(layout.problem, self._particles, instant, particles, here)
        self.prescribed = data
        moves = np.zeros(n, np.int64)
        moves[data.moving] = 1
        self.record = records.Particles(
            like=(0.0,) * d,
            table=self.table,
            laws=layout.problem.gas_laws.laws,
            data=data.data,
            state=self.state,
            stored=self.stored.table,
            rows=self.sums.table,
            stores=self.stores,
            slips=self.slips,
            normals=np.zeros((n, 2 * most * d)),
            turning=np.zeros((n, 2 * most * d)),
            of_normals=self.areas.table,
            of_particle=number,
            row_of=self.areas.row,
            matrix=np.zeros((most, most)),
            pi=np.zeros(most),
            pivots=np.zeros(most),
            moves=moves,
            place=data.displaced,
            auxiliary=layout.auxiliary,
        )
        self.does: dict[str, Procedure] = {}

    def procedures(self, gain: Any) -> Code:
        """What is done with particles, recorded; gain: fsipetsc.scheme.part.Gain. Once the code is
        loaded, and before anything else, ``does["weigh_heat"]()`` is to be called.
        """
        code, record = Code(unit({}, [])), self.record
        alone = of.weigh, of.end_normals, of.end_turning, of.begin_stored
        taking = of.end_sums, of.impose_conditions, of.end_rates
        takes = {f: (record,) for f in (*alone, weigh_heat)} | {f: (record, gain) for f in taking}
        for function, given in takes.items():
            name = function.__name__
            self.does[name] = code.procedure(name, function, *given)
        return code

    def _rows_of(self, k: int) -> Array:
        """Rows of the tables of this rank's members of block k."""
        return np.flatnonzero(self._members[self._mine, 0] == k)

    def _nodes_at(self, rows: Array) -> Array:
        """The nodes of these rows of the tables."""
        return self._members[self._mine[rows], 1]

    def _table(
        self, number: Array, owners: Array, most: int, inertia: dict[int, Array]
    ) -> records.Table:
        """What procedures take. most: constraints of a particle."""
        layout, row, size = self._layout, self.sums.row, len(number)
        count, blocks, of = len(self._particles), layout.problem.blocks, self._members[:, 0]
        kind, alpha = np.empty(size, np.int64), np.zeros(size)
        kind[row] = [records.SOLID if blocks[k].kind == "solid" else records.GAS for k in of]
        alpha[row] = [getattr(blocks[k].material, "alpha", 0.0) for k in of]
        (at, apart), booked = np.empty((2, self._mine.size), np.int64), np.zeros(self._mine.size)
        weight = self.sums.table[:, 0]  # H of gas members, M_s of solid ones
        for k, part in layout.parts.items():
            rows = self._rows_of(k)
            nodes = part.ghosted_rows(part.rows(self._nodes_at(rows)))
            weight[rows] = part.weights(nodes) * (inertia[k][nodes] if k in inertia else 1.0)
            at[rows], apart[rows] = part.at(self._nodes_at(rows)), part.numbers.size
            booked[rows] = weight[rows] * layout.problem.loses(k)
        constraint = np.zeros((count, most), np.int64)
        for p, particle in enumerate(self._particles):
            constraint[p, : len(particle.constraints)] = [c.kind for c in particle.constraints]
        begin = np.searchsorted(number, np.arange(count + 1))
        gases = [k for k, block in enumerate(blocks) if block.kind == "fluid"]
        through = layout.problem.column_of_face
        facts = np.zeros(count, records.FACTS)
        for p, particle in enumerate(self._particles):
            mine = owners[begin[p]] == layout.comm.rank
            column = next((gases.index(k) for k, _ in particle.members if k in gases), 0)
            faces = [through.get(face, len(through)) for face in _faces(particle)]
            law = layout.problem.gas_laws.number_at(particle.members)
            facts[p] = mine, *_flags(particle), *faces, len(particle.constraints), column, law
        return records.Table(
            begin=begin,
            row=row,
            kind=kind,
            at=at,
            apart=apart,
            weight=weight.copy(),  # of others: once `begin` is called
            alpha=alpha,
            inertia=booked,
            constraint=constraint,
            facts=facts,
        )

    def faces_at(self, k: int) -> of_faces.Faces:
        """The faces of block k at members here whose area vectors make the normals of constraints.

        A member's row has G and S of each constraint; a face of the gas at a solid is in both.
        """
        d, found, nodes = self._layout.problem.dimension, [], self._rows_of(k)
        row_of = dict(zip(self._nodes_at(nodes).tolist(), nodes.tolist(), strict=True))
        for particle in self._particles:
            for c, (kind, walls, solids) in enumerate(particle.constraints):
                on_gas, on_solid = 2 * c * d, (2 * c + 1) * d
                parts = [(face, on_solid if kind == ROLLS else on_gas, 1.0) for face in walls]
                parts += [(face, on_gas, 1.0) for face in solids]
                parts += [(face, on_solid, -1.0) for face in solids]
                for (m, axis, side), column, sign in parts:
                    block, node = particle.members[m]
                    if block == k and node in row_of:
                        found.append((row_of[node], node, axis, sign if side else -sign, column))
        return of_faces.listed(self._layout.parts[k], found)

    def begin(self) -> None:
        """Learn weights of the members of others, and mean specific heats, once procedures and
        exchanges are loaded. Collective.
        """
        self.sums.table[:, 0] = self.table.weight
        self.sums()
        self.table.weight[:] = self.sums.table[:, 0]
        self.does["weigh_heat"]()

    def at_walls(self, k: int) -> tuple[Array, Array]:
        """Nodes of a gas block here that stick to walls, and velocities (n, d) of these."""
        nodes, particle = self.nodes[k]
        at_wall = self.table.facts["at_wall"][particle] == 1
        return nodes[at_wall], self.prescribed.data.wall[particle[at_wall]]

    def walls_away(self, k: int) -> float:
        """Largest displacement [m] of a wall of gas block k that moves, of those here."""
        alone = self.prescribed.moving[self.state.solid_mass[self.prescribed.moving] == 0.0]
        walls = np.intersect1d(self.nodes[k][1], alone)
        displaced = np.linalg.norm(self.prescribed.displaced[walls], axis=1)
        return float(displaced.max(initial=0.0))

    def destroy(self) -> None:
        """Release the messages."""
        for exchange in (self.sums, self.areas, self.stored):
            exchange.destroy()


def _flags(p: Particle) -> list[bool]:
    """FLAGS of fsipetsc.particles.records, but for the first one."""
    found = [
        not (p.wall or p.given_gas or (p.sticks and (p.clamp or p.given_solid))),
        not (p.clamp or p.given_solid),
        p.clamp and p.clamp.x,
        p.sticks,
        p.wall,
        p.clamp,
        p.given_gas,
        p.given_solid,
        p.warm_gas,
        p.warm_solid or p.given_solid,
        p.shares_heat,
        p.one_T,
    ]
    return [bool(flag) for flag in found]


def _faces(p: Particle) -> list[Any]:
    """(block, axis, side) of what moves gas and solid and of what warms them; None: of no face."""
    solid = "given_solid" if "given_solid" in p.faces else "warm_solid"
    return [p.faces.get(n) for n in (p.mover(True), p.mover(False), "warm_gas", solid)]


def _members(layout: BlockLayout, particles: Sequence[Particle]) -> tuple[Array, Array]:
    """(n, 3), particle, block, node of all members, by particle; and the ranks that own them."""
    listed = [(p, k, n) for p, one in enumerate(particles) for k, n in one.members]
    members = np.array(listed, np.int64).reshape(-1, 3)
    owners = np.empty(len(members), np.int64)
    for k in range(len(layout.problem.blocks)):
        of_block = members[:, 1] == k
        owners[of_block] = layout.shares[k].owners(members[of_block, 2])
    return members, owners
