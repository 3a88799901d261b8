"""Metric terms of blocks from derivatives D_k of places: cofactors of solids, the gas's curl form.

D is a sum that is its own mirror image, as in fsipetsc.operators.slopes. Along periodic axes only
periodic functions are differentiated: X = y + sum_k xi_k P_k, with P_k the period of axis k, or 0.
"""

import numpy as np

from fsipetsc.blocks.block import Range, determinant, mesh
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import Array, place_text
from fsipetsc.equations.tensors import cofactor
from fsipetsc.errors import InputError
from fsipetsc.operators.bands import Band
from fsipetsc.operators.slopes import axis_of


class Wide:
    """A range of nodes of a block, and the wider one that their derivatives need.

    where: the range, beyond the ends on periodic axes only, or to images before a centre. wide: it
    and, as far as there are nodes, as many more on each side as pairs reach, sizes: how many along
    each axis. bands: of the axes, cut to it; near: as kernels of derivatives take it. P: (d, d),
    the periods. y: (d, N), the periodic part of X.
    """

    def __init__(self, problem: BlockProblem, k: int, order: int, where: Range) -> None:
        block, centred = problem.blocks[k], problem.centred(k)
        self.where, self.wide, self.bands = [tuple(ends) for ends in where], [], []
        for axis, (begin, end) in enumerate(where):
            band, n = problem.band(k, order, axis), block.shape[axis]
            begin, end = begin - band.reach, end + band.reach
            if not block.periodic[axis]:
                images = n if centred and axis == problem.dimension - 1 else 0
                begin, end = max(begin, -images), min(end, n)
            self.wide.append((begin, end))
            self.bands.append(band.part(begin, end))
        self.near = order // 2, max(band.reach for band in self.bands)
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
        bands = zip(self.bands, steps, strict=True)
        G = np.array([differentiate(self.y, band, before) for band, before in bands])
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


def differentiate(f: Array, band: Band, before: int) -> Array:
    """D f along one axis of flat arrays (…, N), `before` nodes of faster axes between neighbours.
    Next to where a band is cut the result is of no use.
    """
    axis, reach, i = axis_of(band, (1, band.reach)), band.reach, np.arange(len(band.weight))
    u, found = f.reshape(*f.shape[:-1], -1, i.size, before), 0.0
    for m in range(reach):
        ahead, behind = (u[..., np.clip(i + n, 0, i[-1]), :] - u for n in (m + 1, -1 - m))
        w = axis.weights[:, [m, reach + m], None]
        found = found + (w[:, 0] * ahead - w[:, 1] * behind)
    return found.reshape(f.shape)
