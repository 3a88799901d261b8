"""What makes viscous stress and conduction narrow: terms of undivided differences for the rates.

D acts twice on u and T, with b = mu', kappa or kappa_e / x_X between. The narrow second derivative
of fsipetsc.operators.narrow is D2(b) = D b D - H^-1 R(b), R(b) = sum_q Delta_q^T mean_q(b) Delta_q,
q = p+1 .. 2p, so that

    (rho u)_t     -=  H^-1 R(b) u / h^2
    e_t           -=  H^-1 (R(u b) u + R(kappa) T) / h^2
    alpha m0 T_t  -=  H^-1 R(kappa_e / x_X) T / h^2              (solid)

Columns of R add up to nothing: mass, momentum and total energy hold as with D twice. What the flow
loses in kinetic energy, sum_q mean_q(b) (Delta_q u)^2, the heat gains. Delta_q at i takes the
values at i .. i+q. At either end the first T differences of each order are left out; of order p+1 a
term ``end`` (T, T) of their own stands instead, with b at point T.
"""

import numpy as np

from fsipetsc.kernels.loops import each, named, when
from fsipetsc.paper.stencils import near_ends


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
