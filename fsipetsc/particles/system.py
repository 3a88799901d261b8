"""The particles in which a rank takes part: their record, exchanges with other ranks, data.

Owners of the members of a particle send each other what is extensive of them; each adds it up in
the same order and solves the same small system: see fsipetsc.particles.constraints.
"""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.block_problem import BlockFace
from fsipetsc.checks import Array
from fsipetsc.kernels.loops import Known
from fsipetsc.kernels.procedure import Code
from fsipetsc.parallel.block_layout import PARTICLES_TAG, BlockLayout
from fsipetsc.parallel.exchange import RowExchange
from fsipetsc.particles import procedures
from fsipetsc.particles.constraints import weigh_heat
from fsipetsc.particles.members import GAS, ROLLS, SOLID, Particle
from fsipetsc.particles.prescribed import Instant, Prescribed


class ParticleSystem:
    """Particles with a member on this rank. Making one is collective on ``layout.comm``.

    instant: as in Prescribed. gain: see fsipetsc.scheme.part.

    record: all that procedures take, of n particles and their members, on this and other ranks:
    rows of tables, those of one particle together, in an order that all ranks have in common. code,
    does: the recorded procedures, also by their names. sums, areas, stored: exchanges of what
    members add up, of their area vectors, of their elastic energies.
    """

    def __init__(
        self, layout: BlockLayout, particles: Sequence[Particle], instant: Instant, gain: Any
    ) -> None:
        self._layout, d, me = layout, layout.problem.dimension, layout.comm.rank
        listed = [(p, k, n) for p, one in enumerate(particles) for k, n in one.members]
        members = np.array(listed, np.int64).reshape(-1, 3)
        owners = np.empty(len(members), np.int64)
        for k, share in enumerate(layout.shares):
            of_block = members[:, 1] == k
            owners[of_block] = share.owners(members[of_block, 2])
        here = np.unique(members[owners == me, 0])
        taken = np.isin(members[:, 0], here)
        number, owners = np.searchsorted(here, members[taken, 0]), owners[taken]
        self._members, self._mine = members[taken, 1:], np.flatnonzero(owners == me)
        self._particles, self._number, n = [particles[p] for p in here], number, here.size
        most = max([1, *(len(p.constraints) for p in particles)])
        ranks = {me, *owners.tolist()}
        wanted = {rank: np.isin(number, number[owners == rank]) for rank in sorted(ranks)}
        self.sums, self.areas, self.stored = (
            RowExchange(layout.comm, tag, owners, wanted, np.zeros((owners.size, c)))
            for tag, c in enumerate((max(d + 3, 2 * d + 1), 2 * most * d, 1), PARTICLES_TAG)
        )
        self.prescribed = Prescribed(layout.problem, particles, here, instant)
        begin = np.searchsorted(number, np.arange(n + 1))
        self.record = SimpleNamespace(
            d=Known(d),
            begin=begin,  # particle p has the rows begin[p] … begin[p + 1] - 1
            mine=self._mine,  # rows of the members of this rank
            of_particle=number,  # of each member
            **self._of_members(),
            **self._of_particles(owners[begin[:-1]] == me, most),
            laws=tuple(layout.problem.gas_laws),
            data=self.prescribed.data,
            **room(n, d, most),
            stored=self.stored.table,  # (rows, 1) energy that is neither kinetic nor heat
            rows=self.sums.table,  # what members add up
            stores=any(p.stores for p in particles),  # energies that are no heat matter to T
            slips=any(p.constraints for p in particles),  # there are constraints
            of_normals=self.areas.table,  # area vectors of members
            auxiliary=layout.auxiliary,  # unknowns, at the end of a vector, of what came in
            first_auxiliary=layout.local_size - layout.auxiliary,
            gain=gain,
        )
        record, self.code = self.record, Code()
        every = procedures.weigh, procedures.end_sums, procedures.begin_stored, weigh_heat
        every += procedures.impose_conditions, procedures.end_rates
        self.does = {f.__name__: self.code.procedure(f.__name__, f, record) for f in every}
        for name, total in (("end_normals", record.normals), ("end_turning", record.turning)):
            self.does[name] = self.code.procedure(name, procedures.gather, record, total)

    def own(self, k: int) -> tuple[Array, Array, Array]:
        """This rank's members of block k: rows in the tables, nodes, ascending, particles here."""
        rows = self._mine[self._members[self._mine, 0] == k]
        rows = rows[np.argsort(self._members[rows, 1])]
        return rows, self._members[rows, 1], self._number[rows]

    def _of_members(self) -> dict[str, Array]:
        """What the record has of members: GAS or SOLID, specific heat, whether work is booked; of
        those of this rank the place of the first unknown in the world vector, how far the others
        are apart, and H, of which solids make masses.
        """
        problem, ks = self._layout.problem, self._members[:, 0].tolist()
        blocks = [problem.blocks[k] for k in ks]
        kind = np.array([SOLID if block.kind == "solid" else GAS for block in blocks], int)
        alpha = np.array([getattr(block.material, "alpha", 0.0) for block in blocks], float)
        booked = np.array([problem.loses(k) for k in ks], int)
        at, apart = np.zeros((2, len(ks)), np.int64)
        weight = np.zeros(len(ks))
        for k, part in self._layout.parts.items():
            rows, numbers, _ = self.own(k)
            own = part.rows(numbers)
            weight[rows] = part.weights(part.patch.ghosted_rows(own))
            at[rows], apart[rows] = part.begin + own, part.numbers.size
        return dict(kind=kind, alpha=alpha, booked=booked, weight=weight, at=at, apart=apart)

    def _of_particles(self, mine: Array, most: int) -> dict[str, Any]:
        """Facts and kinds of constraints of particles. mine: this rank adds what comes in there."""
        problem, every = self._layout.problem, self._particles
        constraint = np.zeros((len(every), most), int)
        for p, one in enumerate(every):
            constraint[p, : len(one.constraints)] = [kind for kind, _ in one.constraints]
        of_each = [one.facts() for one in every]
        names = Particle(problem, [], {}).facts()
        facts = {name: np.array([of[name] for of in of_each], int) for name in names}
        return {"facts": SimpleNamespace(mine=mine.astype(int), **facts), "constraint": constraint}

    def faces_at(self, k: int) -> SimpleNamespace:
        """The faces of block k at members here whose area vectors make the normals of constraints.

        row: of the member in the table of area vectors, column: where G or S of the constraint
        begins there; a face of the gas at a solid counts in both. node: in the ghosted array. axis:
        of the face, index: along it. weight: those of the other axes, times the sign in G or S.
        """
        d, found, (rows, nodes, _) = self._layout.problem.dimension, [], self.own(k)
        row_of = dict(zip(nodes.tolist(), rows.tolist(), strict=True))
        constraints = (c for particle in self._particles for c in enumerate(particle.constraints))
        for c, (kind, faces) in constraints:
            on_gas, on_solid = 2 * c * d, (2 * c + 1) * d
            for block, number, axis, side, met in faces:
                if block == k and number in row_of:
                    sign, at = 1 if side else -1, (row_of[number], number, axis)
                    found.append((*at, sign, on_solid if kind == ROLLS else on_gas))
                    found += [(*at, -sign, on_solid)] * isinstance(met, BlockFace)
        row, number, axis, sign, column = np.array(found, np.int64).reshape(-1, 5).T.copy()
        part, own = self._layout.parts[k], (axis, np.arange(axis.size))
        node = part.patch.ghosted_rows(part.rows(number))
        place = np.array(np.unravel_index(node, part.patch.ghosted, order="F"))
        weights = np.stack([band.weight[at] for band, at in zip(part.bands, place, strict=True)])
        of_faces = {"weight": sign * weights.prod(axis=0) / weights[own], "index": place[own]}
        return SimpleNamespace(row=row, node=node, axis=axis, column=column, **of_faces)

    def begin(self) -> None:
        """Learn M_s and mean specific heats, once all is loaded, before all else. Collective."""
        self.sums.table[:, 0] = self.record.weight
        self.sums()
        self.record.weight[:] = self.sums.table[:, 0]
        self.does["weigh_heat"]()


def room(n: int, d: int, most: int) -> dict[str, Array]:
    """Memory for what is found of n particles in d dimensions, with so many constraints at most.

    Sums and rates: of the gas mass, volume and (rho, rho u, E); of the solid mass, displacement,
    velocity, energy per mass, also the mean of members before a change, mean specific heat, mean
    energy per mass that is neither kinetic nor heat. G and S of each constraint, how they turn;
    room for the constraints of one particle.
    """
    numbers = "mass", "V", "solid_mass", "e", "mean_energy", "capacity", "potential"
    shapes: dict[str, Any] = dict.fromkeys(numbers, n)
    shapes |= dict.fromkeys(("D", "v", "acceleration"), (n, d))
    shapes |= dict.fromkeys(("U", "U_t"), (n, d + 2))
    shapes |= dict.fromkeys(("normals", "turning"), (n, 2 * most * d))
    shapes |= {"matrix": (most, most), "pi": most, "pivots": most}
    return {name: np.zeros(shape) for name, shape in shapes.items()}
