"""Metric terms of blocks from derivatives D_k of places: cofactors of solids, the gas's curl form.

D of a node comes from differences of pairs of nodes, in an order that is its own mirror image and
without fused multiplications: blocks that share a face get the same bits for what lies within it,
whichever way their axes run. Along periodic axes only periodic functions are differentiated:
X = y + sum_k xi_k P_k, with P_k the period of axis k, or 0.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Range, determinant, mesh
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import Array, place_text
from fsipetsc.equations.tensors import cofactor
from fsipetsc.errors import InputError
from fsipetsc.kernels.loops import each, pick, when
from fsipetsc.kernels.symbols import exact
from fsipetsc.operators.bands import Band

#: struct pairs of cube.c
_PAIRS = np.dtype(
    [(name, "i8") for name in ("count", "even")]
    + [(name, "i8", 7) for name in ("before", "after")]
    + [(name, "f8", 7) for name in ("behind", "ahead")]
)


class Wide:
    """A range of nodes of a block, and the wider one that their derivatives need.

    where: the range, beyond the ends on periodic axes only, or to images before a centre. wide: it
    and, as far as there are nodes, as many more on each side as pairs reach, sizes: how many along
    each axis. S, weight: of the bands of the axes, cut to it. P: (d, d), the periods. y: (d, N),
    the periodic part of X.
    """

    def __init__(self, problem: BlockProblem, k: int, order: int, where: Range) -> None:
        block, centred = problem.blocks[k], problem.centred(k)
        self.where, self.wide, bands = [tuple(ends) for ends in where], [], []
        for axis, (begin, end) in enumerate(where):
            band, n = problem.band(k, order, axis), block.shape[axis]
            begin, end = begin - band.reach, end + band.reach
            if not block.periodic[axis]:
                images = n if centred and axis == problem.dimension - 1 else 0
                begin, end = max(begin, -images), min(end, n)
            self.wide.append((begin, end))
            bands.append(band.part(begin, end))
        self.order, (self.S, self.weight) = order, zip(*bands)
        self.sizes = tuple(end - begin for begin, end in self.wide)
        ranges = list(zip(self.where, self.wide))[::-1]
        self._inner = tuple(slice(a - first, b - first) for (a, b), (first, _) in ranges)
        index = mesh([np.arange(*ends) for ends in self.wide])
        self.P, around = block.periods, zip(index, block.shape, block.periodic)
        index = [i % n if closed else i for i, n, closed in around]
        y = problem.places_at(k, index).reshape(len(index), -1)
        for P, i, cells in zip(self.P, index, block.cells):
            y = y - np.multiply.outer(P, i.ravel() / cells)
        self.y = np.ascontiguousarray(y)

    def inner(self, f: Array) -> Array:
        """The part of f (…, wide nodes) on the range, (…, nodes)."""
        seen = f.reshape(*f.shape[:-1], *self.sizes[::-1])[(..., *self._inner)]
        return seen.reshape(*f.shape[:-1], -1)

    def gradients(self) -> Array:
        """D_k X (d, d, nodes of the range): axis, component."""
        steps = np.cumprod((1, *self.sizes[:-1]))
        bands = zip(self.S, self.weight, steps, strict=True)
        G = np.array([differentiate(self.y, *band) for band in bands])
        return self.inner(G) + self.P[..., None]


def solid_metrics(problem: BlockProblem, k: int, order: int, where: Range) -> Array:
    """A^1, …, A^d and J0 of a range of nodes, (d d + 1, N). InputError if J0 <= 0,
    perhaps on this rank alone.

    J0 = det G, A^k = J0 G^-T e_k from G = D X, node by node; both times R^kappa around an axis or
    a centre, and then R is another row, below 0 of images, which are at a centre alone (kappa = 2).
    """
    G, X = Wide(problem, k, order, where).gradients(), problem.positions(k, where)
    J = determinant(G)
    if not J.min() > 0.0:
        i = int(np.argmin(J))
        found = f"{problem.blocks[k]}: J = {J[i]:.3g} at {place_text(X[:, i])}: expected J > 0"
        raise InputError(f"{found}: more cells, or another map", collective=False)
    metrics = np.array([*cofactor(tuple(G.reshape(-1, J.size))), J])
    if problem.symmetry:
        metrics = np.concatenate([metrics * X[-1] ** problem.symmetry, X[-1:]])
    return metrics


def differentiate(f: Array, S: Array, weight: Array, before: int) -> Array:
    """D f along one axis of flat arrays (…, N), `before` nodes of faster axes between neighbours.

    S, weight: of a Band, cut to the nodes that f has. Next to a cut the result is of no use.
    """
    n = weight.size
    u = f.reshape(*f.shape[:-1], -1, n, before)
    slope = np.zeros(u.shape)
    for k in range(1, min(len(S), n)):
        flow, pairs = S[k, : n - k, None] * (u[..., k:, :] - u[..., : n - k, :]), np.zeros(u.shape)
        pairs[..., : n - k, :] = flow
        pairs[..., k:, :] += flow
        slope += pairs
    slope *= (0.5 / weight)[:, None]
    return slope.reshape(f.shape)


def slopes_along(out, f, S, weight):
    """The same in a procedure, of rows whose neighbours lie side by side."""
    n = weight.shape[0]
    for row in each(f.shape[0] // n):
        a = row * n
        out[a : a + n] = 0.0
        for k in each(1, np.minimum(S.shape[0], n)):
            s, end = S[k], n - k
            for i in each(np.minimum(k, end)):
                out[a + i] += exact(s[i] * (f[a + i + k] - f[a + i]))
            for i in each(k, end, vector=True):
                here, behind = f[a + i], f[a + i - k]
                out[a + i] += exact(s[i] * (f[a + i + k] - here) + s[i - k] * (here - behind))
            for i in each(np.maximum(k, end), n):
                out[a + i] += exact(s[i - k] * (f[a + i] - f[a + i - k]))
        for i in each(n, vector=True):
            out[a + i] *= 0.5 / weight[i]


def slopes_across(out, f, S, weight, before):
    """The same in a procedure, along an axis with `before` nodes between neighbours."""
    n = weight.shape[0]
    for row in each(f.shape[0] // before):
        i, a, half = row % n, row * before, 0.5 / weight[row % n]
        out[a : a + before] = 0.0
        for k in each(1, S.shape[0]):
            ahead, behind = pick(i + k < n, k, 0), pick(i >= k, k, 0)
            s = np.where(i + k < n, S[k, i], 0.0)
            s_behind = np.where(i >= k, S[k, i - behind], 0.0)
            b, c = a - behind * before, a + ahead * before
            with when((s != 0.0) | (s_behind != 0.0)):
                for j in each(before, vector=True):
                    more = s * (f[c + j] - f[a + j]) + s_behind * (f[a + j] - f[b + j])
                    out[a + j] += exact(more)
        for j in each(before, vector=True):
            out[a + j] *= half


def cube_of(wide: Wide, faces: Sequence[Any] = ()) -> tuple[int, tuple[Array, ...]]:
    """The range of nodes of a Wide in three dimensions, for the functions of cube.c: the address of
    a struct in C, which has whole numbers and pointers alone, and what these point to.

    The functions take it; places less those of linear maps (3, wide nodes); and what is filled:
    (9, N) a^1, a^2, a^3, or of these a^(i + 1) on each of ``faces``, (axis i, index along it), or
    (N,) det D x. Of layers it says how many behind each one its derivatives reach, and how many are
    needed at a time if no later ones are found.
    """
    sizes, begins = np.array(wide.sizes), np.array([begin for begin, _ in wide.wide])
    first, end = np.array(wide.where).T - begins
    steps, layers = np.cumprod((1, *wide.sizes[:-1])), np.arange(sizes[2])
    pairs = [_pairs(*band) for band in zip(wide.S, wide.weight, steps, strict=True)]
    ahead, behind = (pairs[2][way].max(axis=1) // steps[2] for way in ("after", "before"))
    earliest = np.minimum.accumulate((layers - behind)[::-1])[::-1]
    slots = (np.maximum.accumulate(layers + ahead) - earliest).max() + 1
    room = np.zeros((9, slots * steps[2])), np.zeros((9, wide.sizes[0]))
    arrays = wide.P, ahead, np.array(faces, np.int64), *room
    numbers = (
        [of_axis.ctypes.data for of_axis in pairs],
        [len(S) - 1 for S in wide.S],
        *(sizes, first, end),
        Band(wide.S[0], wide.weight[0]).interior(wide.order // 2),
        [array.ctypes.data for array in arrays],
        (np.prod(end - first), len(faces), slots),
    )
    struct = np.concatenate(numbers).astype(np.int64)
    return struct.ctypes.data, (struct, *pairs, *arrays)


def _pairs(S: Array, weight: Array, step: int) -> Array:
    """Of the nodes of an axis, with so many numbers between neighbours; S, weight: of a band."""
    n, found = len(weight), np.zeros(len(weight), _PAIRS)
    for i, pairs in enumerate(found):
        pairs["even"] = 1
        for k in range(1, len(S)):
            ahead, behind = S[k, i] * (i + k < n), S[k, i - k] * (i >= k)
            if ahead or behind:
                m, half, far = pairs["count"], 0.5 / weight[i], k * step
                pairs["before"][m], pairs["after"][m] = far * (behind != 0), far * (ahead != 0)
                pairs["behind"][m], pairs["ahead"][m] = half * behind, half * ahead
                pairs["even"] &= ahead == behind
                pairs["count"] += 1
    return found
