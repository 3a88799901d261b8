"""Layers of gas and solid in one dimension: the paper's cases, a box, a column, a piston."""

from functools import partial

import numpy as np

from fsipetsc import FluidLayer, InputError, Option, Problem, SolidLayer
from fsipetsc.boundaries import Dirichlet, Open, Wall, absorbing, clamped
from fsipetsc.cases.common import Opt, case, constant, gas_of, line_at_rest, materials, solid_of
from fsipetsc.cases.manufactured import recorded
from fsipetsc.equations.elementary import exp, power
from fsipetsc.kernels.symbols import derivatives


@case(
    {"fsi_h": 0.0125, "ts_max_time": 3.0, "fsi_output_dt": 0.05},
    *materials(fluid_mu=0.5, fluid_kappa=0.7, fluid_gamma=1.4, fluid_R=8.3145 / 0.029),
    *materials(solid_modulus=1e5, solid_kappa=0.5, solid_density=2700.0, solid_alpha=1.0),
    *materials(solid_gruneisen=0.0),
    Option("rod_gravity", float, -10.0, "m/s2", "body force per mass on the rod"),
    Option("rod_p0", float, 1e5, "Pa", "initial pressure of the gas", check="positive"),
    Option("rod_T0", float, 300.0, "K", "initial temperature", check="positive"),
    Option("rod_wall", float, 0.0, "m", "position of the lower wall, below 1"),
    Option("rod_top", float, 6.0, "m", "position of the open upper end, above 2"),
)
def rod(opt: Opt) -> Problem:
    """An elastic rod falls into a compressible gas and bounces (Sec. 5.2): fluid | solid | fluid.

    The paper does not give the initial state of the gas: 1e5 Pa and 300 K are inferred from its
    figures, and the rod starts under the stress -p0, so that only gravity disturbs the rest.
    """
    gas, rod = gas_of(opt), solid_of(opt, force=opt["rod_gravity"])
    p0, T0, wall, top = (opt[f"rod_{name}"] for name in ("p0", "T0", "wall", "top"))
    still = constant(p0 / (gas.R * T0), 0.0, T0)
    layers = (
        FluidLayer("below", gas, (wall, 1.0), still),
        SolidLayer("rod", rod, (1.0, 2.0), line_at_rest(rod.pressure(T0, 1.0) - p0, T0)),
        FluidLayer("above", gas, (2.0, top), still),
    )
    return Problem(layers, left=Wall(wall), right=Open(top, p0, T0))


@case(
    {"fsi_h": 0.0125, "fsi_coupling": "projection", "ts_max_time": 0.45, "fsi_output_dt": 0.05},
    *materials(fluid_mu=0.01, fluid_kappa=0.03, fluid_gamma=1.4, fluid_R=1.0),
    *materials(solid_modulus=10.0, solid_kappa=0.02, solid_density=2.0, solid_alpha=1.0),
)
def mms(opt: Opt) -> Problem:
    """A manufactured solution in fluid | solid | fluid: errors against the exact one (Sec. 5.1).

    The fields (5.1), (5.2) are given in the coordinate X of each layer's own grid; x is given in
    the solid alone. So the forcing of a fluid contains the exact velocity s of its frame, that at
    its interface point X_I, and the boundaries lie at X = X_I + x_boundary - x(X_I, t).
    """
    if opt["fsi_coupling"] == "conservative":
        problem = "the solution of mms is a function of X in a rigid frame"
        raise InputError(f"-fsi_coupling: {problem}: expected projection, energy or traditional")
    gas, solid = gas_of(opt), solid_of(opt)

    def in_gas(X, t=0.0):
        u = np.cos(2.0 * X + 0.47) * np.sin(t)
        return 1 + 0.5 * np.sin(2 * X) * np.cos(t), u, 10 + np.cos(2 * X) * np.sin(3 * t)

    def in_solid(X, t=0.0):
        """Return (u, sigma, T, x)."""
        g = 1 + X + 0.2 * np.sin(2 * np.pi * X)
        sigma, T = np.sin(t * t) * np.sin(2 * X), 5 + np.cos(t) * np.sin(3 * X)
        return t * g, sigma, T, X + 0.5 * t * t * g

    def on_gas(X_I, X, t):
        """What the exact solution leaves over in (4.20)."""
        rho, u, T = fields = in_gas(X, t)
        (rho_t, u_t, T_t), (rho_X, u_X, T_X) = (derivatives(fields, y) for y in (t, X))
        past, pushing = u - in_gas(X_I, t)[1], gas.R * rho * T - 4 / 3 * gas.mu * u_X
        pushed, conducted = derivatives((pushing, gas.kappa * T_X), X)
        mass = rho_t + rho_X * past + rho * u_X
        force = rho * (u_t + past * u_X) + pushed
        heat = rho * gas.cv * (T_t + past * T_X) + pushing * u_X - conducted
        return mass, mass * u + force, mass * (gas.cv * T + 0.5 * u * u) + u * force + heat

    def on_solid(X, t):
        """What the exact solution leaves over in (4.19), with p = 0."""
        fields = in_solid(X, t)
        (u_t, sigma_t, T_t, _), (u_X, sigma_X, T_X, x_X) = (derivatives(fields, y) for y in (t, X))
        conducted = derivatives([solid.kappa_e * T_X / x_X], X)[0]
        rates = u_t - sigma_X / solid.m0, sigma_t - solid.K / x_X * u_X
        return *rates, T_t - (fields[1] * u_X + conducted) / (solid.alpha * solid.m0), 0.0

    def left_over(X, t):
        """Of u_s = u_f, the stress, T_s = T_f and the heat-flux condition."""
        (rho, u, T), (v, sigma, T_s, x) = in_gas(X, t), in_solid(X, t)
        (u_X, T_X), (T_s_X, x_X) = derivatives((u, T), X), derivatives((T_s, x), X)
        stress = sigma + gas.R * rho * T - 4 / 3 * gas.mu * u_X
        return v - u, stress, T_s - T, solid.kappa_e / x_X * T_s_X - gas.kappa * T_X

    def fluid(name, X, X_I, x):  # x: the boundary
        end = Dirichlet(x, lambda t: in_gas(X_I + x - in_solid(X_I, t)[3], t))
        return FluidLayer(name, gas, X, in_gas, recorded(2, partial(on_gas, X_I)), in_gas), end

    left, begin = fluid("left", (0.25, 1.0), 1.0, 0.25)
    middle = SolidLayer("solid", solid, (1.0, 2.0), in_solid, recorded(2, on_solid), in_solid)
    right, end = fluid("right", (2.0, 4.0), 2.0, 4.0)
    jumps = recorded(2, lambda k, t: left_over(k + 1.0, t))
    return Problem((left, middle, right), begin, end, jumps=jumps, units="none")


@case(
    {"fsi_h": 0.0125, "fsi_coupling": "projection", "ts_max_time": 4e-3, "fsi_output_dt": 2e-4},
    *materials(fluid_mu=0.0, fluid_kappa=0.0, fluid_gamma=1.4, fluid_R=8.3145 / 0.029),
    *materials(solid_modulus=1e6, solid_kappa=0.0, solid_density=4.0, solid_alpha=1000.0),
    *materials(solid_gruneisen=0.0),
    Option("pulse_amplitude", float, 1.0, "Pa", "pressure of the pulse, small against p0"),
    Option("pulse_width", float, 0.12, "m", "width of exp(-(distance/width)^2)", check="positive"),
    Option("pulse_start", float, 0.75, "m", "where it starts: above 0 in the fluid, or below"),
)
def pulse(opt: Opt) -> Problem:
    """A sound pulse meets the interface of the two-domain problem (Fig. 2, Sec. 4): solid | fluid.

    Both materials rest under the pressure p0. A Gaussian pulse travels to the interface at X = 0.
    Linear acoustics gives the solution, exact but for the square of the amplitude, viscosity and
    conduction: with the impedances Z = rho c of the gas and m0 c of the solid the reflected
    pressure is (Z2-Z1)/(Z2+Z1), the transmitted one 2 Z2/(Z1+Z2) of the incoming one. In the solid
    p - sigma changes by -m0 c^2 times the strain.
    """
    from scipy.special import erf

    gas, solid, start = gas_of(opt), solid_of(opt), opt["pulse_start"]
    p0, T0, size = 1e5, 300.0, 1.5  # at rest; thickness of either layer
    if not 0 < abs(start) < size:
        raise InputError(f"-pulse_start {start:g}: expected 0 < |start| < {size:g}, within a layer")
    sigma, in_fluid = solid.pressure(T0) - p0, start > 0
    c_f, c_s = float(gas.sound_speed(T0)), solid.sound_speed(1.0, T0, sigma)
    media = (p0 / (gas.R * T0) * c_f, c_f), (solid.m0 * c_s, c_s)
    (Z1, c1), (Z2, c2) = media if in_fluid else media[::-1]
    reflection, transmission = (Z2 - Z1) / (Z2 + Z1), 2 * Z2 / (Z1 + Z2)
    arrival, duration = abs(start) / c1, opt["pulse_width"] / c1

    def waves(X, t, first):
        """(pressure, velocity, displacement) at X in the first or the second medium."""
        Z, c = (Z1, c1) if first else (Z2, c2)
        side = 1.0 if first == in_fluid else -1.0
        # part of the pressure, way, time at which it was at the interface
        trains = [(reflection if first else transmission, side, t - np.abs(X) / c)]
        if first:
            trains.append((1.0, -side, t + np.abs(X) / c))
        p, u, moved = np.zeros((3, *np.shape(X)))
        for part, way, time in trains:
            z, height = (time - arrival) / duration, part * opt["pulse_amplitude"]
            p, u = p + height * exp(-z * z), u + way / Z * height * exp(-z * z)
            moved = moved + way / Z * height * 0.5 * np.sqrt(np.pi) * duration * (1.0 + erf(z))
        return p, u, moved

    def exact_gas(X, t=0.0):
        p, u, _ = waves(X, t, in_fluid)
        T = T0 * (1 + (gas.gamma - 1) / gas.gamma * p / p0)
        return (p0 + p) / (gas.R * T), u, T

    def exact_solid(X, t=0.0):
        p, u, displacement = waves(X, t, not in_fluid)
        strain = -p / (solid.m0 * c_s**2)
        T = T0 - p0 * strain / (solid.alpha * solid.m0)
        return u, sigma + solid.K * strain, T, X + displacement

    left = SolidLayer("solid", solid, (-size, 0.0), exact_solid, exact=exact_solid)
    layers = left, FluidLayer("gas", gas, (0.0, size), exact_gas, exact=exact_gas)
    note = f"linear acoustics: {reflection:.6g} are reflected, {transmission:.6g} go through"
    return Problem(layers, absorbing(-p0), Open(size, p0, T0), notes=(note,))


@case(
    {"fsi_h": 0.0125, "ts_max_time": 2.0, "fsi_output_dt": 0.05},
    *materials(fluid_mu=0.01, fluid_kappa=0.03, fluid_gamma=1.4, solid_modulus=20.0),
    *materials(solid_kappa=0.02, solid_density=2.0, solid_alpha=1.0, solid_gruneisen=0.0),
)
def box(opt: Opt) -> Problem:
    """Gas | solid | gas in a closed box with adiabatic walls, which conserves mass and energy.

    The gas on the left is hotter and under a higher pressure than that on the right. At the walls
    and interfaces the initial state is flat to the sixth derivative, so that it satisfies all
    conditions there, as time goes on, too.
    """
    gas, solid = gas_of(opt), solid_of(opt)
    P, T = (2.2, 2.0), (5.0, 4.0)  # on the left, on the right
    left, right = (constant(p / (gas.R * t), 0.0, t) for p, t in zip(P, T))

    def between(X):
        z = X - 1.0  # from 0 to 1, as what is done is
        done = z**7 * np.polyval([924, -6006, 16380, -24024, 20020, -9009, 1716], z)
        p, t = P[0] + (P[1] - P[0]) * done, T[0] + (T[1] - T[0]) * done
        return [np.zeros_like(X), solid.pressure(t, 1.0) - p, t, X]

    layers = (
        FluidLayer("left", gas, (0.0, 1.0), left),
        SolidLayer("solid", solid, (1.0, 2.0), between),
        FluidLayer("right", gas, (2.0, 3.0), right),
    )
    return Problem(layers, Wall(0.0), Wall(3.0), units="none")


@case(
    {"fsi_h": 0.025, "ts_max_time": 4.0, "fsi_output_dt": 0.05},
    *materials(fluid_mu=0.01, fluid_kappa=0.03, solid_modulus=20.0, solid_kappa=0.02),
    *materials(solid_density=2.0, solid_alpha=1.0),
    Option("column_pulse", float, 0.5, "", "overpressure / p0", check="nonnegative"),
)
def column(opt: Opt) -> Problem:
    """A column of five layers, solid | gas | solid | gas | solid: a pulse runs through all of them.

    The outer solids are clamped, so nothing leaves: the mass of both gases, the total energy and,
    with the impulse of the two ends, the momentum stay what they are, to round-off.
    """
    gas, solid = gas_of(opt), solid_of(opt)

    def pulse(X):
        p = 1 + opt["column_pulse"] * exp(-(((X - 1.5) / 0.12) ** 2))
        rho = power(p, 1 / gas.gamma)
        return [rho, 0 * X, power(rho, gas.gamma - 1)]

    still, rest = constant(1.0, 0.0, 1.0), line_at_rest(-1.0, 1.0)
    layers = (
        SolidLayer("bottom", solid, (0.0, 1.0), rest),
        FluidLayer("lower gas", gas, (1.0, 2.0), pulse),
        SolidLayer("plate", solid, (2.0, 2.5), rest),
        FluidLayer("upper gas", gas, (2.5, 3.5), still),
        SolidLayer("top", solid, (3.5, 4.5), rest),
    )
    return Problem(layers, clamped(), clamped(), units="none")


@case(
    {"fsi_h": 0.0125, "ts_max_time": 0.04, "fsi_output_dt": 5e-4},
    *materials(fluid_mu=1.8e-5, fluid_kappa=0.026, solid_modulus=1e7, solid_kappa=0.2),
    *materials(solid_density=100.0, solid_alpha=1000.0),
    Option("piston_time", float, 0.02, "s", "time that the wall takes", check="positive"),
)
def piston(opt: Opt) -> Problem:
    """A wall that moves drives gas against an elastic layer, behind which more gas lies.

    The wall on the left moves in by 0.3 m and comes to rest, x = 0.3 sin^2(pi t / (2 time)).
    """
    gas, solid, time = gas_of(opt, R=287.0), solid_of(opt), opt["piston_time"]
    stroke, p0, T0 = 0.3, 1e5, 300.0
    still = constant(p0 / (gas.R * T0), 0.0, T0)
    phase = lambda t: 0.5 * np.pi * np.minimum(t, time) / time  # noqa: E731
    speed = lambda t: stroke * np.pi / time * np.sin(phase(t)) * np.cos(phase(t))  # noqa: E731
    wall = Wall(lambda t: stroke * np.sin(phase(t)) ** 2, velocity=speed)
    layers = (
        FluidLayer("driven", gas, (0.0, 1.0), still),
        SolidLayer("layer", solid, (1.0, 1.2), line_at_rest(-p0, T0)),
        FluidLayer("behind", gas, (1.2, 2.2), still),
    )
    return Problem(layers, wall, Wall(2.2))
