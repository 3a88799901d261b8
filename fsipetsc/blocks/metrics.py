"""Metric terms of blocks: derivatives D_k of places, the solid's metrics, the gas's in curl form.

Derivatives of a node come from differences of pairs of nodes, in an order that is its own mirror image and without fused
multiplications: blocks that share a face get the same bits for what lies within it, whichever way their axes run. Along
periodic axes only periodic functions are differentiated: X = y + sum_k xi_k P_k, P_k the period of axis k or 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Block, Range, determinant, mesh
from fsipetsc.blocks.maps import place_text
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.operators.bands import Band
from fsipetsc.operators.loops import CALL, LOOP

#: of loops that round each operation by itself
EXACT: dict[str, Any] = {**LOOP, "fastmath": {"nsz"}}
#: (i, j, k) cyclic
CYCLIC = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


@njit(**EXACT)
def _differences(out, f, S, k):
    """out_i += S_ki (f_i+k - f_i) + S_k,i-k (f_i - f_i-k) along a row, so far as it goes."""
    n = f.size
    for i in range(min(k, n - k)):
        out[i] += S[i] * (f[i + k] - f[i])
    for i in range(k, n - k):
        out[i] += S[i] * (f[i + k] - f[i]) + S[i - k] * (f[i] - f[i - k])
    for i in range(max(k, n - k), n):
        out[i] += S[i - k] * (f[i] - f[i - k])


@njit(**EXACT)
def _differences_of_rows(out, behind, f, ahead, s_behind, s):
    """The same across rows: out += s (ahead - f) + s_behind (f - behind)."""
    for i in range(f.size):
        out[i] += s * (ahead[i] - f[i]) + s_behind * (f[i] - behind[i])


@njit(**EXACT)
def _multiply(out, c):
    for i in range(out.size):
        out[i] *= c[i]


@njit(**EXACT)
def _multiply_row(out, c):
    for i in range(out.size):
        out[i] *= c


@njit(**CALL)
def differentiate(out, f, S, weight, before):
    """out = D f along one axis of flat arrays (N,), `before` nodes of faster axes between its neighbours.

    S, weight: of a Band, cut to the nodes that f has. Next to a cut the result is of no use.
    """
    n = weight.size
    size = n * before
    out[:] = 0.0
    for start in range(0, f.size, size):
        if before == 1:
            row = out[start : start + n]
            for k in range(1, S.shape[0]):
                _differences(row, f[start : start + n], S[k], k)
            _multiply(row, 0.5 / weight)
            continue
        for i in range(n):
            a = start + i * before
            row, here = out[a : a + before], f[a : a + before]
            for k in range(1, S.shape[0]):
                s_behind, s = S[k, i - k] if i >= k else 0.0, S[k, i] if i + k < n else 0.0
                if s != 0.0 or s_behind != 0.0:
                    b = a - k * before if i >= k else a
                    c = a + k * before if i + k < n else a
                    _differences_of_rows(row, f[b : b + before], here, f[c : c + before], s_behind, s)
            _multiply_row(row, 0.5 / weight[i])


class Wide:
    """A range of nodes of a block, and the wider one that their derivatives need.

    where: the range, beyond the ends on periodic axes only. wide: it and `reach` nodes more on each side of each axis, as far as
    there are nodes. shape, wide_shape: numbers of nodes, axis 0 first. bands: of each axis, cut to the wide range.
    """

    def __init__(self, block: Block, order: int, where: Range) -> None:
        self.block, self.where = block, [tuple(ends) for ends in where]
        whole = [block.band(order, axis) for axis in range(block.dimension)]
        self.wide = [
            (begin - band.reach, end + band.reach) if closed else (max(begin - band.reach, 0), min(end + band.reach, n))
            for (begin, end), band, closed, n in zip(where, whole, block.periodic, block.shape)
        ]
        self.bands: list[Band] = [band.part(*ends) for band, ends in zip(whole, self.wide)]
        self.shape, self.wide_shape = (tuple(b - a for a, b in ends) for ends in (self.where, self.wide))
        self._inner = tuple(slice(a - c, b - c) for (a, b), (c, _) in zip(self.where[::-1], self.wide[::-1]))

    def inner(self, f: Array) -> Array:
        """The part of f (…, wide nodes) on the range, (…, nodes)."""
        seen = f.reshape(*f.shape[:-1], *self.wide_shape[::-1])[(..., *self._inner)]
        return seen.reshape(*f.shape[:-1], -1)

    def derivative(self, axis: int, f: Array) -> Array:
        """D_axis f of f (…, wide nodes)."""
        before = int(np.prod(self.wide_shape[:axis]))
        out, flat = np.empty_like(f), f.reshape(-1, f.shape[-1])
        for row, values in zip(out.reshape(flat.shape), flat):
            differentiate(row, values, *self.bands[axis], before)
        return out

    @property
    def periods(self) -> Array:
        """P_k of axis k, (d, d), 0 where it is not periodic."""
        block = self.block
        return np.array([P if closed else 0.0 * P for P, closed in zip(block.periods, block.periodic)])

    def periodic_part(self, problem: BlockProblem, k: int) -> Array:
        """y = X - sum_k xi_k P_k of the wide nodes, (d, N)."""
        block = self.block
        index = [i % n for i, n in zip(mesh([np.arange(*ends) for ends in self.wide]), block.shape)]
        numbers = np.ravel_multi_index(index[::-1], block.shape[::-1]).ravel()
        y = problem.places(k, numbers).T
        for P, i, cells in zip(self.periods, index, block.cells):
            y = y - np.multiply.outer(P, i.ravel() / cells)
        return np.ascontiguousarray(y)


def gradients(wide: Wide, y: Array) -> Array:
    """D_k X (d, d, N): axis, component, wide node; y its periodic part."""
    return np.array([wide.derivative(k, y) + P[:, None] for k, P in enumerate(wide.periods)])


def solid_metrics(problem: BlockProblem, k: int, order: int, where: Range) -> Array:
    """A^1, …, A^d and J0 of a range of nodes, (d d + 1, N): cofactors and determinant of D_k X. InputError if J0 <= 0."""
    block = problem.blocks[k]
    wide = Wide(block, order, where)
    G = wide.inner(gradients(wide, wide.periodic_part(problem, k)))
    J = determinant(G)
    check_positive(block, J, problem.positions(k, where))
    return np.concatenate([cofactors(G).reshape(-1, J.size), J[None]])


def cofactors(G: Array) -> Array:
    """A^k with A^k . G_l = det G where k = l and 0 elsewhere, (d, d, N) as G."""
    if len(G) == 1:
        return np.ones_like(G)
    if len(G) == 2:
        (a, b), (c, e) = G
        return np.array([[e, -c], [-b, a]])
    return np.array([_cross(G[j], G[k]) for _, j, k in CYCLIC])


def _cross(a: Array, b: Array) -> list[Array]:
    return [a[m] * b[l] - a[l] * b[m] for _, m, l in CYCLIC]


def check_positive(block: Block, J: Array, X: Array) -> None:
    """InputError where J (N,) of the nodes at X (d, N) is not above 0; this rank may be alone with it."""
    if not J.min() > 0.0:
        i = int(np.argmin(J))
        at = place_text(X[:, i])
        raise InputError(f"{block}: J = {J[i]:.3g} at {at}: expected J > 0; more cells or another map", collective=False)


def curl_metrics(wide: Wide, y: Array) -> Array:
    """a^1, a^2, a^3 in three dimensions, (3, 3, N) at the nodes of the range, with sum_k D_k a^k = 0.

    (a^i)_n = D_j q_kn - D_k q_jn,  q_kn = 1/2 (x_m D_k x_l - x_l D_k x_m), (i, j, k) and (n, m, l) cyclic. Thomas and Lombard,
    AIAA J. 17 (1979) 1030-1037. With x = y + sum_k xi_k P_k, by the product rule,

        q_kn = 1/2 (y_m D_k y_l - y_l D_k y_m) + y_m P_kl - y_l P_km,    (a^i)_n += P_jm P_kl - P_km P_jl.
    """
    P, D = wide.periods, [wide.derivative(k, y) for k in range(3)]
    a = np.zeros((3, 3, int(np.prod(wide.shape))))
    for n, m, l in CYCLIC:
        q = [0.5 * (y[m] * D[k][l] - y[l] * D[k][m]) + (y[m] * P[k, l] - y[l] * P[k, m]) for k in range(3)]
        for i, j, k in CYCLIC:
            curl = wide.derivative(j, q[k]) - wide.derivative(k, q[j])
            a[i, n] = wide.inner(curl) + (P[j, m] * P[k, l] - P[k, m] * P[j, l])
    return a
