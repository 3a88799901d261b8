"""What makes viscous stress and conduction narrow: terms of undivided differences for the rates.
Compiled.

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


from fsipetsc.operators.loops import njit
from fsipetsc.paper.stencils import INNER, U, weight

#: where the sum of the differences that begin at point 0 stands: they may begin before the rank's
#: points
MARGIN = 8


@njit(**INNER)
def add_remainder(op, scale, b, y, g, out, c, shift, begin, end, A, B):
    """out[i - shift, c] += scale H^-1 R(b) y at the points i = begin .. end-1; g: scratch, longer
    by 2 MARGIN."""
    T = op.ends
    for level in range(op.p):
        q = op.p + 1 + level
        count = 2 * op.p - q + 1
        skipped = (q + 1 - count) // 2
        weights, means = op.differences[q - 1], op.means[level]
        for i in range(begin - q, end):
            mean, difference = 0.0, 0.0
            if A + T <= i < B + 1 - T - q:
                for k in range(count):
                    mean += means[U(k)] * b[U(i + skipped + k)]
                for k in range(q + 1):
                    difference += weights[U(k)] * y[U(i + k)]
            g[U(i + MARGIN)] = mean * difference
        if level == 0:
            for side in range(2):
                edge, step, inside = (A, 1, A + T) if side == 0 else (B - q, -1, B - T)
                for t in range(T):
                    at = edge + step * t
                    if begin - q <= at < end:
                        total = 0.0
                        for k in range(T):
                            difference = 0.0
                            for j in range(q + 1):
                                difference += weights[j] * y[edge + step * k + j]
                            total += op.end[t, k] * difference
                        g[at + MARGIN] += b[inside] * total
        for i in range(begin, end):
            total = 0.0
            for k in range(q + 1):
                total += weights[U(k)] * g[U(i - k + MARGIN)]
            out[U(i - shift), c] += scale / weight(op, min(i - A, B - i)) * total


@njit(**INNER)
def narrow_gas(op, gas, layer, u, T, b, kappa, g, out, begin, end, A, B):
    """Add to the rates of a gas at the points begin .. end-1; u, T as the gradients see them."""
    scale, shift = -1.0 / (layer.h * layer.h), layer.halo_lo
    first, last = max(A, begin - 2 * op.p), min(B + 1, end + 2 * op.p)
    for i in range(first, last):
        b[i], kappa[i] = gas.viscosity(T[i]), gas.conductivity(T[i])
    add_remainder(op, scale, b, u, g, out, 1, shift, begin, end, A, B)
    for i in range(first, last):
        b[i] *= u[i]
    add_remainder(op, scale, b, u, g, out, 2, shift, begin, end, A, B)
    add_remainder(op, scale, kappa, T, g, out, 2, shift, begin, end, A, B)


@njit(**INNER)
def narrow_solid(op, solid, layer, T, stretch, b, g, out, begin, end, A, B):
    """Add to the rates of a solid at the points begin .. end-1."""
    scale = -1.0 / (layer.h * layer.h * solid.alpha * solid.m0)
    reach = min(op.reach, 2 * op.p)
    for i in range(max(A, begin - reach), min(B + 1, end + reach)):
        b[i] = solid.kappa_e * stretch[i]
    add_remainder(op, scale, b, T, g, out, 2, layer.halo_lo, begin, end, A, B)
