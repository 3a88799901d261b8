"""Blocks of warped boxes for tests of geometry."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Free, NoSlip
from fsipetsc.blocks.problem import BlockProblem, Meeting

GAS, SOLID = SimpleNamespace(mu=0.0, gamma=1.4), SimpleNamespace(m0=1.0)


def nothing(*X):
    return X


def warp(X):
    """A smooth map of R^d that is the same for all blocks of a test."""
    return ripples(X, (False,) * len(X))


def ripples(X, periodic):
    """The same, periodic with period 1 along some coordinates."""
    waves = [2.0 * np.pi if closed else 1.7 + 0.3 * k for k, closed in enumerate(periodic)]
    d, size = len(X), 0.03 if any(periodic) else 0.1
    signs = [[1.0 if k == c else -1.0 for k in range(d)] for c in range(d)]
    phases = [sum(s * w * x for s, w, x in zip(signs[c], waves, X)) for c in range(d)]
    return tuple(x + size * np.sin(phase + 2.1 * c) for c, (x, phase) in enumerate(zip(X, phases)))


def turned_box(lower, axes, flips, periodic=None):
    """A warped unit box: the k-th logical axis runs along coordinate axes[k], backwards where
    flips[k].
    """

    def places(xi):
        X = [None] * len(xi)
        for s, axis, flip in zip(xi, axes, flips):
            X[axis] = lower[axis] + (1.0 - s if flip else s)
        return ripples(X, periodic) if periodic else warp(X)

    return places


def box(name, cells, material=GAS, lower=None, axes=None, flips=None, periodic=None):
    d = len(cells)
    lower, axes, flips = lower or (0.0,) * d, axes or range(d), flips or (False,) * d
    return Block(
        name,
        material,
        turned_box(lower, axes, flips, periodic),
        cells,
        nothing,
        periodic=periodic or (),
    )


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


def whole(block):
    return [(0, n) for n in block.shape]


def nodes_of(problem, k, *chosen):
    """Nodes of faces of block k, of all or of some."""
    found = [problem.face_nodes(k, *f) for f in chosen or problem.faces_of(k)]
    return np.unique(np.concatenate([np.zeros(0, int), *found]))


def derivative(block, order, axis, f):
    """D_axis of f (…, nodes) by a dense matrix."""
    D = block.band(order, axis).matrix()
    array = f.reshape(*f.shape[:-1], *block.shape[::-1])
    along = array.ndim - 1 - axis
    return np.moveaxis(np.tensordot(D, array, (1, along)), 0, along).reshape(f.shape)


def joins(problem, k):
    """(axis, side), Meeting of block k."""
    return [(face, met) for face, met in problem.faces_of(k).items() if isinstance(met, Meeting)]
