"""Normal modes of a gas at rest over an elastic layer, by Chebyshev collocation: an eigenvalue
problem across the layers.

Disturbances of a gas of density rho, temperature T and pressure p between y = 0 and a rigid
adiabatic wall at y = height, and displacements (x, y) of a solid between a clamped end at
y = -depth and 0, all times exp(i k X + s t):

    s rho'       = -rho (i k u + v_y)                          m0 s (U, V) = Div sigma(x, y)
    rho s (u, v) = -grad p' + Div tau                          s (x, y)    = (U, V)
    rho cv s T'  = -p (i k u + v_y) + kappa (T'_yy - k^2 T'),  p' = R (rho T' + T rho')

with Hooke's law in plane strain. At y = 0 velocities and tractions are one and no heat passes;
where mu = 0 the gas slips, and only what is normal is one. The pressure at rest drops out, as the
solid is free of strain under it.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.linalg import eig

from fsipetsc import Fluid, InputError
from fsipetsc.checks import Array
from fsipetsc.materials.solid import ElasticSolid

#: points of the collocation in either layer
POINTS = 36
#: eigenvalues larger than this times k c are those of the collocation itself; modes change less
#: than this with more points
LARGE, RESOLVED = 200.0, 1e-7
#: (field, point) of a row -> field and its weights, the sum of which is 0
Conditions = dict[tuple[int, int], list[tuple[int, Array]]]


def chebyshev(n: int, low: float, high: float) -> tuple[Array, Array]:
    """(points from high to low, matrix of the derivative), n points (Trefethen, Spectral Methods in
    MATLAB, ch. 6)."""
    angles = np.pi * np.arange(n) / (n - 1)
    x = np.cos(angles)
    c = np.where((np.arange(n) % (n - 1)) == 0, 2.0, 1.0) * (-1.0) ** np.arange(n)
    gaps = x[:, None] - x[None, :] + np.eye(n)
    D = np.outer(c, 1 / c) / gaps
    D -= np.diag(D.sum(axis=1))
    return low + (x + 1) / 2 * (high - low), D * 2 / (high - low)


def eigenmodes(A: Array, B: Array, conditions: Conditions) -> tuple[Array, Array]:
    """(s, modes (…, fields, n)) of A z = s B z; both matrices are (fields, n, fields, n), and some
    of their rows give way to conditions.
    """
    for row, terms in conditions.items():
        A[row] = B[row] = 0.0
        for field, weights in terms:
            A[row][field] += weights
    size = A.shape[0] * A.shape[1]
    values, vectors = eig(A.reshape(size, size), B.reshape(size, size))
    return values, vectors.T.reshape(size, *A.shape[:2])


def polynomials(x: Array, values: Array) -> list[Chebyshev]:
    """Those through the values (fields, n) at the points of ``chebyshev``."""
    return [Chebyshev.fit(x, row, len(x) - 1, (x[-1], x[0])) for row in values]


class Mode(NamedTuple):
    """s [1/s], and across the layers the amplitudes of the unknowns of gas and solid: (rho, u, v,
    T) and (x, y, U, V)."""

    s: complex
    gas: list[Chebyshev]
    solid: list[Chebyshev]


def slowest_wave(gas: Fluid, solid: ElasticSolid, k: float, height: float, depth: float) -> Mode:
    """The slowest mode that swings more than it decays, its interface displaced by 1, where that is
    largest; gas of the density and temperature 1, lengths and 1/k in m. InputError where the
    collocation resolves none.
    """
    waves, finer = (_waves(gas, solid, k, height, depth, n) for n in (POINTS, POINTS * 4 // 3))
    for mode in waves:
        if min(abs(mode.s - other.s) for other in finer) < RESOLVED * abs(mode.s):
            return mode
    raise InputError("no normal mode of the layers is resolved")


def _waves(
    gas: Fluid, solid: ElasticSolid, k: float, height: float, depth: float, n: int
) -> list[Mode]:
    """All that swing, the slowest first."""
    (y, D), (y_s, E) = chebyshev(n, 0.0, height), chebyshev(n, -depth, 0.0)
    values, vectors = eigenmodes(*_matrices(gas, solid, k, D, E))
    c = gas.sound_speed(1.0)
    found = []
    for i in np.argsort(values.imag):
        s, parts = complex(values[i]), vectors[i]
        swings = s.imag > max(abs(s.real), 1e-6 * k * c)
        if np.isfinite(s) and abs(s) < LARGE * k * c and swings:
            ends = parts[4:6, 0]
            parts = parts / ends[np.argmax(np.abs(ends))]
            found.append(Mode(s, polynomials(y, parts[:4]), polynomials(y_s, parts[4:])))
    return found


def _matrices(
    gas: Fluid, solid: ElasticSolid, k: float, D: Array, E: Array
) -> tuple[Array, Array, Conditions]:
    """Of ``eigenmodes``; z are the four unknowns of the gas and the four of the solid, with the
    derivatives D and E, each at n points from above."""
    n, rho, T = len(D), 1.0, 1.0
    A, B = np.zeros((8, n, 8, n), complex), np.zeros((8, n, 8, n))
    one, ik, D2, E2 = np.eye(n), 1j * k, D @ D, E @ E
    mu, kappa, p = gas.mu, gas.kappa, rho * gas.R * T
    pressure = {0: gas.R * T, 3: gas.R * rho}
    for c, weight in ((0, 1.0), (1, rho), (2, rho), (3, rho * gas.R / (gas.gamma - 1.0))):
        B[c, :, c] = weight * one
    A[0, :, 1], A[0, :, 2] = -rho * ik * one, -rho * D
    A[3, :, 1], A[3, :, 2], A[3, :, 3] = -p * ik * one, -p * D, kappa * (D2 - k * k * one)
    for c, part in pressure.items():
        A[1, :, c], A[2, :, c] = -part * ik * one, -part * D
    A[1, :, 1], A[1, :, 2] = mu * (D2 - 4 / 3 * k * k * one), mu / 3 * ik * D
    A[2, :, 1], A[2, :, 2] = mu / 3 * ik * D, mu * (4 / 3 * D2 - k * k * one)
    m, lam, K = solid.mu_e, solid.lambda_e, solid.K
    for c in (4, 5):
        A[c, :, c + 2], B[c, :, c], B[c + 2, :, c + 2] = one, one, solid.m0 * one
    A[6, :, 4], A[6, :, 5] = m * E2 - K * k * k * one, (lam + m) * ik * E
    A[7, :, 4], A[7, :, 5] = (lam + m) * ik * E, K * E2 - m * k * k * one

    first, last = one[0], one[-1]
    normal = [(c, part * last) for c, part in pressure.items()]
    normal += [(2, -4 / 3 * mu * D[-1]), (1, 2 / 3 * mu * ik * last)]
    shear = [(1, -mu * D[-1]), (2, -mu * ik * last)]
    conditions: Conditions = {
        (2, 0): [(2, first)],
        (2, -1): [(2, last), (7, -first)],
        (6, -1): [(6, last)],
        (7, -1): [(7, last)],
        (7, 0): [(5, K * E[0]), (4, lam * ik * first), *normal],
        (6, 0): [(4, m * E[0]), (5, m * ik * first), *shear],
    }
    if mu > 0:
        conditions |= {(1, 0): [(1, first)], (1, -1): [(1, last), (6, -first)]}
    if kappa > 0:
        conditions |= {(3, 0): [(3, D[0])], (3, -1): [(3, D[-1])]}
    return A, B, conditions
