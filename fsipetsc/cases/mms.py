"""A manufactured solution in fluid | solid | fluid: errors against the exact one (Sec. 5.1).

There is forcing in the layers and at the interfaces. The fields (5.1), (5.2) are given in the
coordinate X of each layer's own grid; x is given in the solid alone. So the forcing of a fluid
contains the exact velocity s of its frame, the fluid's at its interface point, and the embedded
boundaries lie at X = X_I + x_boundary - x(X_I, t). Density, velocity and temperature at the
boundaries are exact data; the four interface conditions get the jumps of the exact solution.
"""

from math import cos, sin

import numpy as np

from fsipetsc import Dirichlet, FluidLayer, InputError, Problem, SolidLayer
from fsipetsc.cases.common import PAPER, Opt, gas_of, materials, solid_of
from fsipetsc.checks import Array, Fields

OPTIONS = (
    *materials(fluid_mu=0.01, fluid_kappa=0.03, fluid_gamma=1.4, fluid_R=1.0),
    *materials(solid_modulus=10.0, solid_kappa=0.02, solid_density=2.0, solid_alpha=1.0),
)
DEFAULTS = {**PAPER, "ts_max_time": 0.45, "fsi_output_dt": 0.05}

LEFT, RIGHT = 0.25, 4.0
#: epsilon, omega, phi of (5.1), (5.2)
EPS, OMEGA, PHI = 0.2, 2.0, 0.47


# A field is a function of t times a *mode* in X, plus 1, 10, …


def fluid_modes(X: Array) -> Fields:
    """Modes of rho, u, T, then their X-derivatives, then the second ones of u, T."""
    w = OMEGA
    rho, u, T = 0.5 * np.sin(w * X), np.cos(w * X + PHI), np.cos(2 * X)
    slopes = 0.5 * w * np.cos(w * X), -w * np.sin(w * X + PHI), -2 * np.sin(2 * X)
    return rho, u, T, *slopes, -w * w * u, -4 * T


def solid_modes(X: Array) -> Fields:
    """Modes of u and x-X, of sigma, of T, then their X-derivatives, then the second of x, T."""
    w, a = OMEGA, 2 * np.pi
    modes = 1 + X + EPS * np.sin(a * X), np.sin(w * X), np.sin(3 * X)
    slopes = 1 + EPS * a * np.cos(a * X), w * np.cos(w * X), 3 * np.cos(3 * X)
    return *modes, *slopes, -EPS * a * a * np.sin(a * X), -9 * modes[2]


def exact_fluid(X: Array, t: float = 0.0) -> Fields:
    """Return (rho, u, T) of (5.1)."""
    rho, u, T, *_ = fluid_modes(X)
    return 1 + cos(t) * rho, sin(t) * u, 10 + sin(3 * t) * T


def exact_solid(X: Array, t: float = 0.0) -> Fields:
    """Return (u, sigma, T, x) of (5.2)."""
    g, sigma, T, *_ = solid_modes(X)
    return t * g, sin(t * t) * sigma, 5 + cos(t) * T, X + 0.5 * t * t * g


def fluid_forcing(gas: object, X: Array, X_I: float, t: float) -> Fields:
    """What the exact solution leaves over in (4.20), in the frame of the interface at X_I."""
    modes, s, mu = fluid_modes(X), exact_fluid(X_I, t)[1], 4 / 3 * gas.mu
    a, b, c = cos(t), sin(t), sin(3 * t)
    rho, u, T = exact_fluid(X, t)
    rho_t, u_t, T_t = -sin(t) * modes[0], cos(t) * modes[1], 3 * cos(3 * t) * modes[2]
    rho1, u1, T1 = a * modes[3], b * modes[4], c * modes[5]
    u2, T2 = b * modes[6], c * modes[7]
    p, p1 = gas.R * rho * T, gas.R * (rho1 * T + rho * T1)
    mass = rho_t + rho1 * (u - s) + rho * u1
    force = rho * (u_t + (u - s) * u1) + p1 - mu * u2
    heat = rho * gas.cv * (T_t + (u - s) * T1) + p * u1 - mu * u1 * u1 - gas.kappa * T2
    return mass, mass * u + force, mass * (gas.cv * T + 0.5 * u * u) + u * force + heat


def solid_forcing(solid: object, X: Array, t: float) -> Fields:
    """Return what the exact solution leaves over in (4.19), with p = 0."""
    modes, b, half = solid_modes(X), sin(t * t), 0.5 * t * t
    u1, sigma1, T1 = t * modes[3], b * modes[4], cos(t) * modes[5]
    x1, x2, T2 = 1 + half * modes[3], half * modes[6], cos(t) * modes[7]
    conduction = solid.kappa_e * (T2 / x1 - T1 * x2 / (x1 * x1))
    heat = (b * modes[1] * u1 + conduction) / (solid.alpha * solid.m0)
    rates = 2 * t * cos(t * t) * modes[1] - solid.K / x1 * u1, -sin(t) * modes[2] - heat
    return modes[0] - sigma1 / solid.m0, *rates, 0.0 * X


def build(opt: Opt) -> Problem:
    """Solid in 1 < X < 2, fluid beside it in 1/4 < x < 4."""
    if opt["fsi_coupling"] == "conservative":
        problem = "the solution of mms is a function of X in a rigid frame"
        wanted = "take projection, energy or traditional"
        raise InputError(f"-fsi_coupling conservative: {problem}: {wanted}")
    gas, solid = gas_of(opt), solid_of(opt)

    def jumps(k, t):
        """Left over in u_s = u_f, the stress, T_s = T_f and the heat-flux condition."""
        X_I = (1.0, 2.0)[k]
        rho, uf, Tf = exact_fluid(X_I, t)
        us, sigma, Ts, _ = exact_solid(X_I, t)
        uf1, Tf1 = fluid_modes(X_I)[4:6]
        g1, _, Ts1 = solid_modes(X_I)[3:6]
        stress = sigma + gas.R * rho * Tf - 4 / 3 * gas.mu * sin(t) * uf1
        flux = solid.kappa_e / (1 + 0.5 * t * t * g1) * cos(t) * Ts1 - gas.kappa * sin(3 * t) * Tf1
        return us - uf, stress, Ts - Tf, flux

    def end(x, X_I):
        return Dirichlet(x, lambda t: exact_fluid(X_I + x - exact_solid(X_I, t)[3], t))

    def of_solid(X, t):
        return solid_forcing(solid, X, t)

    def fluid(name, X, X_I):
        forcing = lambda X, t: fluid_forcing(gas, X, X_I, t)  # noqa: E731
        return FluidLayer(name, gas, X, exact_fluid, forcing, exact_fluid)

    layers = (
        fluid("left", (LEFT, 1.0), 1.0),
        SolidLayer("solid", solid, (1.0, 2.0), exact_solid, of_solid, exact_solid),
        fluid("right", (2.0, RIGHT), 2.0),
    )
    return Problem(layers, end(LEFT, 1.0), end(RIGHT, 2.0), jumps=jumps, units="none")
