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

from numba import njit

from fsipetsc.paper.stencils import INNER, U, weight

#: where the sum of the differences that begin at point 0 stands: they may begin before the rank's
#: points
MARGIN = 8


@njit(**INNER)
def add_level(weights, means, q, b, y, g, first, last):
    """g += mean_q(b) Delta_q y of the differences that begin at first .. last-1."""
    skipped = (q + 1 - len(means)) // 2
    for i in range(first, last):
        mean, difference = 0.0, 0.0
        for k in range(len(means)):
            mean += means[U(k)] * b[U(i + skipped + k)]
        for k in range(q + 1):
            difference += weights[U(k)] * y[U(i + k)]
        g[U(i + MARGIN)] += mean * difference


@njit(**INNER)
def subtract(op, b, y, g, out, a, c, A, B):
    """out -= R(b) y at the points a .. c-1; g: scratch, longer by 2 MARGIN."""
    T = op.ends
    for level in range(op.p):
        q = op.p + 1 + level
        count = 2 * op.p - q + 1
        weights, means = op.differences[q - 1], op.means[level, :count]
        for i in range(a - q, c):
            g[i + MARGIN] = 0.0
        add_level(weights, means, q, b, y, g, max(A + T, a - q), min(c, B + 1 - T - q))
        if level == 0 and T > 0:
            for side in range(2):
                edge, step, inside = (A, 1, A + T) if side == 0 else (B - q, -1, B - T)
                for t in range(T):
                    at = edge + step * t
                    if a - q <= at < c:
                        total = 0.0
                        for k in range(T):
                            difference = 0.0
                            for j in range(q + 1):
                                difference += weights[j] * y[edge + step * k + j]
                            total += op.end[t, k] * difference
                        g[at + MARGIN] += b[inside] * total
        for i in range(a, c):
            total = 0.0
            for k in range(q + 1):
                total += weights[U(k)] * g[U(i - k + MARGIN)]
            out[U(i)] -= total


@njit(**INNER)
def divide(op, out, h, a, c, A, B):
    """out = H^-1 out / h^2."""
    for i in range(a, c):
        out[U(i)] *= 1.0 / (h * h)
    for r in range(op.rows):
        for i in (A + r, B - r):
            if a <= i < c:
                out[i] /= weight(op, r)


@njit(**INNER)
def narrow_gas(op, gas, h, u, T, b, u_b, kappa, g, momentum, energy, a, c, A, B):
    """What is added to the rates of momentum and energy at the points a .. c-1; u, T as the
    gradients see them."""
    for i in range(max(A, a - 2 * op.p), min(B + 1, c + 2 * op.p)):
        b[i], kappa[i] = gas.viscosity(T[i]), gas.conductivity(T[i])
        u_b[i] = u[i] * b[i]
    for i in range(a, c):
        momentum[i] = energy[i] = 0.0
    subtract(op, b, u, g, momentum, a, c, A, B)
    subtract(op, u_b, u, g, energy, a, c, A, B)
    subtract(op, kappa, T, g, energy, a, c, A, B)
    divide(op, momentum, h, a, c, A, B)
    divide(op, energy, h, a, c, A, B)


@njit(**INNER)
def narrow_solid(op, solid, h, T, stretch, b, g, heat, a, c, A, B):
    """What is added to (kappa_e / x_X T_X)_X at the points a .. c-1."""
    reach = min(op.reach, 2 * op.p)
    for i in range(max(A, a - reach), min(B + 1, c + reach)):
        b[i] = solid.kappa_e * stretch[i]
    for i in range(a, c):
        heat[i] = 0.0
    subtract(op, b, T, g, heat, a, c, A, B)
    divide(op, heat, h, a, c, A, B)
