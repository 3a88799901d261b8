"""A wave along the interface of a gas and an elastic layer, a normal mode of known rate s.

Gas above, between the interface and a rigid adiabatic wall, solid below, on a clamped end; both
at rest but for the mode of the linear equations, whose size is small. What is exact to that size
goes as exp(s t). The mode is found by Chebyshev collocation, an eigenvalue problem across the
layers:

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

from fsipetsc import BlockProblem, Fluid, InputError
from fsipetsc.blocks.conditions import Clamped
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import Opt, elastic_of, gas_of, materials, stack, wall_for
from fsipetsc.checks import Array
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = (
    *materials(fluid_mu=0.01, fluid_kappa=0.035 / 0.72, solid_density=1.0),
    *materials(solid_mu=1.0, solid_lambda=1.0),
)
DEFAULTS = {"fsi_h": 1 / 32, "ts_max_time": 1.0, "fsi_output_dt": 0.05}
#: wave number [1/m], displacement of the interface, height of the gas, depth of the solid [m]
K, SIZE, HEIGHT, DEPTH = 2.0 * np.pi, 1e-5, 1.0, 0.5
#: points of the collocation in either layer
POINTS = 36
#: eigenvalues larger than this times k c are those of the collocation itself; modes change less
#: than this with more points
LARGE, RESOLVED = 200.0, 1e-7
#: (field, point) of a row -> weights of all unknowns, whose sum is to be 0
Conditions = dict[tuple[int, int], Array]


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


def eigenmodes(A: Array, weights: Array, conditions: Conditions) -> tuple[Array, Array]:
    """(s, modes (…, fields, n)) of A z = s weights z, A of shape (fields, n, fields n); some of its
    rows give way to conditions.
    """
    B = weights[:, None, None] * np.eye(A.shape[2]).reshape(A.shape)
    for row, condition in conditions.items():
        A[row], B[row] = condition, 0.0
    values, vectors = eig(A.reshape(-1, A.shape[2]), B.reshape(-1, A.shape[2]))
    return values, vectors.T.reshape(-1, *A.shape[:2])


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
    """Return all modes that swing, the slowest first."""
    (y, D), (y_s, E) = chebyshev(n, 0.0, height), chebyshev(n, -depth, 0.0)
    values, vectors = eigenmodes(*_equations(gas, solid, k, D, E))
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


def _equations(
    gas: Fluid, solid: ElasticSolid, k: float, D: Array, E: Array
) -> tuple[Array, Array, Conditions]:
    """Of ``eigenmodes``, the four unknowns of the gas and the four of the solid, with the
    derivatives D and E, each at n points from above."""
    n, ik = len(D), 1j * k
    rho, u, v, T, x, y, U, V = np.eye(8 * n).reshape(8, n, 8 * n)
    p, div = gas.R * (rho + T), ik * u + D @ v
    t_xx, t_yy = (gas.mu * (2.0 * a - 2.0 / 3.0 * div) for a in (ik * u, D @ v))
    t_xy = gas.mu * (ik * v + D @ u)
    s_xx, s_yy = (solid.lambda_e * (ik * x + E @ y) + 2.0 * solid.mu_e * a for a in (ik * x, E @ y))
    s_xy = solid.mu_e * (ik * y + E @ x)
    gains = [
        -div,
        ik * (t_xx - p) + D @ t_xy,
        ik * t_xy + D @ (t_yy - p),
        gas.kappa * (D @ D @ T - k * k * T) - gas.R * div,
        U,
        V,
        ik * s_xx + E @ s_xy,
        ik * s_xy + E @ s_yy,
    ]
    conditions = {
        (2, 0): v[0],
        (2, -1): v[-1] - V[0],
        (6, -1): U[-1],
        (7, -1): V[-1],
        (6, 0): s_xy[0] - t_xy[-1],
        (7, 0): s_yy[0] - (t_yy - p)[-1],
    }
    if gas.mu > 0:
        conditions |= {(1, 0): u[0], (1, -1): u[-1] - U[0]}
    if gas.kappa > 0:
        conditions |= {(3, 0): (D @ T)[0], (3, -1): (D @ T)[-1]}
    weights = np.array([1.0, 1.0, 1.0, gas.cv, 1.0, 1.0, solid.m0, solid.m0])
    return np.array(gains), weights, conditions


def build(opt: Opt) -> BlockProblem:
    """The solid below Y = 0, the gas above."""
    air, body = gas_of(opt), elastic_of(opt)
    mode = slowest_wave(air, body, K, HEIGHT, DEPTH)

    def swinging(amplitudes, X, Y, t):
        """Return real parts of the amplitudes times exp(i k X + s t)."""
        phase = SIZE * np.exp(1j * K * X + mode.s * t)
        return [np.real(of_height(Y) * phase) for of_height in amplitudes]

    def gas(X, Y, t=0.0):
        rho, u, v, T = swinging(mode.gas, X, Y, t)
        return 1.0 + rho, u, v, 1.0 + T

    def solid(X, Y, t=0.0):
        x, y, u, v = swinging(mode.solid, X, Y, t)
        # without conduction and work of the stresses its temperature stays
        return u, v, 1.0, X + x, Y + y

    note = f"the mode goes as exp(s t), s = {mode.s.real:.9f} {mode.s.imag:+.9f} i"
    return stack(
        opt,
        Layer("layer", body, (-DEPTH, 0.0), solid, exact=solid),
        Layer("gas", air, (0.0, HEIGHT), gas, exact=gas),
        along=((0.0, 2.0 * np.pi / K),),
        lower=Clamped(),
        upper=wall_for(air),
        notes=(note,),
    )
