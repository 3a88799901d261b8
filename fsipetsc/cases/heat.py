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
from fsipetsc.cases.wave import POINTS, Mode, chebyshev, eigenmodes, polynomials

OPTIONS = (
    *materials(conducting=True, fluid_mu=0.02, fluid_kappa=0.1, solid_modulus=20.0),
    *materials(conducting=True, solid_kappa=0.3, solid_density=2.0, solid_alpha=1.0),
)
DEFAULTS = {"fsi_h": 0.025, "ts_max_time": 1.0, "fsi_output_dt": 0.1}

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
    heat = solid.alpha * solid.m0
    rho, u, T, v, sigma, T_s = np.eye(6 * POINTS).reshape(6, POINTS, 6 * POINTS)
    force = R * (T0 * rho + RHO0 * T) - 4 / 3 * gas.mu * D @ u
    flux, flux_s = gas.kappa * D @ T, solid.kappa_e * E @ T_s
    gains = [
        -RHO0 * D @ u,
        -D @ force,
        D @ flux - P0 * D @ u,
        E @ sigma,
        E @ v,
        E @ flux_s - P0 * E @ v,
    ]
    # points go from right to left
    conditions = {
        (1, 0): u[0],
        (2, 0): T[0],
        (1, -1): u[-1] - v[0],
        (2, -1): T[-1] - T_s[0],
        (3, 0): force[-1] + sigma[0],
        (5, 0): flux[-1] - flux_s[0],
        (3, -1): v[-1],
        (5, -1): T_s[-1],
    }
    weights = np.array([1.0, RHO0, RHO0 * gas.cv, solid.m0, 1.0 / solid.K, heat])
    values, vectors = eigenmodes(np.array(gains), weights, conditions)
    # what is slower than either layer alone is the state at rest under another pressure
    least = min(gas.kappa / (RHO0 * GAMMA * gas.cv), solid.kappa_e / heat)
    thermal = np.flatnonzero((values.imag == 0.0) & (values.real < -least))
    if not thermal.size:
        raise InputError("no thermal mode is found: expected conductivities closer to each other")
    found = thermal[np.argmax(values.real[thermal])]
    parts = vectors[found].real
    of_T = [*polynomials(x, parts[[2]]), *polynomials(x_s, parts[[5]])]
    T = np.concatenate([polynomial.linspace(201)[1] for polynomial in of_T])
    parts = parts / T[np.argmax(np.abs(T))]
    return Mode(values.real[found], polynomials(x, parts[:3]), polynomials(x_s, parts[3:]))


def build(opt: Opt) -> Problem:
    """The solid clamped at X = -1, the wall at x = 1, both of the temperature T0."""
    gas, solid = gas_of(opt, GAMMA, R), solid_of(opt)
    s, of_gas, of_solid = slowest(gas, solid)

    def in_gas(x, t=0.0):
        rho, u, T = (AMPLITUDE * np.exp(s * t) * part(x) for part in of_gas)
        return RHO0 + rho, u, T0 + T

    def in_solid(X, t=0.0):
        u, sigma, T = (AMPLITUDE * np.exp(s * t) * part(X) for part in of_solid)
        return u, sigma - P0, T0 + T, X + u / s

    layers = (
        SolidLayer("solid", solid, X[:2], in_solid, exact=in_solid),
        FluidLayer("gas", gas, X[1:], in_gas, exact=in_gas),
    )
    note = f"the mode decays as exp({s:.10g} t), as the linear equations have it"
    return Problem(layers, clamped(T=T0), Wall(X[2], T=T0), notes=(note,), units="none")
