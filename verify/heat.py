"""Heat in gas and solid: a slab with the flux cos(2 pi t); a thermal mode at an interface, of the
linear equations, by Chebyshev's collocation.
"""

import numpy as np
from numpy.polynomial import chebyshev
from scipy.linalg import eig


def slab(X, a=0.1, w=2 * np.pi):
    """T at t = 0, 1, 2 ... of a slab with T = 1 at X = 0 and T_X = cos(w t) at X = 1."""
    k = np.sqrt(1j * w / a)
    return 1 + (np.sinh(k * X) / (k * np.cosh(k))).real


def mode(where, n=32, mu=0.02, kappa=0.1, K=20.0, kappa_s=0.3, m0=2.0, alpha=1.0):
    """Slowest s, T of solid at `where` - 1 and of gas at `where`; largest |T| 1, there positive."""
    z = -np.cos(np.pi * np.arange(n) / (n - 1))
    V = chebyshev.chebvander(z, n - 1)
    slope = chebyshev.chebval(z, chebyshev.chebder(np.eye(n))).T
    d = 2 * slope @ np.linalg.inv(V)  # on an interval of length 1
    one, none = np.eye(n), np.zeros((n, n))
    cv, nu = 2.5, 4 / 3 * mu
    # rows and columns: rho, u, T of gas, u, sigma, T of solid; p = rho = T = R = 1 at rest
    A = np.block(
        [
            [none, -d, none, none, none, none],
            [-d, nu * d @ d, -d, none, none, none],
            [none, -d / cv, kappa / cv * d @ d, none, none, none],
            [none, none, none, none, d / m0, none],
            [none, none, none, K * d, none, none],
            [none, none, none, -d / (alpha * m0), none, kappa_s / (alpha * m0) * d @ d],
        ]
    )
    B = np.eye(6 * n)
    first, last = one[0], one[-1]

    def put(row, *terms):
        A[row], B[row] = 0, 0
        for field, values in terms:
            A[row, field * n : (field + 1) * n] += values

    put(2 * n - 1, (1, last))
    put(3 * n - 1, (2, last))
    put(3 * n, (3, first))
    put(5 * n, (5, first))
    put(n, (1, first), (3, -last))
    put(5 * n - 1, (0, first), (2, first), (1, -nu * d[0]), (4, last))
    put(2 * n, (2, first), (5, -last))
    put(6 * n - 1, (2, kappa * d[0]), (5, -kappa_s * d[-1]))
    s, vectors = eig(A, B)
    real = np.isfinite(s) & (abs(s.imag) < 1e-8) & (s.real < -1e-6)
    k = np.flatnonzero(real)[np.argmax(s.real[real])]
    gas, solid = (vectors[f * n : (f + 1) * n, k].real for f in (2, 5))
    at = chebyshev.chebvander(2 * np.asarray(where) - 1, n - 1) @ np.linalg.inv(V)
    both = np.array([at @ solid, at @ gas])
    return s[k].real, *(both / both.flat[np.argmax(abs(both))])


def columns(points=201):
    """Head -> numbers."""
    x = np.linspace(0, 1, points)
    s, solid, gas = mode(x)
    same = np.ones(points)
    return {
        **{"x": x, "slab T": slab(x)},
        **{"mode s": s * same, "mode solid": solid, "mode gas": gas},
    }


if __name__ == "__main__":
    from csv_file import save

    save(
        "heat",
        columns(),
        "made by verify/heat.py; without dimensions (R of the gas 1, p = 1)",
        "slab T at x, at whole t; mode s: rate; mode solid, mode gas: T over its largest, at "
        "x - 1 and x",
    )
