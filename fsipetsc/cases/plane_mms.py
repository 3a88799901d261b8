"""A manufactured solution in two dimensions: gas | solid, periodic in X, with an interface that moves and bends.

Both fields are smooth and not linear, mu, kappa and kappa_e are above 0, the heat of the solid is coupled. The gas has a
wall of given temperature below, the topmost row of the solid is given. Velocity and temperature are continuous at the
interface; what traction and heat flux lack is supplied there (``jumps``), what the equations lack everywhere (``forcing``).

Derivatives in the forcing are taken by a step into the complex plane, Im f(z + i s)/s, which is exact to round-off for s =
1e-30.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.boundaries.plane import Given, NoSlip
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer

NAME = "plane_mms"
SUMMARY = "gas | solid in two dimensions, a manufactured solution whose errors can be measured"

OPTIONS = (
    Option("fluid_mu", float, 0.02, "Pa s", "viscosity of the gas", check="nonnegative"),
    Option("fluid_kappa", float, 0.03, "W/(m K)", "heat conductivity of the gas", check="nonnegative"),
    Option("solid_law", str, "log", "", "law of the solid", ("log", "neo-hookean", "svk")),
    Option("solid_kappa", float, 0.05, "W/(m K)", "heat conductivity of the solid", check="nonnegative"),
)
DEFAULTS = {"fsi_h": 1 / 32, "fsi_order": 4, "ts_max_time": 0.25, "fsi_output_dt": 0.05}

PI2 = 2.0 * np.pi
#: step into the complex plane
TINY = 1e-30
Array = np.ndarray


class Motion(NamedTuple):
    """Displacement of the solid, its velocity, and the derivatives of both along X and Y."""

    x: Array
    y: Array
    u: Array
    v: Array
    x_X: Array
    x_Y: Array
    y_X: Array
    y_Y: Array
    u_X: Array
    u_Y: Array
    v_X: Array
    v_Y: Array


def motion(X: Array, Y: Array, t: float) -> Motion:
    """(x, y) - (X, Y) = (.06 sin(2 pi X + t) cos(Y + 2t), .08 cos(2 pi X - t) sin(1.5 Y + t))."""
    a, b, c, d = PI2 * X + t, Y + 2 * t, PI2 * X - t, 1.5 * Y + t
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    sc, cc, sd, cd = np.sin(c), np.cos(c), np.sin(d), np.cos(d)
    e, f = 0.06, 0.08
    return Motion(
        *(e * sa * cb, f * cc * sd),
        *(e * (ca * cb - 2 * sa * sb), f * (sc * sd + cc * cd)),
        *(e * PI2 * ca * cb, -e * sa * sb, -f * PI2 * sc * sd, 1.5 * f * cc * cd),
        *(e * PI2 * (-sa * cb - 2 * ca * sb), e * (-ca * sb - 2 * sa * cb)),
        *(f * PI2 * (cc * sd - sc * cd), 1.5 * f * (sc * cd - cc * sd)),
    )


def temperature(X: Array, Y: Array, t: float) -> tuple[Array, Array, Array]:
    """T = 1 + .15 sin(2 pi X + t) cos(2 Y - t) in both layers, and its derivatives along X and Y."""
    a, b = PI2 * X + t, 2 * Y - t
    return (
        1 + 0.15 * np.sin(a) * np.cos(b),
        0.15 * PI2 * np.cos(a) * np.cos(b),
        -0.3 * np.sin(a) * np.sin(b),
    )


def density(X: Array, Y: Array, t: float) -> Array:
    """Of the gas."""
    return 1 + 0.2 * np.cos(PI2 * X - t) * np.sin(2 * Y + t)


class GasPoint(NamedTuple):
    """U J first, then the fluxes along X and along Y, of (J, J rho, J rho u, J rho v, J e); heat: the part of those of
    energy.
    """

    U: tuple[Array, ...]
    along: tuple[Array, ...]
    across: tuple[Array, ...]
    heat: Array


def gas_point(gas: Fluid, X: Array, Y: Array, t: float) -> GasPoint:
    """Of the exact solution: the grid goes straight from y = 0 to the interface, the gas a little besides."""
    one = np.ones_like(X)
    m = motion(X, one, t)
    x_X, x_Y, y_X, y_Y = 1 + Y * m.x_X, m.x, Y * m.y_X, 1 + m.y
    J, wx, wy = x_X * y_Y - x_Y * y_X, Y * m.u, Y * m.v
    bump, slope, a, b = Y * (1 - Y), 1 - 2 * Y, PI2 * X - t, PI2 * X + 2 * t
    u, v = wx + 0.6 * bump * np.sin(a), wy + 0.5 * bump * np.cos(b)
    u_X, u_Y = Y * m.u_X + 0.6 * PI2 * bump * np.cos(a), m.u + 0.6 * slope * np.sin(a)
    v_X, v_Y = Y * m.v_X - 0.5 * PI2 * bump * np.sin(b), m.v + 0.5 * slope * np.cos(b)
    T, T_X, T_Y = temperature(X, Y, t)
    rho = density(X, Y, t)
    p, e = rho * gas.R * T, rho * (gas.cv * T + 0.5 * (u * u + v * v))
    metrics = (y_Y, -x_Y), (-y_X, x_X)

    def gradient(f_X: Array, f_Y: Array) -> tuple[Array, Array]:
        return tuple((metrics[0][c] * f_X + metrics[1][c] * f_Y) / J for c in range(2))

    (ux, uy), (vx, vy), (Tx, Ty) = gradient(u_X, u_Y), gradient(v_X, v_Y), gradient(T_X, T_Y)
    third = 2.0 / 3.0 * gas.mu
    xx, yy, xy = third * (2 * ux - vy), third * (2 * vy - ux), gas.mu * (uy + vx)

    def flux(ax: Array, ay: Array) -> tuple[Array, ...]:
        V, w = ax * u + ay * v, ax * wx + ay * wy
        work = ax * (u * xx + v * xy + gas.kappa * Tx) + ay * (u * xy + v * yy + gas.kappa * Ty)
        return (
            -w,
            rho * (V - w),
            rho * u * (V - w) + ax * (p - xx) - ay * xy,
            rho * v * (V - w) + ay * (p - yy) - ax * xy,
            e * (V - w) + p * V - work,
        )

    heat = -gas.kappa * (metrics[1][0] * Tx + metrics[1][1] * Ty)
    return GasPoint((J, J * rho, J * rho * u, J * rho * v, J * e), flux(*metrics[0]), flux(*metrics[1]), heat)


class SolidPoint(NamedTuple):
    """(u, v, alpha m0 T), fluxes along X and Y, and the work of the stresses."""

    U: tuple[Array, ...]
    along: tuple[Array, ...]
    across: tuple[Array, ...]
    work: Array


def solid_point(solid: PlaneSolid, X: Array, Y: Array, t: float) -> SolidPoint:
    """Of the exact solution."""
    m = motion(X, Y, t)
    F = 1 + m.x_X, m.x_Y, m.y_X, 1 + m.y_Y
    p11, p12, p21, p22 = solid.stress(F)
    T, T_X, T_Y = temperature(X, Y, t)
    J = F[0] * F[3] - F[1] * F[2]
    c11, c12, c22 = F[0] ** 2 + F[2] ** 2, F[0] * F[1] + F[2] * F[3], F[1] ** 2 + F[3] ** 2
    heat = solid.kappa_e / J * (c22 * T_X - c12 * T_Y), solid.kappa_e / J * (c11 * T_Y - c12 * T_X)
    work = p11 * m.u_X + p12 * m.u_Y + p21 * m.v_X + p22 * m.v_Y
    return SolidPoint((m.u, m.v, T), (p11, p21, heat[0]), (p12, p22, heat[1]), work)


def _stepped(function: Callable[..., Any], X: Array, Y: Array, t: float, which: int) -> Any:
    """function(X, Y, t) with a step into the complex plane in one of the three."""
    arguments = [np.asarray(X, complex), np.asarray(Y, complex), complex(t)]
    arguments[which] = arguments[which] + 1j * TINY
    return function(*arguments)


def _slope(values: tuple[Array, ...], c: int) -> Array:
    return values[c].imag / TINY


def build(opt: Mapping[str, Any]) -> PlaneProblem:
    """The gas between Y = 0 and 1, the solid between 1 and 2."""
    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], 1.4, 1.0)
    solid = PlaneSolid(1.0, 2.0, opt["solid_kappa"], 2.0, 1.5, law=opt["solid_law"])

    def exact_gas(X: Array, Y: Array, t: float) -> list[Array]:
        rho, (T, _, _) = density(X, Y, t), temperature(X, Y, t)
        _, r, m, n, _ = gas_point(gas, X, Y, t).U
        return [rho, m / r, n / r, T]

    def exact_solid(X: Array, Y: Array, t: float) -> list[Array]:
        m = motion(X, Y, t)
        return [m.u, m.v, temperature(X, Y, t)[0], X + m.x, Y + m.y]

    def force_gas(X: Array, Y: Array, t: float) -> list[Array]:
        points = [_stepped(lambda *a: gas_point(gas, *a), X, Y, t, which) for which in range(3)]
        J = points[0].U[0].real
        return [(_slope(points[2].U, c) + _slope(points[0].along, c) + _slope(points[1].across, c)) / J for c in range(1, 5)]

    def force_solid(X: Array, Y: Array, t: float) -> list[Array]:
        points = [_stepped(lambda *a: solid_point(solid, *a), X, Y, t, which) for which in range(3)]
        divergence = [_slope(points[0].along, c) + _slope(points[1].across, c) for c in range(3)]
        u, v, T = (_slope(points[2].U, c) for c in range(3))
        heating = (divergence[2] + points[0].work.real) / (solid.m0 * solid.alpha)
        zero = np.zeros_like(X)
        return [u - divergence[0] / solid.m0, v - divergence[1] / solid.m0, T - heating, zero, zero]

    def jumps(k: int, X: Array, t: float) -> list[Array]:
        one = np.ones_like(X)
        below, above = gas_point(gas, X, one, t), solid_point(solid, X, one, t)
        return [-below.across[2] - above.across[0], -below.across[3] - above.across[1], -below.heat - above.across[2]]

    return PlaneProblem(
        layers=(
            PlaneFluidLayer("gas", gas, (0.0, 1.0), partial(exact_gas, t=0.0), forcing=force_gas, exact=exact_gas),
            PlaneSolidLayer("solid", solid, (1.0, 2.0), partial(exact_solid, t=0.0), forcing=force_solid, exact=exact_solid),
        ),
        X=(0.0, 1.0),
        lower=NoSlip(T=lambda X, Y, t: temperature(X, Y, t)[0]),
        upper=Given(exact_solid),
        jumps=jumps,
        units="none",
    )
