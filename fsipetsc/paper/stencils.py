"""The SBP first derivative on rows of values, and narrow second derivatives.

Rows hold the points of a rank with their halos. The closures stand at the first and the last active
point, A and B. The same formula is evaluated in the same order for a point whoever owns it, so
results do not depend on the number of ranks.

D acts twice on u and T, with b = mu', kappa or kappa_e / x_X between. The narrow second derivative
of fsipetsc.operators.narrow is D2(b) = D b D - H^-1 R(b), R(b) = sum_q Delta_q^T mean_q(b) Delta_q,
q = p+1 .. 2p, so that

    (rho u)_t     -=  H^-1 R(b) u / h^2
    e_t           -=  H^-1 (R(u b) u + R(kappa) T) / h^2
    alpha m0 T_t  -=  H^-1 R(kappa_e / x_X) T / h^2              (solid)

What the flow loses in kinetic energy, sum_q mean_q(b) (Delta_q u)^2, the heat gains. Delta_q at i
takes the values at i .. i+q.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from fsipetsc.kernels.loops import each, named, when
from fsipetsc.operators.narrow import MEANS, STIFFNESS, STIFFNESS_OF_WIDE, end_term
from fsipetsc.operators.sbp import operator, row_length, undivided

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class Stencils:
    """D for h = 1, and narrow second derivatives if ``narrow`` (fsipetsc.operators.narrow): facts
    of a procedure.

    The interior is sum_k interior[k-1] (v[i+k] - v[i-k]), the closure has a row for each point at
    the left end; norm: weights of the same points; n: points that the first row reaches; diffusion:
    its bound on the step. differences: the weights of Delta_q in row q-1; means: those of mean_q in
    row q-p-1; end: of the term at an end.
    """

    interior: Numbers
    closure: tuple[Numbers, ...]
    norm: Numbers
    reach: int
    n: int
    diffusion: float
    narrow: bool
    differences: tuple[Numbers, ...]
    means: tuple[Numbers, ...]
    end: tuple[Numbers, ...]

    @property
    def p(self) -> int:
        """Half width of the interior formula."""
        return len(self.interior)

    @property
    def rows(self) -> int:
        """Points of a closure."""
        return len(self.closure)

    @property
    def halo(self) -> int:
        """Points of other ranks that rates and ends need: D acts twice."""
        return max(2 * self.reach, 6)


def stencils(order: int, narrow: bool = False) -> Stencils:
    """Those of an interior order. ValueError if there is none."""
    op = operator(order)

    def rows(table: Any) -> tuple[Numbers, ...]:
        return tuple(tuple(map(float, row)) for row in table)

    return Stencils(
        *(rows([op.interior])[0], rows(op.closure), rows([op.norm])[0], op.reach, row_length(op)),
        STIFFNESS[order] if narrow else STIFFNESS_OF_WIDE,
        narrow,
        tuple(map(undivided, range(1, 9))),
        rows(MEANS[order]),
        rows(end_term(order)),
    )


def near_ends(op: Stencils, a: Any, b: Any, A: Any, B: Any) -> Iterator[tuple[int, Any, Any, int]]:
    """(r, i, end, step): each point i of a .. b-1 that is point number r from an end, A or B, from
    which ``step`` leads inwards. What the loop does is done where there is such a point.
    """
    for end, step in ((A, 1), (B, -1)):
        for r in range(op.rows):
            i = end + step * r
            with when((a <= i) & (i < b)):
                yield r, i, end, step


def derivative(op, q, of, w, to, count, a, b, A, B, scale):
    """w[to + c] = scale h D q[of + c], c = 0 .. count - 1, at the points a .. b-1; q[of + c] is
    known where that reaches, or to A, B."""
    first, end = named(np.maximum(a, A + op.rows)), named(np.minimum(b, B + 1 - op.rows))
    weights = [scale * weight for weight in op.interior]
    for c in each(count):
        f, out = q[c + of], w[c + to]
        for i in each(first, end, vector=True):
            out[i] = sum(v * (f[i + k] - f[i - k]) for k, v in enumerate(weights, 1))
        for r, i, edge, step in near_ends(op, a, b, A, B):
            row = sum(v * f[edge + step * k] for k, v in enumerate(op.closure[r]))
            out[i] = step * scale * row


def weight(op: Stencils, r: int) -> float:
    """Norm weight of the point number r from an end."""
    return op.norm[r] if r < op.rows else 1.0


def add_remainder(op, scale, b, y, scratch, out, c, shift, begin, end, A, B):
    """out[c, i - shift] += scale H^-1 R(b) y at the points i = begin .. end-1; scratch: two rows,
    which begin 2p before the first point."""
    T, (g, sums) = len(op.end), scratch
    sums[begin:end] = 0.0
    for level, means in enumerate(op.means):
        q = op.p + 1 + level
        skipped, weights = (q + 1 - len(means)) // 2, op.differences[q - 1]
        g[begin - q : end] = 0.0
        first, last = np.maximum(begin - q, A + T), np.minimum(end, B + 1 - T - q)
        for i in each(first, last, vector=True):
            mean = sum(v * b[i + skipped + k] for k, v in enumerate(means))
            g[i] = mean * sum(v * y[i + k] for k, v in enumerate(weights))
        if level == 0:
            add_end_terms(op, b, y, g, begin, end, A, B)
        for i in each(begin, end, vector=True):
            sums[i] += sum(v * g[i - k] for k, v in enumerate(weights))
    for r, i, _, _ in near_ends(op, begin, end, A, B):
        sums[i] *= 1.0 / op.norm[r]
    for i in each(begin, end, vector=True):
        out[c, i - shift] += scale * sums[i]


def add_end_terms(op, b, y, g, begin, end, A, B):
    """Add b_T c L L^T Delta_{p+1} y to the differences g at both ends."""
    T, q, weights = len(op.end), op.p + 1, op.differences[op.p]
    for edge, step, inside in ((A, 1, A + T), (B - q, -1, B - T)):
        for t, row in enumerate(op.end):
            at = edge + step * t
            with when((begin - q <= at) & (at < end)):
                differences = (
                    sum(v * y[edge + step * k + j] for j, v in enumerate(weights)) for k in range(T)
                )
                total = sum(v * one for v, one in zip(row, differences, strict=True))
                g[at] += b[inside] * total


def narrow_gas(op, gas, layer, w, u, first_b, out, begin, end, A, B):
    """Add to the rates of a gas at the points begin .. end-1; in scratch w, rows u and u + 1 are u
    and T as the gradients see them, and there is room in five rows from first_b on."""
    mu, mu_u, kappa, g, sums = (w[first_b + c] for c in range(5))
    scale, shift = -1.0 / (layer.h * layer.h), layer.halo_lo
    first = named(np.maximum(A, begin - 2 * op.p))
    last = named(np.minimum(B + 1, end + 2 * op.p))
    for i in each(first, last, vector=True):
        viscosity, T = gas.viscosity(w[u + 1, i]), w[u + 1, i]
        mu[i], mu_u[i], kappa[i] = viscosity, viscosity * w[u, i], gas.conductivity(T)
    for k in each(3):  # of the momentum, by u; of the energy, by u and T
        b, y, c = w[first_b + k], w[u + k // 2], 1 + (k + 1) // 2
        add_remainder(op, scale, b, y, (g, sums), out, c, shift, begin, end, A, B)


def narrow_solid(op, solid, layer, T, stretch, scratch, out, begin, end, A, B):
    """Add to the rates of a solid at the points begin .. end-1; scratch: three rows."""
    scale = -1.0 / (layer.h * layer.h * solid.alpha * solid.m0)
    b, reach = scratch[0], min(op.reach, 2 * op.p)
    for i in each(np.maximum(A, begin - reach), np.minimum(B + 1, end + reach), vector=True):
        b[i] = solid.kappa_e * stretch[i]
    add_remainder(op, scale, b, T, scratch[1:], out, 2, layer.halo_lo, begin, end, A, B)
