"""Who owns which nodes of blocks, and a world vector that holds all blocks.

The world vector, which TS integrates, is on each rank the concatenation of the rank's parts of the
blocks. A part has planes, one unknown of all nodes after the other:

    gas     (J, J rho, J rho u_1 … J rho u_d, J E)              d + 3 numbers
    solid   (D_1 … D_d, v_1 … v_d, e)                           2 d + 1 numbers

Nodes of a block are numbered n = i_0 + N_0 (i_1 + N_1 i_2), and so are those of a rank's part.

Halos are the nodes beside its own that a rank gets from others. Ghosted arrays have planes, too,
and one memory, so that one message has what a rank needs of all blocks from another one. All ranks
know from the shares which nodes each of them needs.
"""

from itertools import accumulate
from math import prod
from operator import mul
from types import SimpleNamespace
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blocks.block import mesh
from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.kernels.loops import zeros
from fsipetsc.operators.sbp import AXIS, NO_AXIS, OPERATORS, Patch
from fsipetsc.parallel.block_shares import Extent, share_out
from fsipetsc.parallel.exchange import Exchange, Numbers, Route

AXES = 3
#: of messages of particles; of halos; of faces, and the number of the block
PARTICLES_TAG, HALO_TAG, GATHER_TAG = 0, 1 << 10, 1 << 13


class Part(SimpleNamespace):
    """This rank's part of block k.

    patch: its sizes. ghosted: first node and first beyond of the ghosted array along each axis,
    which go on beyond the ends of periodic axes. bands: pair weights of the three axes there.
    dof: unknowns of a node. begin: of its numbers in this rank's part of the world vector. numbers:
    (M,) of the nodes that it owns. halo: (dof, N), the ghosted array, or (dof, 0) where the rank
    owns all nodes of that; inside: copies the owned nodes there. signs: (dof,) of the unknowns of
    mirror images, which stand before the first nodes of a block with a centre, else (0,).
    """

    def rows(self, nodes: Numbers) -> Numbers:
        """Places among ``numbers`` of nodes of the block that this rank owns."""
        return np.searchsorted(self.numbers, nodes)

    def rows_among(self, nodes: Numbers) -> Numbers:
        """The same of those nodes that this rank owns; ascending."""
        return np.flatnonzero(np.isin(self.numbers, nodes, assume_unique=True))

    def weights(self, ghosted: Numbers) -> Array:
        """(n,) H of nodes of the ghosted array: the product of the weights of the axes."""
        places = np.unravel_index(ghosted, self.patch.ghosted, order="F")
        each = [band.weight[place] for band, place in zip(self.bands, places, strict=True)]
        return each[0] * each[1] * each[2]


class BlockLayout:
    """Parts of all blocks on all ranks. Collective on ``comm``.

    problem: fsipetsc.blocks.block_problem.BlockProblem. shocks: a sensor looks for them. partition:
    as ``share_out`` has it. auxiliary: unknowns of each rank after those of nodes.

    shares: of each block, known to all ranks. parts: of this rank, by block, in their order.
    halos: the exchange that fills what their ghosted arrays have beside the nodes that it owns.
    local_size: of this rank's part of the world vector. kernels: those of materials, once made.
    InputError where a block has too few nodes for the operator, or there are too many ranks.
    """

    def __init__(
        self, comm: MPI.Comm, problem: Any, order: int, shocks: bool, partition: str, auxiliary: int
    ) -> None:
        self.comm, self.problem, self.order = comm, problem, order
        self.kernels = dict[Any, Any]()
        d, blocks = problem.dimension, problem.blocks
        self.shapes = [tuple(map(int, block.shape)) for block in blocks]
        self.dofs = [d + 3 if block.kind == "fluid" else 2 * d + 1 for block in blocks]
        self._extents = [self._extent(k, shocks) for k in range(len(blocks))]
        self.shares = share_out(self._extents, comm.size, partition)
        sizes = (share.nodes(comm.rank).size for share in self.shares)
        self._begins = [0, *accumulate(map(mul, self.dofs, sizes))]
        self.auxiliary, self.local_size = auxiliary, self._begins[-1] + auxiliary
        here = [k for k, share in enumerate(self.shares) if comm.rank in share.ranks]
        nodes = (prod(b - a for a, b in self._ghosted(k, comm.rank)) for k in here)
        begins = [0, *accumulate(self.dofs[k] * n for k, n in zip(here, nodes))]
        memory = zeros(begins[-1])
        self.parts, halos = dict[int, Part](), list[Route]()
        for k, at in zip(here, begins):
            halo, inside = self._routes(k, at)
            halos.append(halo)
            self.parts[k] = self._part(k, memory[at:], Exchange(comm, HALO_TAG, [inside], memory))
        self.halos = Exchange(comm, HALO_TAG, halos, memory)

    def _extent(self, k: int, shocks: bool) -> Extent:
        """A block as its partition sees it. InputError for too few nodes, or too many numbers."""
        block, shape, op = self.problem.blocks[k], self.shapes[k], OPERATORS[self.order]
        halo = self._halo(k, shocks)
        for axis, (n, closed) in enumerate(zip(shape, block.periodic, strict=True)):
            least = max(2 * op.p + 1, halo) if closed else op.min_points
            if n < least:
                raise InputError(
                    f"block '{block.name}' has {n} nodes along its {'periodic ' * closed}axis "
                    f"{axis}: the {op.name} operator needs at least {least}: take "
                    f"{least - (not closed)} cells there or more, by a smaller -fsi_h where that "
                    "sets them, or a lower -fsi_order"
                )
        if prod(shape) * self.dofs[k] > np.iinfo(PETSc.IntType).max:
            raise InputError(f"block '{block.name}' has more numbers than PETSc can count")
        # what others need of derivatives must be no row of the closure, which reaches farther
        cut = max(op.rows + max(op.p, halo - op.p), halo), max(2 * op.p, halo)
        return Extent(block.kind, shape, tuple(cut[closed] for closed in block.periodic), halo)

    def _halo(self, k: int, shocks: bool) -> int:
        """Width of the halo of block k. Where derivatives act twice, in solids and in gases with
        viscosity or conduction, a node needs 2 p others to each side; 3 p in solids that conduct,
        whose temperature may follow from the strain; else p, one more at shocks, and at least 2.
        Around an axis p is the number of images that nodes see, if that is more.
        """
        problem, material, p = self.problem, self.problem.blocks[k].material, self.order // 2
        if problem.symmetry == 1 and problem.centred(k):
            p = max([p, *(-i for i, _ in AXIS.get(self.order, ()))])
        if material.kind == "solid":
            return 3 * p if material.kappa_e > 0.0 else 2 * p
        return 2 * p if material.mu > 0.0 or material.kappa > 0.0 else max(p + shocks, 2)

    def _ghosted(self, k: int, rank: int) -> tuple[tuple[int, int], ...]:
        """First node and first beyond of a rank's ghosted array along each axis: it goes on beyond
        the ends of periodic axes; images before a centre have numbers below 0.
        """
        found, block, width = [], self.problem.blocks[k], self._extents[k].halo
        for axis, (a, b) in enumerate(self.shares[k].part(rank)):
            first, beyond = a - width, b + width
            if not block.periodic[axis]:
                images = self.problem.centred(k) and axis == block.dimension - 1 and a == 0
                first = first if images else max(first, 0)
                beyond = min(beyond, self.shapes[k][axis])
            found.append((first, beyond))
        return tuple(found)

    def _nodes(self, k: int, rank: int) -> tuple[Numbers, Numbers, Numbers]:
        """Places in a rank's ghosted array of the nodes that it owns, and of those that others send
        to it, or that it owns and has once more (of a periodic axis); numbers of the latter.
        """
        index = [i.ravel() for i in mesh([np.arange(*ends) for ends in self._ghosted(k, rank)])]
        own, periodic = self.shares[k].part(rank), self.problem.blocks[k].periodic
        inside = np.all([(i >= a) & (i < b) for i, (a, b) in zip(index, own)], axis=0)
        known = np.all([(i >= 0) | closed for i, closed in zip(index, periodic)], axis=0)
        places = np.flatnonzero(known & ~inside)
        numbers = np.ravel_multi_index([i[places] for i in index], self.shapes[k], "wrap", "F")
        return np.flatnonzero(inside), places, numbers

    def _routes(self, k: int, at: int) -> tuple[Route, Route]:
        """What fills the halo of this rank, and what copies the nodes that it owns to its ghosted
        array, (dof, N), which begins at a place in the memory of all.
        """
        me, share, begin = self.comm.rank, self.shares[k], self._begins[k]
        inside, places, wanted = self._nodes(k, me)
        numbers, N = share.nodes(me), prod(b - a for a, b in self._ghosted(k, me))
        planes = np.arange(self.dofs[k])[:, None]

        def here(nodes: Numbers) -> Numbers:
            return (begin + planes * numbers.size + np.searchsorted(numbers, nodes)).ravel()

        def there(places: Numbers) -> Numbers:
            return (at + planes * N + places).ravel()

        owners = share.owners(wanted)
        needs = {rank: self._nodes(k, rank)[2] for rank in share.ranks if rank != me}
        sent = {rank: here(nodes[share.owners(nodes) == me]) for rank, nodes in needs.items()}
        received = {rank: there(places[owners == rank]) for rank in needs}
        twice = here(wanted[owners == me]), there(places[owners == me])
        return Route(sent, received, twice), Route({}, {}, (here(numbers), there(inside)))

    def _part(self, k: int, memory: Array, inside: Exchange) -> Part:
        """This rank's part of block k, whose ghosted array is the beginning of ``memory``."""
        block, dof, rank = self.problem.blocks[k], self.dofs[k], self.comm.rank
        share, others = self.shares[k], [(0, 1)] * (AXES - block.dimension)
        own, ghosted = (*share.part(rank), *others), (*self._ghosted(k, rank), *others)
        sizes = [tuple(b - a for a, b in spans) for spans in (own, ghosted)]
        patch = Patch(*sizes, tuple(a - g for (a, _), (g, _) in zip(own, ghosted, strict=True)))
        axes = range(block.dimension)
        bands = [self.problem.band(k, self.order, axis).part(*ghosted[axis]) for axis in axes]
        local = memory[: dof * prod(patch.ghosted)].reshape(dof, -1)
        images = ghosted[axes[-1]][0] < 0 and self.problem.centred(k)
        odd = (axes[-1], axes[-1] + block.dimension) if block.kind == "solid" else dof - 2
        part = Part(k=k, patch=patch, dof=dof, begin=self._begins[k], inside=inside)
        part.ghosted, part.numbers = ghosted[: block.dimension], share.nodes(rank)
        part.bands = (*bands, *[NO_AXIS] * len(others))
        part.halo = local if own != ghosted else local[:, :0].copy()
        part.signs = np.where(np.isin(np.arange(dof), odd), -1.0, 1.0)[: dof * images]
        return part

    def owned(self, k: int, array: Array) -> Array:
        """View, (M, dof), of block k in this rank's part of a world vector; M may be 0."""
        return array[slice(*self._begins[k : k + 2])].reshape(self.dofs[k], -1).T

    def natural(self, k: int) -> Numbers:
        """Nodes of block k that this rank holds in natural order, not those that it owns."""
        n, rank, size = prod(self.shapes[k]), self.comm.rank, self.comm.size
        return np.arange(n * rank // size, n * (rank + 1) // size)

    def in_order(self, k: int, saved: Array) -> Array:
        """(n, columns) of `natural`, from those of the nodes that ranks own. Collective."""
        n, columns = self.natural(k).size, saved.shape[1]
        own = self.parts[k].numbers if k in self.parts else []
        vector = PETSc.Vec().createMPI((n * columns, None), bsize=columns, comm=self.comm)
        vector.setValuesBlocked(np.array(own, PETSc.IntType), saved)
        vector.assemble()
        found: Array = vector.getArray(readonly=True).reshape(-1, columns).copy()
        vector.destroy()
        return found
