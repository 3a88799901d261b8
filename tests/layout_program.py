"""Layouts and exchanges on 1 to 5 ranks, in one start, for test_block_layout.py.

Says "all right", or ends with an AssertionError.
"""

from __future__ import annotations

import sys
import traceback
from types import SimpleNamespace

import numpy as np
from mpi4py import MPI

from fsipetsc.operators.bands import band
from fsipetsc.parallel.block_layout import BlockLayout, FaceGather
from fsipetsc.parallel.particle_exchange import ParticleExchange
from fsipetsc.process.together import wait_asleep


class Block:
    """What a layout asks of a block."""

    def __init__(self, name, kind, shape, periodic, mu=0.0):
        self.name, self.kind, self.shape, self.periodic = name, kind, shape, periodic
        self.dimension = len(shape)
        self.material = SimpleNamespace(mu=mu, kappa=0.0, heat="coupled")

    def band(self, order, axis):
        closed = self.periodic[axis]
        return band(order, self.shape[axis] - (not closed), closed)


def problem(d):
    """Viscous gas that is periodic, a solid, gas without viscosity."""
    n, ring = (40, 33, 29)[:d], (True, False, False)[:d]
    open_ones = (False,) * d
    solid, gas = Block("s", "solid", n, open_ones), Block("g", "fluid", n[::-1], open_ones)
    blocks = [Block("v", "fluid", n, ring, mu=0.1), solid, gas]

    def band(k, order, axis):
        return blocks[k].band(order, axis)

    return SimpleNamespace(blocks=blocks, band=band, centred=lambda k: False)


def marks(k, numbers, dof):
    """A number for each unknown of each node."""
    return 1000.0 * k + 10.0 * numbers[:, None] + np.arange(dof) / 16.0


def check_halos(layout):
    vector = layout.vector()
    for part in layout.parts:
        vector.owned(part.k)[:] = marks(part.k, part.numbers, part.dof)
        assert (layout.owners(part.k, part.numbers) == layout.comm.rank).all()
        assert np.array_equal(part.at(part.numbers[1:2]), [part.begin + part.dof])
    vector.begin()
    vector.end()
    for part in layout.parts:
        found = vector.ghosted(part.k)
        right = (found == marks(part.k, part.ghosted_numbers, part.dof)).all(axis=1)
        star = layout.problem.blocks[part.k].name == "g"
        own, ghosted, first = part.patch
        places = np.unravel_index(np.arange(len(found)), ghosted, order="F")
        beyond = [(i < f) | (i >= f + n) for i, f, n in zip(places, first, own, strict=True)]
        corner = np.sum(beyond, axis=0) > 1
        assert right[~corner].all() and (star or right.all())
        assert (found[~right] == 1.0).all(), "corners of a star keep what they were"
        rows = part.ghosted_rows(np.arange(len(part.numbers)))
        assert np.array_equal(part.ghosted_numbers[rows], part.numbers)
        for axis, one in enumerate(part.bands):
            assert one.S.shape[1] == one.weight.size == ghosted[axis]
        for axis, n in enumerate(layout.shapes[part.k]):
            whole = layout.problem.blocks[part.k].band(layout.order, axis)
            here = np.unravel_index(part.ghosted_numbers, layout.shapes[part.k], order="F")[axis]
            assert np.array_equal(part.bands[axis].weight[places[axis]], whole.weight[here])
            assert n == whole.weight.size
    vector.destroy()


def check_faces(layout):
    for part in layout.parts:
        n = layout.shapes[part.k][0]
        faces = {"low": np.arange(n), "back": np.arange(n - 1, 2, -1)}
        gather = FaceGather(layout, part.k, faces, 2)
        for turn in range(2):
            gather.local[:] = gather.nodes[:, None] + [turn, 0.5]
            gather.begin()
            gather.end()
            for name, nodes in faces.items():
                assert np.array_equal(gather.whole[name], nodes[:, None] + [turn, 0.5])


def check_pieces(layout):
    """What all ranks have makes whole blocks."""
    vector = np.zeros(layout.local_size)
    for part in layout.parts:
        layout.owned(part.k, vector)[:] = marks(part.k, part.numbers, part.dof)
    every = layout.comm.allgather(vector)
    assert [values.size for values in every] == np.diff(layout.offsets).tolist()
    for k, shape in enumerate(layout.shapes):
        whole = np.zeros((*shape[::-1], layout.dofs[k]))
        for rank, values in enumerate(every):
            for block, place, at, size in layout.pieces(rank):
                if block == k:
                    whole[place] = values[at : at + np.prod(size)].reshape(size)
        numbers = np.arange(np.prod(shape))
        assert np.array_equal(whole.reshape(-1, layout.dofs[k]), marks(k, numbers, layout.dofs[k]))


def check_particles(comm):
    """Particles of 2 to 4 members on any ranks; rows come in the common order."""
    rng = np.random.default_rng(3)
    particles = np.repeat(np.arange(40), rng.integers(2, 5, 40))
    owners = rng.integers(comm.size, size=particles.size)
    here = np.isin(particles, particles[owners == comm.rank])
    numbers = np.flatnonzero(here)
    exchanges = [
        ParticleExchange(comm, particles[here], owners[here], columns, tag)
        for tag, columns in enumerate((3, 1))
    ]
    for turn in range(3):
        for exchange in exchanges:
            exchange.table[:] = np.nan
            own = numbers[exchange.mine]
            exchange.table[: own.size] = own[:, None] * 10.0 + turn
            exchange.begin()
        for exchange in exchanges[::-1]:
            exchange.end()
            columns = exchange.table.shape[1]
            expected = np.repeat(numbers[:, None] * 10.0 + turn, columns, axis=1)
            assert np.array_equal(exchange.table[exchange.row], expected)
    for exchange in exchanges:
        exchange.destroy()


def main():
    world = MPI.COMM_WORLD
    for size in range(1, world.size + 1):
        comm = world.Split(0 if world.rank < size else MPI.UNDEFINED, world.rank)
        if comm != MPI.COMM_NULL:
            check_particles(comm)
            for order in (2, 4, 6):
                for mode in ("physics", "balanced", "auto"):
                    for d in (1, 2, 3) if order == 4 else (1, 2):
                        layout = BlockLayout(comm, problem(d), order, partition=mode)
                        for check in (check_halos, check_faces, check_pieces):
                            check(layout)
                        layout.destroy()
            comm.Free()
        wait_asleep(world)
    if world.rank == 0:
        print("all right")


if __name__ == "__main__":
    try:
        main()
    except BaseException:
        traceback.print_exc()
        MPI.COMM_WORLD.Abort(1)
    sys.stdout.flush()
