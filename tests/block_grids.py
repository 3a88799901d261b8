"""Blocks of warped boxes for tests of geometry."""

from types import SimpleNamespace

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Free, NoSlip
from fsipetsc.blocks.problem import BlockProblem, Meeting

GAS, SOLID = SimpleNamespace(mu=0.0, gamma=1.4), SimpleNamespace(m0=1.0)


def nothing(*X):
    return X


def box(name, cells, material=GAS, lower=None, axes=None, flips=None):
    """A unit box under a smooth map of R^d, the same for all blocks of a test: the k-th logical
    axis runs along coordinate axes[k], backwards where flips[k].
    """
    d = len(cells)
    lower, axes, flips = lower or (0.0,) * d, axes or range(d), flips or (False,) * d

    def places(xi):
        X = [None] * d
        for s, axis, flip in zip(xi, axes, flips):
            X[axis] = lower[axis] + (1.0 - s if flip else s)
        waves = [(1.7 + 0.3 * k) * x for k, x in enumerate(X)]
        return tuple(
            x + 0.1 * np.sin(2 * w - sum(waves) + 2.1 * c) for c, (x, w) in enumerate(zip(X, waves))
        )

    return Block(name, material, places, cells, nothing)


def closed(*blocks):
    """A problem of blocks with walls where no other block is."""
    kinds = {block.name: Free() if block.material is SOLID else NoSlip() for block in blocks}
    return BlockProblem(blocks, conditions_of(blocks, lambda name, axis, side: kinds[name]))


def conditions_of(blocks, condition):
    """condition(name, axis, side) of each face that no other one meets, by its middle."""
    sides = [
        (b, k, s) for b in blocks for k in range(b.dimension) if not b.periodic[k] for s in (0, 1)
    ]
    found = [b.face_positions(k, s).mean(axis=1) for b, k, s in sides]
    middles = np.reshape(found, (len(sides), -1) if sides else (0, 1))
    apart = np.abs(middles[:, None] - middles).max(axis=-1) > 1e-9
    alone = (~apart).sum(axis=1) == 1
    return {(b.name, *f): condition(b.name, *f) for (b, *f), one in zip(sides, alone) if one}


def joins(problem, k):
    """(axis, side), Meeting of block k."""
    return [(face, met) for face, met in problem.faces_of(k).items() if isinstance(met, Meeting)]
