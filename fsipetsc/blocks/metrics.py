"""Metric terms of blocks from derivatives D_k of places: cofactors of solids, the gas's curl form.

D of a node comes from differences of pairs of nodes, in an order that is its own mirror image and
without fused multiplications: blocks that share a face get the same bits for what lies within it,
whichever way their axes run. Along periodic axes only periodic functions are differentiated:
X = y + sum_k xi_k P_k, with P_k the period of axis k, or 0.
"""

import numpy as np

from fsipetsc.blocks.block import Range, determinant, mesh
from fsipetsc.blocks.maps import place_text
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.checks import Array
from fsipetsc.equations.tensors import cofactor
from fsipetsc.errors import InputError
from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, INNER_CALL
from fsipetsc.operators.loops import EXACT_LOOP as EXACT


class Wide:
    """A range of nodes of a block, and the wider one that their derivatives need.

    where: the range, beyond the ends on periodic axes only, or to images before a centre. wide: it
    and, as far as there are nodes, as many more on each side as pairs reach. sizes: nodes of the
    wide range along each axis. S, weight: of the bands of the axes, cut to it. P: (d, d), the
    periods. y: (d, N), the periodic part of X.
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
        self.S, self.weight = tuple(band.S for band in bands), tuple(band.weight for band in bands)
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
        G = np.empty((len(self.S), *self.y.shape))
        for k, before in enumerate(np.cumprod((1, *self.sizes[:-1]))):
            for c, y in enumerate(self.y):
                differentiate(G[k, c], y, self.S[k], self.weight[k], before)
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
        found = f"{problem.blocks[k]}: J = {J[i]:.3g} at {place_text(X[:, i])}"
        wanted = "expected J > 0: more cells, or another map"
        raise InputError(f"{found}: {wanted}", collective=False)
    metrics = np.array([*cofactor(tuple(G.reshape(-1, J.size))), J])
    if problem.symmetry:
        metrics = np.concatenate([metrics * X[-1] ** problem.symmetry, X[-1:]])
    return metrics


@njit(**EXACT)
def _add_along(out, behind, f, ahead, s_behind, s):
    """out_i += S_ki (f_i+k - f_i) + S_k,i-k (f_i - f_i-k), pairs of one k along a row."""
    for i in range(out.size):
        out[i] += s[i] * (ahead[i] - f[i]) + s_behind[i] * (f[i] - behind[i])


@njit(**EXACT)
def _add_across(out, behind, f, ahead, s_behind, s):
    """The same with rows ahead and behind, which have one weight each."""
    for i in range(out.size):
        out[i] += s * (ahead[i] - f[i]) + s_behind * (f[i] - behind[i])


@njit(**CALL)
def differentiate(out, f, S, weight, before):
    """out = D f along one axis of flat arrays (N,), `before` nodes of faster axes between
    neighbours.

    S, weight: of a Band, cut to the nodes that f has. Next to a cut the result is of no use.
    """
    n, half = weight.size, 0.5 / weight
    for a in range(0, f.size, n * before):
        if before == 1:
            _differentiate_row(out[a : a + n], f[a : a + n], S, half)
        else:
            _differentiate_rows(out[a : a + n * before], f[a : a + n * before], S, half, before)


@njit(**INNER_CALL)
def _differentiate_row(out, f, S, half):
    n = out.size
    out[:] = 0.0
    for k in range(1, min(S.shape[0], n)):
        s = S[k]
        for i in range(min(k, n - k)):
            out[i] += s[i] * (f[i + k] - f[i])
        if n > 2 * k:
            m = n - k
            _add_along(out[k:m], f[: m - k], f[k:m], f[2 * k :], s[: m - k], s[k:m])
        for i in range(max(k, n - k), n):
            out[i] += s[i - k] * (f[i] - f[i - k])
    for i in range(n):
        out[i] *= half[i]


@njit(**INNER_CALL)
def _differentiate_rows(out, f, S, half, m):
    n = half.size
    for i in range(n):
        a = i * m
        row, here = out[a : a + m], f[a : a + m]
        row[:] = 0.0
        for k in range(1, S.shape[0]):
            s = S[k, i] if i + k < n else 0.0
            s_behind = S[k, i - k] if i >= k else 0.0
            if s != 0.0 or s_behind != 0.0:
                b, c = a - k * m * (i >= k), a + k * m * (i + k < n)
                _add_across(row, f[b : b + m], here, f[c : c + m], s_behind, s)
        for j in range(m):
            row[j] *= half[i]
