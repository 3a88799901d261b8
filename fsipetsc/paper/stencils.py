"""The SBP first derivative on rows of values, and narrow second derivatives.

Rows hold the points of a rank with their halos. The closures stand at the first and the last active
point, A and B. The same formula is evaluated in the same order for a point whoever owns it, so
results do not depend on the number of ranks.

D acts twice on u and T, with b = mu', kappa or kappa_e / x_X between. That leaves the shortest wave
alone, (-1)^i being in the null space of the interior formula. With the norm H of D (h = 1), B =
diag(b) and E the difference of the two ends,

    H D B D   = -D^T H B D + E B D                     wide: D twice
    H D2(b)   = -(D^T H B D + R(b)) + E B D            narrow: D2(b) = D B D - H^-1 R(b)

    R(b) = sum_q  Delta_q^T  diag(mean_q b)  Delta_q  +  terms at the ends,     q = p+1 .. 2p

    (rho u)_t     -=  H^-1 R(b) u / h^2
    e_t           -=  H^-1 (R(u b) u + R(kappa) T) / h^2
    alpha m0 T_t  -=  H^-1 R(kappa_e / x_X) T / h^2              (solid)

Delta_q are the undivided differences of order q, at i of the values at i .. i+q, and mean_q b is a
sum of b at the 2p - q + 1 points in the middle of a difference, with the weights that make the
interior formula of D2 one of 2p + 1 points. At either end the differences that begin at the first T
points are left out, and the first T of order p+1 have a term of their own instead, with b at T:

    b_T  Delta_{p+1}^T  c L L^T  Delta_{p+1},             c the sum of the weights of mean_{p+1}

Whatever L is, R is symmetric and, for b >= 0, positive semidefinite; its columns add up to
nothing; it vanishes on polynomials up to degree p, so near the ends D2 is as exact as D B D, and in
the interior of order h^2p. The boundary derivative of D2 is the closure row of D. What the flow
loses in kinetic energy, sum_q mean_q(b) (Delta_q u)^2, the heat gains.

Where a flux b u_X is imposed by the closure row of D, u takes on an error E h^(s+1) u^(s+1) near
the end, s = p, with D2 E = -(error of D2 on x^(s+1)/(s+1)!) at all points but the end point, and
the flux is wrong by phi h^s u^(s+1), phi = e_0 + (D E)_0. Without terms at the ends phi is 1/2,
-1/3, 0.31, -0.38. The L of _ENDS make it 0 for 2/1, 4/2 and 6/3, with L L^T near to 1.

Sources: K. Mattsson, J. Sci. Comput. 51 (2012), 650-682 (remainders of this form); B. Sjögreen and
N. A. Petersson, J. Sci. Comput. 52 (2012), 17-48 (narrow formulas with the boundary derivative in
mind).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from fsipetsc.kernels.loops import each, named, when
from fsipetsc.operators.sbp import (
    OPERATORS,
    STIFFNESS_OF_WIDE,
    fractions,
    row_length,
    undivided,
)

Numbers = tuple[float, ...]
#: As STIFFNESS_OF_WIDE, by interior order: D2(1) has spectral radii of 4.0, 5.3, 6.0 and 7.1 at
#: most with a ghost point at any place.
STIFFNESS = {2: 2.0, 4: 2.2, 6: 2.5, 8: 2.9}
_MEANS = {
    2: ("1/4",),
    4: ("1/36 1/36", "1/144"),
    6: ("1/240 1/240 1/240", "1/1200 1/1200", "1/3600"),
    8: ("1/1400 1/1400 1/1400 1/1400", "1/8400 1/6300 1/8400", "1/29400 1/29400", "1/78400"),
}
#: weights of mean_q, q = p+1 .. 2p, by interior order
MEANS = {order: tuple(map(fractions, rows)) for order, rows in _MEANS.items()}
_ENDS: dict[int, tuple[str, ...]] = {
    2: ("0",),
    4: ("0.57 0", "0.51 0.8275808859653828", "-0.64 0.67"),
    6: ("0.51 0 0", "0.9 0.86 0", "-0.18 1.5909323365068795 0.02", "0.17 0.85 -1.12"),
    8: (),
}


def end_term(order: int) -> list[list[Any]]:
    """c L L^T, (T, T), of fractions, of the operator of an interior order."""
    rows, c = [np.array(fractions(row)) for row in _ENDS[order]], sum(MEANS[order][0])
    return [[c * (a @ b) for b in rows] for a in rows]


@dataclass(frozen=True)
class Stencils:
    """D for h = 1, and narrow second derivatives if ``narrow``: facts of a procedure.

    The interior is sum_k interior[k-1] (v[i+k] - v[i-k]), the closure has a row for each point at
    the left end; norm: weights of the same points; n: points that the first row reaches; diffusion:
    its bound on the step. means: the weights of mean_q in row q-p-1; end: of the term at an end.
    """

    interior: Numbers
    closure: tuple[Numbers, ...]
    norm: Numbers
    reach: int
    n: int
    diffusion: float
    narrow: bool
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
    op = OPERATORS[order]

    def rows(table: Any) -> tuple[Numbers, ...]:
        return tuple(tuple(map(float, row)) for row in table)

    return Stencils(
        *(rows([op.interior])[0], rows(op.closure), rows([op.norm])[0], op.reach, row_length(op)),
        STIFFNESS[order] if narrow else STIFFNESS_OF_WIDE,
        narrow,
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
        skipped, weights = (q + 1 - len(means)) // 2, undivided(q)
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
    T, q, weights = len(op.end), op.p + 1, undivided(op.p + 1)
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
