"""Heat in gas and solid: two media in contact, a slab with a flux, a thermal mode at an interface.

Contact: all lengths go as sqrt(t). The gas (x > 0) has the pressure 1 everywhere, so that with the
mass m beside the interface, rho c_p T_t = kappa T_xx becomes, in xi = m/sqrt(t),

    -xi T'/2 = D (T'/T)',    D = kappa p/(c_p R),    x/sqrt(t) = chi,  chi' = R T/p.

The solid (X < 0) has an error function (H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids,
2nd ed., Sec. 2.15). Slab: the flux cos(2 pi t). Mode: linear equations, Chebyshev's collocation.
"""

import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import solve_ivp
from scipy.linalg import eig
from scipy.optimize import brentq
from scipy.special import erf

#: gas: R, c_p, kappa, T far away; solid: rho c, kappa, T far away
R, CP, KAPPA, HOT = 1.0, 3.5, 0.0063, 1.005
COLD = 0.995
HEAT, KAPPA_S = 1 / (0.25 * COLD) * 5 / 3 * 0.375, 0.00225
A_S, D = KAPPA_S / HEAT, KAPPA / (CP * R)


def contact(points):
    """T at the interface, u sqrt(t) far away; chi, T, u sqrt(t) of gas; X/sqrt(t), T of solid."""
    end = 16 * np.sqrt(D)

    def shoot(T0, where=None):
        flux = KAPPA_S * (T0 - COLD) / np.sqrt(np.pi * A_S)
        start = [T0, flux * R / KAPPA, 0.0]  # T, T'/T, chi
        return solve_ivp(
            lambda xi, y: [y[1] * y[0], -xi * y[1] * y[0] / (2 * D), R * y[0]],
            *((0.0, end), start, "DOP853", where),
            rtol=1e-13,
            atol=1e-15,
        ).y

    T0 = brentq(lambda T: shoot(T)[0][-1] - HOT, COLD, HOT, xtol=1e-15, rtol=1e-14)
    xi = np.linspace(0, end, points)
    T, _, chi = shoot(T0, xi)
    u = (chi - xi * R * T) / 2
    X = np.linspace(-end / 2, 0, points)
    return T0, u[-1], chi, T, u, X, COLD + (T0 - COLD) * (1 + erf(X / np.sqrt(4 * A_S)))


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
    T0, U, chi, T, u, X, T_s = contact(points)
    x = np.linspace(0, 1, points)
    s, solid, gas = mode(x)
    same = np.ones(points)
    return {
        **{"contact T": T0 * same, "contact u": U * same, "chi": chi, "gas T": T, "gas u": u},
        **{"X": X, "solid T": T_s, "x": x, "slab T": slab(x)},
        **{"mode s": s * same, "mode solid": solid, "mode gas": gas},
    }


if __name__ == "__main__":
    from csv_file import save

    save(
        "heat",
        columns(),
        "made by verify/heat.py; without dimensions (R of the gas 1, p = 1)",
        "contact: T at the interface, u sqrt(t) far in the gas; gas T, gas u = u sqrt(t) at "
        "x/sqrt(t) = chi; solid T at X/sqrt(t) = X",
        "slab T at x, at whole t; mode s: rate; mode solid, mode gas: T over its largest, at "
        "x - 1 and x",
    )
