"""Conjugate heat transfer with an exact solution: a warm solid and a gas cool between cold ends.

Solid | gas at rest under the pressure p0 and of the temperature T0, which the clamped left end of
the solid and the wall at the right keep. A small disturbance decays in the slowest thermal mode of
both together: heat is conducted through the interface, the gas expands where it is warm, and pushes
the solid a little. It goes as exp(s t) and solves the linear equations, here by Chebyshev
collocation:

    s rho = -rho0 u_x,    rho0 s u = mu' u_xx - R (T0 rho + rho0 T)_x,
    rho0 cv s T = -p0 u_x + kappa T_xx                                          in the gas,
    m0 s u = sigma_X,    s sigma = K u_X,    alpha m0 s T = -p0 u_X + kappa_e T_XX in the solid.

What remains of the error on fine grids is of second order in the amplitude.
"""

import numpy as np

from fsipetsc import Fluid, FluidLayer, InputError, Problem, Solid, SolidLayer, Wall, clamped
from fsipetsc.cases.common import Opt, gas_of, materials, solid_of
from fsipetsc.cases.normal_mode import POINTS, Mode, chebyshev, eigenmodes, polynomials

SUMMARY = "conjugate heat transfer between a solid and a gas: errors against the exact solution"

OPTIONS = (
    *materials(conducting=True, fluid_mu=0.02, fluid_kappa=0.1, solid_modulus=20.0),
    *materials(conducting=True, solid_kappa=0.3, solid_density=2.0, solid_alpha=1.0),
)
DEFAULTS = {"fsi_h": 0.025, "fsi_order": 4, "ts_max_time": 1.0, "fsi_output_dt": 0.1}

GAMMA, R, P0, T0 = 1.4, 1.0, 1.0, 1.0
#: density of the gas at rest; largest T - T0, small, as the theory is linear
RHO0, AMPLITUDE = P0 / (R * T0), 1e-7
#: the solid is -1 < X < 0, the gas 0 < x < 1
X = (-1.0, 0.0, 1.0)


def slowest(gas: Fluid, solid: Solid) -> Mode:
    """The slowest thermal mode: real s, (rho, u, T) in the gas and (u, sigma, T) in the solid, the
    largest T 1. InputError where there is none.
    """
    (x, D), (x_s, E) = chebyshev(POINTS, *X[1:]), chebyshev(POINTS, *X[:2])
    mu, heat, one = 4 / 3 * gas.mu, solid.alpha * solid.m0, np.eye(POINTS)
    A, B = np.zeros((2, 6, POINTS, 6, POINTS))
    for c, weight in enumerate((1.0, RHO0, RHO0 * gas.cv, solid.m0, 1.0 / solid.K, heat)):
        B[c, :, c] = weight * one
    A[0, :, 1], A[3, :, 4], A[4, :, 3] = -RHO0 * D, E, E
    A[1, :, 0], A[1, :, 1], A[1, :, 2] = -R * T0 * D, mu * D @ D, -R * RHO0 * D
    A[2, :, 1], A[2, :, 2] = -P0 * D, gas.kappa * D @ D
    A[5, :, 3], A[5, :, 5] = -P0 * E, solid.kappa_e * E @ E
    # points go from right to left
    first, last = one[0], one[-1]
    traction = [(0, R * T0 * last), (2, R * RHO0 * last), (1, -mu * D[-1]), (4, first)]
    conditions = {
        (1, 0): [(1, first)],
        (2, 0): [(2, first)],
        (1, -1): [(1, last), (3, -first)],
        (2, -1): [(2, last), (5, -first)],
        (3, 0): traction,
        (5, 0): [(2, gas.kappa * D[-1]), (5, -solid.kappa_e * E[0])],
        (3, -1): [(3, last)],
        (5, -1): [(5, last)],
    }
    values, vectors = eigenmodes(A, B, conditions)
    # what is slower than either layer alone is the state at rest under another pressure
    least = min(gas.kappa / (RHO0 * GAMMA * gas.cv), solid.kappa_e / heat)
    thermal = np.flatnonzero((values.imag == 0.0) & (values.real < -least))
    if not thermal.size:
        raise InputError("no thermal mode is found: expected conductivities closer to each other")
    found = thermal[np.argmax(values.real[thermal])]
    parts = vectors[found].real
    fine = [polynomial.linspace(201)[1] for polynomial in polynomials(x, parts[[2]])]
    fine += [polynomial.linspace(201)[1] for polynomial in polynomials(x_s, parts[[5]])]
    T = np.concatenate(fine)
    parts = parts / T[np.argmax(np.abs(T))]
    return Mode(values.real[found], polynomials(x, parts[:3]), polynomials(x_s, parts[3:]))


def build(opt: Opt) -> Problem:
    """The solid clamped at X = -1, the wall at x = 1, both of the temperature T0."""
    gas, solid = gas_of(opt, GAMMA, R), solid_of(opt)
    s, of_gas, of_solid = slowest(gas, solid)

    def in_gas(x, t):
        rho, u, T = (AMPLITUDE * np.exp(s * t) * part(x) for part in of_gas)
        return RHO0 + rho, u, T0 + T

    def in_solid(X, t):
        u, sigma, T = (AMPLITUDE * np.exp(s * t) * part(X) for part in of_solid)
        return u, sigma - P0, T0 + T, X + u / s

    layers = (
        SolidLayer("solid", solid, X[:2], lambda X: in_solid(X, 0.0), exact=in_solid),
        FluidLayer("gas", gas, X[1:], lambda x: in_gas(x, 0.0), exact=in_gas),
    )
    note = f"the mode decays as exp({s:.10g} t), as the linear equations have it"
    return Problem(layers, clamped(T=T0), Wall(X[2], T=T0), notes=(note,), units="none")
