"""Layers of gas and solid in one dimension: the paper's rod and pulse, a box, a column, a piston.
Normal modes of layers, exact for small motions, by an eigenvalue problem across the layers.
"""

from typing import Any

import numpy as np
from numpy.polynomial import Chebyshev

from fsipetsc import BlockProblem, FluidLayer, InputError, Layer, Option, Problem, SolidLayer
from fsipetsc.blocks.conditions import Clamped, NoSlip, Slip
from fsipetsc.boundaries import Open, Wall, absorbing, clamped
from fsipetsc.cases import common
from fsipetsc.cases.common import Opt, case, constant, gas_of, line_at_rest, materials, solid_of
from fsipetsc.checks import Array
from fsipetsc.equations.elementary import exp, power


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
    below = FluidLayer("below", gas, (wall, 1.0), still)
    middle = SolidLayer("rod", rod, (1.0, 2.0), line_at_rest(rod.pressure(T0, 1.0) - p0, T0))
    above = FluidLayer("above", gas, (2.0, top), still)
    return Problem((below, middle, above), left=Wall(wall), right=Open(top, p0, T0))


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

    The gas on the left is hotter and under a higher pressure than that on the right. At walls and
    interfaces the initial state is flat to the sixth derivative, so all conditions hold there.
    """
    gas, solid = gas_of(opt), solid_of(opt)
    P, T = (2.2, 2.0), (5.0, 4.0)  # on the left, on the right
    hot, cool = (constant(p / (gas.R * t), 0.0, t) for p, t in zip(P, T))

    def between(X):
        z = X - 1.0  # from 0 to 1, as what is done is
        seventh = z * z**2 * (z**2) ** 2
        done = seventh * np.polyval([924, -6006, 16380, -24024, 20020, -9009, 1716], z)
        p, t = P[0] + (P[1] - P[0]) * done, T[0] + (T[1] - T[0]) * done
        return [np.zeros_like(X), solid.pressure(t, 1.0) - p, t, X]

    left = FluidLayer("left", gas, (0.0, 1.0), hot)
    middle = SolidLayer("solid", solid, (1.0, 2.0), between)
    right = FluidLayer("right", gas, (2.0, 3.0), cool)
    return Problem((left, middle, right), Wall(0.0), Wall(3.0), units="none")


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
    bottom = SolidLayer("bottom", solid, (0.0, 1.0), rest)
    lower = FluidLayer("lower gas", gas, (1.0, 2.0), pulse)
    plate = SolidLayer("plate", solid, (2.0, 2.5), rest)
    upper = FluidLayer("upper gas", gas, (2.5, 3.5), still)
    top = SolidLayer("top", solid, (3.5, 4.5), rest)
    return Problem((bottom, lower, plate, upper, top), clamped(), clamped(), units="none")


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
    driven = FluidLayer("driven", gas, (0.0, 1.0), still)
    layer = SolidLayer("layer", solid, (1.0, 1.2), line_at_rest(-p0, T0))
    behind = FluidLayer("behind", gas, (1.2, 2.2), still)
    return Problem((driven, layer, behind), wall, Wall(2.2))


#: points of the collocation in either layer
POINTS = 36


def chebyshev(n: int, low: float, high: float) -> tuple[Array, Array]:
    """(n points from high to low, matrix D) (Trefethen, Spectral Methods in MATLAB, ch. 6)."""
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


def interface_mode(gas: Any, solid: Any, k: float, height: float, depth: float) -> Any:
    """s of the mode of `wave`, amplitudes over Y of rho, u, v, T and of x, y, u, v. InputError."""
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
            return s, of_gas, of_solid
    raise InputError("no normal mode of the layers is resolved")


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
    gas, solid = gas_of(opt), common.elastic_of(opt)
    k, size, height, depth = 2.0 * np.pi, 1e-5, 1.0, 0.5
    s, of_gas, of_solid = interface_mode(gas, solid, k, height, depth)

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
    return common.stack(opt, below, above, notes=(note,), **ends)
