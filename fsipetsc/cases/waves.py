"""Normal modes of a gas and a solid, solutions of the linear equations: exact for small motions.

The modes are found by Chebyshev collocation, an eigenvalue problem across the layers.
"""

import numpy as np
from numpy.polynomial import Chebyshev

from fsipetsc import BlockProblem, FluidLayer, InputError, Layer, Problem, SolidLayer, Wall, clamped
from fsipetsc.blocks.conditions import Clamped, NoSlip, Slip
from fsipetsc.cases.common import Opt, case, elastic_of, gas_of, materials, solid_of, stack
from fsipetsc.checks import Array

#: points of the collocation in either layer
POINTS = 36


def chebyshev(n: int, low: float, high: float) -> tuple[Array, Array]:
    """(points from high to low, matrix of the derivative), n points (Trefethen, Spectral Methods in
    MATLAB, ch. 6)."""
    x = np.cos(np.pi * np.arange(n) / (n - 1))
    c = np.where((np.arange(n) % (n - 1)) == 0, 2.0, 1.0) * (-1.0) ** np.arange(n)
    D = np.outer(c, 1 / c) / (x[:, None] - x[None, :] + np.eye(n))
    D -= np.diag(D.sum(axis=1))
    return low + (x + 1) / 2 * (high - low), D * 2 / (high - low)


def eigenmodes(gains: list[Array], weights: list[float], conditions: dict) -> tuple[Array, Array]:
    """(s, modes (…, fields, n)) of gains z = s weights z, (n, unknowns) for each field. Conditions,
    (field, point) -> weights, replace some rows: the unknowns times their weights have the sum 0.
    """
    from scipy.linalg import eig

    A = np.array(gains)
    B = np.array(weights)[:, None, None] * np.eye(A.shape[2]).reshape(A.shape)
    for row, condition in conditions.items():
        A[row], B[row] = condition, 0.0
    values, vectors = eig(A.reshape(-1, A.shape[2]), B.reshape(-1, A.shape[2]))
    return values, vectors.T.reshape(-1, *A.shape[:2])


def polynomials(x: Array, values: Array) -> list[Chebyshev]:
    """Those through the values (fields, n) at the points of ``chebyshev``."""
    return [Chebyshev.fit(x, row, len(x) - 1, (x[-1], x[0])) for row in values]


@case(
    {"fsi_h": 0.025, "ts_max_time": 1.0, "fsi_output_dt": 0.1},
    *materials(fluid_mu=0.02, fluid_kappa=0.1, solid_modulus=20.0),
    *materials(solid_kappa=0.3, solid_density=2.0, solid_alpha=1.0),
)
def heat(opt: Opt) -> Problem:
    """Conjugate heat transfer with an exact solution: warm layers cool between cold ends.

    Solid | gas at rest under the pressure p0 and of the temperature T0, which the clamped left end
    of the solid and the wall at the right keep. A small disturbance decays in the slowest thermal
    mode of both together, as exp(s t). It solves the linear equations; what remains of the error on
    fine grids is of second order in the amplitude.
    """
    gas, solid = gas_of(opt), solid_of(opt)
    if not gas.kappa > 0.0 < solid.kappa_e:
        raise InputError("expected -fluid_kappa and -solid_kappa above 0")
    p0 = T0 = rho0 = 1.0
    amplitude, capacity = 1e-7, solid.alpha * solid.m0  # amplitude of T
    (x, D), (x_s, E) = chebyshev(POINTS, 0.0, 1.0), chebyshev(POINTS, -1.0, 0.0)
    rho, u, T, v, sigma, T_s = np.eye(6 * POINTS).reshape(6, POINTS, 6 * POINTS)
    force = gas.R * (T0 * rho + rho0 * T) - 4 / 3 * gas.mu * D @ u
    flux, flux_s = gas.kappa * D @ T, solid.kappa_e * E @ T_s
    gains = [-rho0 * D @ u, -D @ force, D @ flux - p0 * D @ u]
    gains += [E @ sigma, E @ v, E @ flux_s - p0 * E @ v]
    weights = [1.0, rho0, rho0 * gas.cv, solid.m0, 1.0 / solid.K, capacity]
    # points go from right to left
    conditions = {(1, 0): u[0], (2, 0): T[0], (3, -1): v[-1], (5, -1): T_s[-1]}
    conditions |= {(1, -1): u[-1] - v[0], (2, -1): T[-1] - T_s[0]}
    conditions |= {(3, 0): force[-1] + sigma[0], (5, 0): flux[-1] - flux_s[0]}
    values, vectors = eigenmodes(gains, weights, conditions)
    # what is slower than either layer alone is the state at rest under another pressure
    least = min(gas.kappa / (rho0 * gas.gamma * gas.cv), solid.kappa_e / capacity)
    thermal = np.flatnonzero((values.imag == 0.0) & (values.real < -least))
    if not thermal.size:
        raise InputError("no thermal mode is found: expected conductivities closer to each other")
    found = thermal[np.argmax(values.real[thermal])]
    s, parts = values.real[found], vectors[found].real
    of_T = [*polynomials(x, parts[[2]]), *polynomials(x_s, parts[[5]])]
    T = np.concatenate([polynomial.linspace(201)[1] for polynomial in of_T])
    parts = parts / T[np.argmax(np.abs(T))]
    of_gas, of_solid = polynomials(x, parts[:3]), polynomials(x_s, parts[3:])

    def in_gas(x, t=0.0):
        rho, u, T = (amplitude * np.exp(s * t) * part(x) for part in of_gas)
        return rho0 + rho, u, T0 + T

    def in_solid(X, t=0.0):
        u, sigma, T = (amplitude * np.exp(s * t) * part(X) for part in of_solid)
        return u, sigma - p0, T0 + T, X + u / s

    left = SolidLayer("solid", solid, (-1.0, 0.0), in_solid, exact=in_solid)
    layers = left, FluidLayer("gas", gas, (0.0, 1.0), in_gas, exact=in_gas)
    note = f"the mode decays as exp({s:.10g} t), as the linear equations have it"
    return Problem(layers, clamped(T=T0), Wall(1.0, T=T0), notes=(note,), units="none")


@case(
    {"fsi_h": 1 / 32, "ts_max_time": 1.0, "fsi_output_dt": 0.05},
    *materials(fluid_mu=0.01, fluid_kappa=0.035 / 0.72, solid_density=1.0),
    *materials(solid_mu=1.0, solid_lambda=1.0),
)
def wave(opt: Opt) -> BlockProblem:
    """A wave along the interface of a gas and an elastic layer, a normal mode of known rate s.

    Gas of density and temperature 1 above, below a rigid adiabatic wall, solid below, on a clamped
    end; both at rest but for the mode, the slowest that swings more than it decays. Disturbances,
    and displacements (x, y) of the solid, are proportional to exp(i k X + s t) and obey the linear
    equations, with Hooke's law in plane strain. At y = 0 velocities and tractions are one and no
    heat passes; where mu = 0 the gas slips. The solid is free of strain under the pressure at rest.
    """
    gas, solid = gas_of(opt), elastic_of(opt)
    k, size, height, depth = 2.0 * np.pi, 1e-5, 1.0, 0.5
    ik, c = 1j * k, gas.sound_speed(1.0)

    (x_g, D), (x_s, E) = chebyshev(POINTS, 0.0, height), chebyshev(POINTS, -depth, 0.0)
    rho, u, v, T, x, y, U, V = np.eye(8 * POINTS).reshape(8, POINTS, 8 * POINTS)
    p, div = gas.R * (rho + T), ik * u + D @ v
    t_xx, t_yy = (gas.mu * (2.0 * a - 2.0 / 3.0 * div) for a in (ik * u, D @ v))
    t_xy = gas.mu * (ik * v + D @ u)
    lame, mu_e = solid.lambda_e, solid.mu_e
    s_xx, s_yy = (lame * (ik * x + E @ y) + 2.0 * mu_e * a for a in (ik * x, E @ y))
    s_xy = mu_e * (ik * y + E @ x)
    conduction = gas.kappa * (D @ D @ T - k * k * T)
    gains = [-div, ik * (t_xx - p) + D @ t_xy, ik * t_xy + D @ (t_yy - p)]
    gains += [conduction - gas.R * div, U, V, ik * s_xx + E @ s_xy, ik * s_xy + E @ s_yy]
    # points go from above to below
    conditions = {(2, 0): v[0], (2, -1): v[-1] - V[0], (6, -1): U[-1], (7, -1): V[-1]}
    conditions |= {(6, 0): s_xy[0] - t_xy[-1], (7, 0): s_yy[0] - (t_yy - p)[-1]}
    if gas.mu > 0:
        conditions |= {(1, 0): u[0], (1, -1): u[-1] - U[0]}
    if gas.kappa > 0:
        conditions |= {(3, 0): (D @ T)[0], (3, -1): (D @ T)[-1]}
    weights = [1.0, 1.0, 1.0, gas.cv, 1.0, 1.0, solid.m0, solid.m0]
    values, vectors = eigenmodes(gains, weights, conditions)
    swings = values.imag > np.maximum(np.abs(values.real), 1e-6 * k * c)
    found = np.flatnonzero(swings & np.isfinite(values))
    for mode in found[np.argsort(values.imag[found])]:
        s, parts = complex(values[mode]), vectors[mode]
        ends = parts[4:6, 0]
        parts = parts / ends[np.argmax(np.abs(ends))]
        of_gas, of_solid = polynomials(x_g, parts[:4]), polynomials(x_s, parts[4:])
        last = [np.abs(of_height.coef[-4:]).max() for of_height in (*of_gas, *of_solid)]
        if max(last) < 1e-6 * np.abs(parts).max():
            break
    else:
        raise InputError("no normal mode of the layers is resolved")

    def swinging(amplitudes, X, Y, t):
        phase = size * np.exp(1j * k * X + s * t)
        return [np.real(of_height(Y) * phase) for of_height in amplitudes]

    def in_gas(X, Y, t=0.0):
        rho, u, v, T = swinging(of_gas, X, Y, t)
        return 1.0 + rho, u, v, 1.0 + T

    def in_solid(X, Y, t=0.0):
        x, y, u, v = swinging(of_solid, X, Y, t)
        # without conduction and work of the stresses its temperature stays
        return u, v, 1.0, X + x, Y + y

    below = Layer("layer", solid, (-depth, 0.0), in_solid, exact=in_solid)
    above = Layer("gas", gas, (0.0, height), in_gas, exact=in_gas)
    note = f"the mode goes as exp(s t), s = {s.real:.9f} {s.imag:+.9f} i"
    wall = NoSlip() if gas.mu > 0.0 else Slip()
    ends = {"lower": Clamped(), "upper": wall, "along": ((0.0, 2.0 * np.pi / k),)}
    return stack(opt, below, above, notes=(note,), **ends)
