"""Halos of blocks: what ranks get from one another, on any number of them."""

from helpers import mpirun

PROGRAM = """
import numpy as np
from mpi4py import MPI
from fsipetsc.operators.bands import Patch
from fsipetsc.parallel.block_shares import Extent, share_out
from fsipetsc.kernels.unit import unit
from fsipetsc.parallel.exchange import Exchange, exchange_text
from fsipetsc.process.libraries import libraries
from fsipetsc.parallel.halo import Reach, exchange_of, halo_of

world = MPI.COMM_WORLD
library = libraries(world, [unit({}, [], exchange_text())])[0]
BLOCKS = (
    *(((20,), (False,)), ((20,), (True,)), ((24, 14), (True, False))),
    ((12, 12, 14), (False,) * 3),
)


def check(comm):
    # the number of halos that are as they should be, on all ranks of a communicator
    checked = 0
    for tag, (shape, periodic) in enumerate(BLOCKS):
        forms = (3, True, False), (2, False, False), (3, True, not periodic[-1])
        for width, corners, centred in forms:
            share = share_out([Extent("fluid", shape, periodic, 4, 3, 3)], comm.size)[0]
            if comm.rank not in share.ranks:
                continue
            reach, own = Reach(share, periodic, width, corners, centred), share.part(comm.rank)
            ghosted = reach.ghosted(comm.rank)
            three = [[*spans, *[(0, 1)] * (3 - len(shape))] for spans in (own, ghosted)]
            sizes = [tuple(b - a for a, b in spans) for spans in three]
            patch = Patch(*sizes, tuple(a - g for (a, _), (g, _) in zip(*three)))
            index = np.meshgrid(*(np.arange(a, b) for a, b in own), indexing="ij")
            numbers = np.ravel_multi_index(index, shape, order="F").ravel(order="F")
            local = np.full((2, int(np.prod(patch.ghosted))), -1.0)
            of_part = halo_of(reach, comm.rank, patch, numbers, 2, 3, 0)
            halo = exchange_of(comm, tag, [of_part], local.reshape(-1))
            inside = Exchange(comm, tag, {}, {}, of_part.inside, None, local.reshape(-1))
            here = np.meshgrid(*(f + np.arange(n) for f, n in zip(patch.first, patch.own)))
            here = np.ravel_multi_index(here, patch.ghosted, order="F").ravel()
            for exchange in (halo, inside):
                exchange.load(library)
            for turn in range(3):
                y = np.array([7.0, 7.0, 7.0, *(numbers + 1000.0 * turn), *(-2.0 - numbers)])
                halo(y)
                assert turn or (local[:, here] == -1.0).all(), "the halo alone"
                inside(y)
            index = np.meshgrid(*(np.arange(a, b) for a, b in ghosted), indexing="ij")
            within = [(i >= a) & (i < b) for i, (a, b) in zip(index, own)]
            known = np.all([(i >= 0) | p for i, p in zip(index, periodic)], axis=0)
            if not corners:
                known &= sum((~i).astype(int) for i in within) <= 1
            wrapped = [i % n for i, n in zip(index, shape)]
            wanted = np.ravel_multi_index(wrapped, shape, order="F").astype(float)
            found = local.reshape(2, *(b - a for a, b in ghosted[::-1])).T
            assert np.array_equal(found[..., 0], np.where(known, wanted + 2000.0, -1.0))
            assert np.array_equal(found[..., 1], np.where(known, -2.0 - wanted, -1.0))
            halo.destroy()
            checked += 1
    return comm.allreduce(checked)


for size in range(1, world.size + 1):
    part = world.Split(world.rank < size)
    if world.rank < size:
        assert check(part) >= 12
"""


def test_all_nodes_beside_a_ranks_own_are_there(tmp_path):
    """On one to four ranks."""
    done = mpirun(4, "-m", "mpi4py", "-c", PROGRAM, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
