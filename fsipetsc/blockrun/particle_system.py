"""The particles in which a rank takes part: tables for the compiled code, exchanges with other
ranks, prescribed data.

Owners of the members of a particle send each other what is extensive of them; each adds it up in
the same order and solves the same small system. See fsipetsc.scheme.particles for what is solved.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.blockrun.columns import loses
from fsipetsc.blockrun.face_terms import weights_of
from fsipetsc.blockrun.prescribed import Prescribed
from fsipetsc.blocks.conditions import moves
from fsipetsc.blocks.particles import ROLLS, Particle
from fsipetsc.operators.boxed import Box, with_calls
from fsipetsc.parallel.block_layout import BlockLayout
from fsipetsc.parallel.particle_exchange import ParticleExchange
from fsipetsc.scheme import normals as of_faces
from fsipetsc.scheme import particles as kernels
from fsipetsc.scheme.particle_heat import weigh_heat
from fsipetsc.scheme.particle_records import (
    FACTS,
    GAS,
    SOLID,
    ParticleCalls,
    Particles,
    State,
    Table,
)

Array = NDArray[Any]


class ParticleSystem:
    """Particles with a member on this rank. Making one is collective on ``layout.comm``.

    law: of the gas, any law where there is no gas. inertia: block -> (ghosted nodes,), J0 m0 of
    solids. instant: says a time [s] in which little happens, for differences in time of what moves.

    nodes: block -> (numbers of this rank's nodes that are members, their particles here). stores:
    whether elastic energies of members matter to temperatures anywhere; then members: block ->
    (rows of the table, numbers of nodes) of those here whose energy is wanted.
    """

    def __init__(
        self,
        layout: BlockLayout,
        particles: Sequence[Particle],
        law: Any,
        inertia: dict[int, Array],
        instant: Callable[[], float],
    ) -> None:
        self._layout, self._d = layout, layout.problem.blocks[0].dimension
        members, owners = _members(layout, particles)
        rank = layout.comm.rank
        here = np.unique(members[owners == rank, 0])
        local = np.full(len(particles), -1)
        local[here] = np.arange(here.size)
        taken = local[members[:, 0]] >= 0
        members, owners = members[taken], owners[taken]
        self._particles = [particles[p] for p in here]
        number = local[members[:, 0]]
        columns = max(self._d + 3, 2 * self._d + 1)
        self._exchange = ParticleExchange(layout.comm, number, owners, columns, tag=1)
        self.table = self._table(number, members, owners, inertia)
        mine, self.nodes = self._exchange.mine, {}
        for part in layout.parts:
            of_block = mine[members[mine, 1] == part.k]
            order = np.argsort(members[of_block, 2])
            self.nodes[part.k] = members[of_block, 2][order], number[of_block][order]
        self._constraints(number, members, owners)
        self._storing(particles, number, members, owners)
        n, d = here.size, self._d
        sums = *np.zeros((3, n)), np.zeros((n, d + 2)), *np.zeros((2, n, d)), *np.zeros((4, n))
        self.state = State(*sums, U_t=np.zeros((n, d + 2)), acceleration=np.zeros((n, d)))
        self.prescribed = Prescribed(layout.problem, self._particles, law, instant)
        moves = np.zeros(n, np.int64)
        moves[self.prescribed.moving] = 1
        self.box = Box(  # all that compiled code takes
            Particles(
                like=(0.0,) * d,
                table=self.table,
                law=law,
                data=self.prescribed.data,
                state=self.state,
                stored=self._stored,
                rows=self._exchange.table,
                stores=int(self.stores),
                slips=int(self.slips),
                normals=self.normals,
                turning=self.turning,
                of_normals=self._normal_exchange.table,
                of_particle=self._normal_particles,
                row_of=self._normal_exchange.row,
                moves=moves,
                place=self.prescribed.displaced,
                auxiliary=layout.auxiliary,
            )
        )
        weigh_heat(self.box)

    def _table(
        self, number: Array, members: Array, owners: Array, inertia: dict[int, Array]
    ) -> Table:
        """What the compiled code takes. members: (n, 3), particle, block, node."""
        layout, row, mine = self._layout, self._exchange.row, self._exchange.mine
        count, blocks = len(self._particles), layout.problem.blocks
        kind, alpha = np.empty(len(members), np.int64), np.zeros(len(members))
        kind[row] = [SOLID if blocks[k].kind == "solid" else GAS for k in members[:, 1]]
        alpha[row] = [getattr(blocks[k].material, "alpha", 0.0) for k in members[:, 1]]
        at, weight = np.empty(mine.size, np.int64), self._weights(members, inertia)
        booked = np.zeros(mine.size)
        for part in layout.parts:
            own = members[mine, 1] == part.k
            at[own] = part.at(members[mine[own], 2])
            booked[own] = weight[: mine.size][own] * loses(layout.problem, part.k)
        most = max([1, *(len(p.constraints) for p in self._particles)])
        most = layout.comm.allreduce(most, op=MPI.MAX)  # rows of all ranks are of one length
        constraint = np.zeros((count, most), np.int64)
        for p, particle in enumerate(self._particles):
            constraint[p, : len(particle.constraints)] = [c.kind for c in particle.constraints]
        begin = np.searchsorted(number, np.arange(count + 1))
        gases = [k for k, block in enumerate(blocks) if block.kind == "fluid"]
        through = layout.problem.column_of_face
        facts = np.zeros(count, FACTS)
        for p, particle in enumerate(self._particles):
            mine = owners[begin[p]] == layout.comm.rank
            column = next((gases.index(k) for k, _ in particle.members if k in gases), 0)
            faces = [through.get(face, len(through)) for face in _faces(particle)]
            facts[p] = mine, *_flags(particle), *faces, len(particle.constraints), column
        return Table(
            begin=begin,
            row=row,
            kind=kind,
            at=at,
            weight=weight,
            alpha=alpha,
            inertia=booked,
            constraint=constraint,
            facts=facts,
        )

    def _weights(self, members: Array, inertia: dict[int, Array]) -> Array:
        """(rows,) H of gas members, M_s of solid ones, of all ranks."""
        exchange = self._exchange
        for part in self._layout.parts:
            rows = np.flatnonzero(members[exchange.mine, 1] == part.k)
            nodes = part.ghosted_rows(part.rows(members[exchange.mine[rows], 2]))
            mass = inertia[part.k][nodes] if part.k in inertia else 1.0
            exchange.table[rows, 0] = weights_of(part, nodes) * mass
        exchange.exchange()
        return exchange.table[:, 0].copy()

    # elastic energies of members

    def _storing(
        self, particles: Sequence[Particle], number: Array, members: Array, owners: Array
    ) -> None:
        """Which members of this rank tell the others what they store."""
        self.stores, self.members = any(p.stores for p in particles), {}
        self._store_exchange = ParticleExchange(self._layout.comm, number, owners, 1, tag=4)
        self._stored, mine = self._store_exchange.table, self._store_exchange.mine
        wanted = np.array([p.stores for p in self._particles], bool)[number[mine]]
        for part in self._layout.parts:
            if self._layout.problem.blocks[part.k].kind == "solid":
                rows = np.flatnonzero(wanted & (members[mine, 1] == part.k))
                self.members[part.k] = rows, members[mine[rows], 2]

    # normals of constraints

    def _constraints(self, number: Array, members: Array, owners: Array) -> None:
        """Lists of the faces whose area vectors make the normals, and their exchange.

        A member's row has G and S of each constraint; a face of the gas at a solid is in both.
        """
        layout, d = self._layout, self._d
        bound = np.array([len(p.constraints) > 0 for p in self._particles], bool)
        chosen = bound[number]
        self._normal_particles = number[chosen]
        K = self.table.constraint.shape[1]
        self.slips = layout.comm.allreduce(int(bound.any()), op=MPI.MAX) > 0
        self.normals, self.turning = np.zeros((2, bound.size, K * 2 * d))
        exchange = ParticleExchange(layout.comm, number[chosen], owners[chosen], 2 * K * d, tag=2)
        self._normal_exchange = exchange
        mine = np.flatnonzero(chosen)[exchange.mine]
        place = {(int(k), int(n)): row for row, (_, k, n) in enumerate(members[mine].tolist())}
        found: dict[int, list[tuple[int, int, int, float, int]]] = {p.k: [] for p in layout.parts}
        for particle in self._particles:
            for c, (kind, walls, solids) in enumerate(particle.constraints):
                on_gas, on_solid = 2 * c * d, (2 * c + 1) * d
                parts = [(face, on_solid if kind == ROLLS else on_gas, 1.0) for face in walls]
                parts += [(face, on_gas, 1.0) for face in solids]
                parts += [(face, on_solid, -1.0) for face in solids]
                for (m, axis, side), column, sign in parts:
                    k, node = particle.members[m]
                    if (k, node) in place:
                        outward = sign if side else -sign
                        found[k].append((place[k, node], node, axis, outward, column))
        self.at_faces = {k: of_faces.listed(layout.part(k), rows) for k, rows in found.items()}

    def find_normals(self, add: Callable[[Array], None], turning: bool) -> None:
        """``normals``, or ``turning``, how they change in time. Collective among neighbours.

        add: adds area vectors of faces, or how these turn, to the rows of members.
        """
        if self.slips:
            add(self._normal_exchange.table)
            self._normal_exchange.exchange()
            kernels.end_normals(self.box, turning)

    def find_stored(self, y: Array, store: Callable[[], None]) -> None:
        """What particles store; store: members of solids tell it. Collective among neighbours."""
        if self.stores:
            kernels.begin_stored(self.box, y)
            store()
            self._store_exchange.exchange()
            weigh_heat(self.box)

    # what the scheme calls; gain: masses, impulse and energy that come in. `share` begins it, the
    # others add to it

    def share(self, y: Array, gain: Array) -> None:
        """Sums of the members; ``state`` has what the particles share, but for slipping and
        temperatures.
        """
        kernels.weigh(self.box, y)
        self._exchange.exchange()
        kernels.end_sums(self.box, gain)

    def constrain(self, y: Array, f: Array, gain: Array) -> None:
        """Rates of all members under the constraints of their particles, and of what comes in, in
        place.
        """
        kernels.weigh(self.box, f)
        self._exchange.exchange()
        kernels.end_rates(self.box, y, f, gain)

    def calls(self, y: Array, gain: Array) -> Any:
        """All that compiled code takes with what it calls; y, gain: examples of what these take."""
        calls = (
            (kernels.weigh, (y,)),
            (kernels.end_sums, (gain,)),
            (kernels.end_normals, (True,)),
            (kernels.begin_stored, (y,)),
            (weigh_heat, ()),
            (kernels.impose_conditions, (y, gain)),
            (kernels.end_rates, (y, y, gain)),
        )
        return with_calls(ParticleCalls, self.box, calls)

    def at_walls(self, k: int) -> tuple[Array, Array]:
        """Nodes of a gas block here that stick to walls, and velocities (n, d) of these."""
        nodes, particle = self.nodes[k]
        at_wall = self.table.facts["at_wall"][particle] == 1
        return nodes[at_wall], self.prescribed.data.wall[particle[at_wall]]

    def walls_away(self) -> dict[int, float]:
        """Block of gas -> largest displacement [m] of a wall of it that moves, of those here."""
        found: dict[int, float] = {}
        for p in self.prescribed.moving:
            if self.state.solid_mass[p] == 0.0:
                for k, _ in self._particles[p].members:
                    distance = float(np.linalg.norm(self.prescribed.displaced[p]))
                    found[k] = max(found.get(k, 0.0), distance)
        return found

    def destroy(self) -> None:
        """Release the messages."""
        for exchange in (self._exchange, self._normal_exchange, self._store_exchange):
            exchange.destroy()


def _flags(p: Particle) -> list[bool]:
    """FLAGS of fsipetsc.scheme.particle_records, but for the first one."""
    found = [
        not (p.wall or p.given_gas or (p.sticks and (p.clamp or p.given_solid))),
        not (p.clamp or p.given_solid or (p.sticks and p.wall)),
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
    """(block, axis, side) of what moves gas and solid and of what warms them; None: of no face.
    Those that Prescribed prefers come first.
    """
    slips = p.slip and moves(p.slip) and not (p.wall and moves(p.wall))
    walls = ("slip", "wall") if slips else ("wall", "slip")
    gas, solid = ("given_gas", *walls), ("given_solid", "clamp")
    if p.sticks:  # a condition of one is one of both
        gas, solid = ("given_gas", "given_solid", "clamp", *walls), (*solid, *walls)
    names = gas, solid, ("warm_gas",), ("given_solid", "warm_solid")
    return [next((p.faces[n] for n in which if n in p.faces), None) for which in names]


def _members(layout: BlockLayout, particles: Sequence[Particle]) -> tuple[Array, Array]:
    """(n, 3), particle, block, node of all members, by particle; and the ranks that own them."""
    listed = [(p, k, n) for p, one in enumerate(particles) for k, n in one.members]
    members = np.array(listed, np.int64).reshape(-1, 3)
    owners = np.empty(len(members), np.int64)
    for k in range(len(layout.problem.blocks)):
        of_block = members[:, 1] == k
        owners[of_block] = layout.shares[k].owners(members[of_block, 2])
    return members, owners
