"""The particles in which a rank takes part: tables for the compiled code, exchanges with other ranks, prescribed data.

Owners of the members of a particle send each other what is extensive of them; each adds it up in the same order and solves the
same small system. See fsipetsc.scheme.particles for what is solved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.prescribed import Prescribed
from fsipetsc.blocks.particles import ROLLS, Particle
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.parallel.particle_exchange import ParticleExchange
from fsipetsc.scheme import normals as of_faces
from fsipetsc.scheme import particles as kernels
from fsipetsc.scheme.particles import GAS, SOLID, Data, State, Table

Array = NDArray[Any]


class ParticleSystem:
    """Particles with a member on this rank. Making one is collective on ``layout.comm``.

    law: of the gas, any law where there is no gas. inertia: block -> (ghosted nodes,), J0 m0 of
    solids. instant: says a time [s] in which little happens, for differences in time of what moves.

    nodes: block -> (numbers of this rank's nodes that are members, their particles here).
    """

    def __init__(
        self,
        layout: BlockLayout,
        particles: Sequence[Particle],
        law: Any,
        inertia: dict[int, Array],
        instant: Callable[[], float],
    ) -> None:
        self._layout, self._law, self._d = layout, law, layout.problem.blocks[0].dimension
        members, owners = _members(layout, particles)
        rank = layout.comm.rank
        here = np.unique(members[owners == rank, 0])
        local = np.full(len(particles), -1)
        local[here] = np.arange(here.size)
        taken = local[members[:, 0]] >= 0
        members, owners = members[taken], owners[taken]
        self._particles = [particles[p] for p in here]
        number = local[members[:, 0]]
        columns = max(self._d + 3, 2 * self._d + 2)
        self._exchange = ParticleExchange(layout.comm, number, owners, columns, tag=1)
        self.table = self._table(number, members, inertia)
        self.nodes = self._nodes(members, number)
        self._constraints(number, members, owners)
        self.state = _state(here.size, self._d)
        self.prescribed = Prescribed(layout.problem, self._particles, law, instant)
        self._energy = np.zeros((here.size, 2))
        self._energy[:, 1] = [self._alpha(p) for p in self._particles]
        self._rates = np.zeros((here.size, 2 * self._d + 3))

    def _table(self, number: Array, members: Array, inertia: dict[int, Array]) -> Table:
        """What the compiled code takes. members: (n, 3), particle, block, node."""
        layout, row, mine = self._layout, self._exchange.row, self._exchange.mine
        count, blocks = len(self._particles), layout.problem.blocks
        kind = np.empty(len(members), np.int64)
        kind[row] = [SOLID if blocks[k].kind == "solid" else GAS for k in members[:, 1]]
        at, weight = np.empty(mine.size, np.int64), np.zeros(len(members))
        for i, (_, k, node) in enumerate(members[mine].tolist()):
            part = layout.part(k)
            n = int(part.rows(np.array([node]))[0])
            ghosted = int(part.ghosted_rows(np.array([n]))[0])
            at[i] = part.begin + n * part.dof
            weight[i] = _weight(part, ghosted) * (inertia[k][ghosted] if k in inertia else 1.0)
        most = max([1, *(len(p.constraints) for p in self._particles)])
        constraint = np.zeros((count, most), np.int64)
        for p, particle in enumerate(self._particles):
            for c, (which, _) in enumerate(particle.constraints):
                constraint[p, c] = which

        def flags(of: Callable[[Particle], Any]) -> Array:
            return np.array([int(bool(of(p))) for p in self._particles], np.int64)

        return Table(
            begin=np.searchsorted(number, np.arange(count + 1)),
            row=row,
            kind=kind,
            at=at,
            weight=weight,
            count=np.array([len(p.constraints) for p in self._particles], np.int64),
            constraint=constraint,
            sticks=flags(lambda p: p.sticks),
            held_gas=flags(lambda p: p.wall is not None),
            held_solid=flags(lambda p: p.clamp is not None),
            given_gas=flags(lambda p: p.given_gas is not None),
            given_solid=flags(lambda p: p.given_solid is not None),
            warm=flags(lambda p: p.warm is not None),
            shares_heat=flags(lambda p: p.shares_heat),
            shares_energy=flags(lambda p: p.shares_energy),
        )

    def _nodes(self, members: Array, number: Array) -> dict[int, tuple[Array, Array]]:
        mine, found = self._exchange.mine, {}
        for part in self._layout.parts:
            of_block = mine[members[mine, 1] == part.k]
            order = np.argsort(members[of_block, 2])
            found[part.k] = members[of_block, 2][order], number[of_block][order]
        return found

    def _alpha(self, particle: Particle) -> float:
        blocks = [self._layout.problem.blocks[k] for k, _ in particle.members]
        return next((float(b.material.alpha) for b in blocks if b.kind == "solid"), 0.0)

    # normals of constraints

    def _constraints(self, number: Array, members: Array, owners: Array) -> None:
        """Lists of the faces whose area vectors make the normals, and their exchange."""
        layout, d = self._layout, self._d
        bound = np.array([len(p.constraints) > 0 for p in self._particles], bool)
        chosen = bound[number] if number.size else np.zeros(0, bool)
        K = self.table.constraint.shape[1]
        self.slips = layout.comm.allreduce(int(bound.any()), op=_largest()) > 0
        self.normals = np.zeros((bound.size, K, d))
        self.turning = np.zeros((bound.size, K, d))
        if not self.slips:
            return
        self._normal_exchange = ParticleExchange(layout.comm, number[chosen], owners[chosen], K * d, tag=2)
        mine = np.flatnonzero(chosen)[self._normal_exchange.mine]
        place = {(int(k), int(n)): row for row, (_, k, n) in enumerate(members[mine].tolist())}
        self._normal_rows = self._normal_exchange.row
        self._normal_particle = number[chosen]
        found: dict[int, list[tuple[int, int, int, float, int]]] = {part.k: [] for part in layout.parts}
        for particle in self._particles:
            for c, (which, faces) in enumerate(particle.constraints):
                for m, axis, side in faces:
                    k, node = particle.members[m]
                    if (k, node) in place:
                        found[k].append((place[k, node], node, axis, -1.0 if side == 0 else 1.0, c * d))
                        assert (which == ROLLS) == (layout.problem.blocks[k].kind == "solid")
        self._faces = {k: of_faces.listed(layout.part(k), rows) for k, rows in found.items() if rows}

    def find_normals(self, metrics: dict[int, Array]) -> None:
        """``normals`` from the metrics of the blocks, (…, ghosted nodes) each. Collective among neighbours."""
        if self.slips:
            self._sum_normals(self.normals, lambda k, out: of_faces.add_normals(self._faces[k], self._d, metrics[k], out))

    def find_turning(self, metrics: dict[int, Array]) -> None:
        """``turning``, how normals change in time, from the velocity of the grid in the metrics. Collective."""
        if self.slips:
            bands = {part.k: part.bands for part in self._layout.parts}
            kinds = [block.kind for block in self._layout.problem.blocks]

            def add(k: int, out: Array) -> None:
                if kinds[k] == "fluid":
                    of_faces.add_turning(self._faces[k], self._layout.part(k), bands[k], self._d, metrics[k], out)

            self._sum_normals(self.turning, add)

    def _sum_normals(self, total: Array, add: Callable[[int, Array], None]) -> None:
        exchange = self._normal_exchange
        exchange.table[: exchange.mine.size] = 0.0
        for k in self._faces:
            add(k, exchange.table)
        exchange.begin()
        exchange.end()
        of_faces.sum_members(self._normal_particle, self._normal_rows, exchange.table, total)

    # what the scheme calls

    def share(self, y: Array, t: float) -> None:
        """Sums of the members; ``state`` has what the particles share, but for slipping and temperatures."""
        self.data: Data = self.prescribed.at(t)
        kernels.fill_state(self.table, self._d, y, self._exchange.table)
        self._exchange.begin()
        self._exchange.end()
        kernels.share(self.table, self._d, self._exchange.table, self.data, self.state)

    def settle(self, y: Array) -> None:
        """Project velocities on what constraints allow, share heat, and give all members what their particle has."""
        if self.slips:
            kernels.slide(self.table, self._d, self.normals, self.data, self.state)
        kernels.share_heat(self.table, self._law, self._d, self._energy, self.data, self.state)
        kernels.give_state(self.table, self._d, y, self.state)

    def constrain(self, y: Array, f: Array) -> None:
        """Rates of all members under the constraints of their particles, in place."""
        kernels.fill_rates(self.table, self._d, f, self._exchange.table)
        self._exchange.begin()
        self._exchange.end()
        rows = self._exchange.table
        kernels.constrain(
            self.table, self._d, rows, self.normals, self.turning, self.data, self.state, self._rates
        )
        kernels.give_rates(self.table, self._d, y, f, self.state, self._rates)

    def places(self, t: float) -> Array:
        """(p, d) displacement of solids, and of walls that move by themselves, at time t [s]; 0 elsewhere."""
        found, moving = self.state.D.copy(), self.prescribed.moving
        if moving.size:
            alone = self.state.solid_mass[moving] == 0.0
            found[moving[alone]] = self.prescribed.displacement(t)[alone]
        return found

    def velocities(self) -> Array:
        """(p, d) the velocities that belong to ``places``."""
        found, moving = self.state.v.copy(), self.prescribed.moving
        alone = moving[self.state.solid_mass[moving] == 0.0]
        found[alone] = self.data.wall[alone]
        return found

    def destroy(self) -> None:
        """Release the messages."""
        self._exchange.destroy()
        if self.slips:
            self._normal_exchange.destroy()


def _largest() -> Any:
    from mpi4py import MPI

    return MPI.MAX


def _members(layout: BlockLayout, particles: Sequence[Particle]) -> tuple[Array, Array]:
    """(n, 3), particle, block, node of all members, by particle; and the ranks that own them."""
    members = np.array([(p, k, n) for p, one in enumerate(particles) for k, n in one.members], np.int64).reshape(-1, 3)
    owners = np.empty(len(members), np.int64)
    for k in range(len(layout.problem.blocks)):
        of_block = members[:, 1] == k
        owners[of_block] = layout.owners(k, members[of_block, 2])
    return members, owners


def _weight(part: Part, ghosted: int) -> float:
    """H of a node: the product of the weights of the axes."""
    nx, ny, _ = part.patch.ghosted
    places = ghosted % nx, ghosted // nx % ny, ghosted // (nx * ny)
    product = 1.0
    for band, place in zip(part.bands, places, strict=True):
        product *= float(band.weight[place])
    return product


def _state(count: int, d: int) -> State:
    shapes = (count,), (count,), (count,), (count, d + 2), (count, d), (count, d), (count,), (count,)
    return State(*(np.zeros(shape) for shape in shapes))
