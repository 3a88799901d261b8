"""The Riemann problem of a perfect gas and an elastic solid, which meet with a jump, solved
exactly; and shocks in a gas.

The gas stands on the left, the solid on the right; nothing is viscous or conducts heat. Both sides
have one velocity u and one pressure p at the interface, their temperatures differ. A wave, shock or
fan, goes into either side. Gas: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid
Dynamics, 3rd ed., Springer 2009, Sec. 4.2 to 4.5. Solid, with F = x_X and E = alpha m0 T:

    F_t = u_X,    m0 u_t = sigma_X,    (m0 u^2/2 + E)_t = (sigma u)_X,    sigma - K ln F = const.

The wave speed c over X, c^2 = K / (m0 F), falls with F: compression makes a shock, expansion a fan.
Across a shock of speed s into the state 0,

    u - u0 = -s (F - F0),    m0 s^2 (F - F0) = sigma - sigma0,
    E - E0 = (sigma + sigma0)/2 (F - F0),

and through a fan E_F = sigma, and u + int c dF is what it was before.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fsipetsc import Fluid, InputError, Solid
from fsipetsc.blocks.conditions import Open
from fsipetsc.checks import Array, Fields

#: part of the jump that is left where a shock's structure is cut off
_TAIL = 1e-6


class GasState(NamedTuple):
    """Density [kg/m3], velocity [m/s], pressure [Pa]."""

    rho: Any
    u: Any
    p: Any


class SolidState(NamedTuple):
    """Velocity [m/s], sigma [Pa], temperature [K], F = x_X."""

    u: Any
    sigma: Any
    T: Any
    F: Any


def sound(gas: Fluid, state: GasState) -> Any:
    """Return the speed of sound [m/s]."""
    return np.sqrt(gas.gamma * state.p / state.rho)


def behind_shock(gas: Fluid, ahead: GasState, mach: float) -> tuple[GasState, float]:
    """(the gas behind a shock that goes to the right at a Mach number above 1, its speed [m/s])."""
    g = gas.gamma
    s = ahead.u + mach * sound(gas, ahead)
    rho = ahead.rho * (g + 1) * mach**2 / ((g - 1) * mach**2 + 2)
    p = ahead.p * (1 + 2 * g / (g + 1) * (mach**2 - 1))
    return GasState(rho, s - (s - ahead.u) * ahead.rho / rho, p), s


def shock_in_plane(
    gas: Fluid, ahead: GasState, mach: float, start: float
) -> tuple[Callable[[Array, Array], Fields], Open, str]:
    """Of a shock that is at X = start at first: initial data of a block, the inflow, a note."""
    behind, _ = behind_shock(gas, ahead, mach)
    hot, warm = (state.p / (gas.R * state.rho) for state in (behind, ahead))

    def flow(X: Array, Y: Array) -> Fields:
        values = (behind.rho, ahead.rho), (behind.u, ahead.u), (0.0, 0.0), (hot, warm)
        return [np.where(X < start, hit, still) for hit, still in values]

    note = f"behind the shock rho = {behind.rho:.6g}, u = {behind.u:.6g}, p = {behind.p:.6g}"
    return flow, Open(behind.rho, (behind.u, 0.0), hot), note


def shock_structure(
    gas: Fluid, ahead: GasState, mach: float, width: float, w: float = 0.0
) -> Callable[[Array], GasState]:
    """x [m] -> the gas in and around a shock that goes to the right, spread by dissipation.

    Its wave is width/2 (|u - w| + c) U_x = f(U) - s U - (f(U) - s U ahead), U = (rho, rho u, e):
    what the scheme of Lax and Friedrichs makes of it on a grid of spacing ``width`` [m] and
    velocity w [m/s]. It has the mass of a jump at x = 0. What begins with a jump instead sends
    waves after the shock until the shock has this structure.
    """
    from scipy.integrate import solve_ivp

    behind, s = behind_shock(gas, ahead, mach)
    low, high = (
        np.array([q.rho, q.rho * q.u, q.p / (gas.gamma - 1) + 0.5 * q.rho * q.u**2])
        for q in (ahead, behind)
    )

    def state(U: Any) -> GasState:
        u = U[1] / U[0]
        return GasState(U[0], u, (gas.gamma - 1) * (U[2] - 0.5 * U[1] * u))

    def flux(U: Array) -> Array:
        rho, u, p = state(U)
        return np.array([rho * u, rho * u * u + p, u * (U[2] + p)]) - s * U

    def slope(_: float, y: Array) -> Array:
        q = state(y[:3])
        return np.append(flux(y[:3]) - flux(high), 0.5 * width * (abs(q.u - w) + sound(gas, q)))

    c = sound(gas, behind)
    fast = np.array([1.0, behind.u + c, (high[2] + behind.p) / behind.rho + behind.u * c])
    start = np.append(high - _TAIL * behind.rho * fast, 0.0)
    length = -np.log(_TAIL) * (1 / (behind.u + c - s) + 1 / (s - ahead.u - sound(gas, ahead)))
    accurate = {"rtol": 1e-9, "atol": 1e-12, "max_step": length / 400}
    *U, x = solve_ivp(slope, (0.0, length), start, **accurate).y
    excess = np.sum(np.diff(x) * (0.5 * (U[0][1:] + U[0][:-1]) - low[0]))
    x = x - excess / (high[0] - low[0])
    ends = list(zip(U, high, low, strict=True))
    return lambda at: state([np.interp(at, x, row, left=a, right=b) for row, a, b in ends])


class GasWave(NamedTuple):
    """What goes into a gas to the left, where it gets some pressure p [Pa] behind."""

    gas: Fluid
    before: GasState

    def velocity(self, p: Any) -> Any:
        """Return the velocity behind the wave [m/s]."""
        rho, u, p0 = self.before
        g = self.gas.gamma
        shock = (p - p0) * np.sqrt(2 / rho / ((g + 1) * p + (g - 1) * p0))
        fan = 2 * sound(self.gas, self.before) / (g - 1) * ((p / p0) ** ((g - 1) / (2 * g)) - 1)
        return u - np.where(p > p0, shock, fan)

    def behind(self, p: float) -> GasState:
        """Return the state behind the wave."""
        rho, _, p0 = self.before
        g, ratio = self.gas.gamma, p / p0
        shock = ((g + 1) * ratio + g - 1) / ((g - 1) * ratio + g + 1)
        compressed = ratio ** (1 / g) if p <= p0 else shock
        return GasState(rho * compressed, float(self.velocity(p)), p)

    def speeds(self, p: float) -> tuple[float, float]:
        """Speeds [m/s] of the front and of the back of the wave; a shock has one."""
        before, behind = self.before, self.behind(p)
        if p <= before.p:
            return before.u - sound(self.gas, before), behind.u - sound(self.gas, behind)
        s = (behind.rho * behind.u - before.rho * before.u) / (behind.rho - before.rho)
        return s, s

    def at(self, p: float, x: Array, t: float) -> GasState:
        """The states at a distance x [m] from where the wave was at t = 0."""
        if t <= 0:
            return GasState(*(value + 0.0 * x for value in self.before))
        g, speed, before, behind = self.gas.gamma, x / t, self.before, self.behind(p)
        front, back = self.speeds(p)
        c0 = sound(self.gas, before)
        c = np.clip((2 * c0 + (g - 1) * (before.u - speed)) / (g + 1), 0.0, None)
        ratio = (c / c0) ** (2 / (g - 1))
        fan = before.rho * ratio, speed + c, before.p * ratio**g
        which, states = [speed < front, speed < back], zip(before, fan, behind, strict=True)
        return GasState(*(np.select(which, [a, b], d) for a, b, d in states))


class SolidWave(NamedTuple):
    """What goes into a solid to the right, where it gets some pressure p [Pa] behind."""

    solid: Solid
    before: SolidState

    def strain(self, p: Any) -> Any:
        """Return F behind the wave."""
        return self.before.F * np.exp((-p - self.before.sigma) / self.solid.K)

    def velocity(self, p: Any) -> Any:
        """Return the velocity behind the wave [m/s]."""
        return self._state(self.strain(p)).u

    def _state(self, F: Any) -> SolidState:
        """Return the state behind the wave, or within the fan, where F is."""
        (u0, sigma0, T0, F0), (K, m0) = self.before, (self.solid.K, self.solid.m0)
        sigma, change = sigma0 + K * np.log(F / F0), F - F0
        fan = change > 0.0
        c = np.where(fan, 2.0 * np.sqrt(K / m0) / (np.sqrt(F) + np.sqrt(F0)), self._shock(F))
        given = (sigma0 - K) * change + K * F * np.log(F / F0)
        heat = np.where(fan, given, 0.5 * (sigma + sigma0) * change)
        return SolidState(u0 - c * change, sigma, T0 + heat / (self.solid.alpha * m0), F)

    def _shock(self, F: Any) -> Any:
        """Return the speed over X of a shock to F [m/s]."""
        K, m0, F0 = self.solid.K, self.solid.m0, self.before.F
        ratio = np.where(F == F0, 1.0, F / F0 - 1.0)
        slope = np.where(F == F0, 1.0, np.log1p(ratio) / ratio)
        return np.sqrt(K * slope / (m0 * F0))

    def speeds(self, p: float) -> tuple[float, float]:
        """Speeds [m/s], over X, of the front and of the back of the wave; a shock has one."""
        F, F0 = self.strain(p), self.before.F
        if F < F0:
            return float(self._shock(F)), float(self._shock(F))
        return tuple(float(np.sqrt(self.solid.K / (self.solid.m0 * f))) for f in (F0, F))

    def at(self, p: float, X: Array, t: float) -> SolidState:
        """The states at material points that far [m] from the wave at t = 0."""
        if t <= 0:
            return SolidState(*(value + 0.0 * X for value in self.before))
        speed, (front, back) = X / t, self.speeds(p)
        fan = self.solid.K / (self.solid.m0 * np.maximum(speed, back) ** 2)
        which = [speed > front, speed > back]
        return self._state(np.select(which, [self.before.F, fan], self.strain(p)))


def pressure_between(left: Callable[[float], Any], right: Callable[[float], Any]) -> float:
    """p [Pa] at which the velocity of the left side, which falls with p, is that of the right one,
    to round-off. InputError where the two part.
    """
    from scipy.optimize import brentq

    def apart(p: float) -> float:
        """By how much [m/s] the left side is faster where both have the pressure p."""
        return float(left(p) - right(p))

    high = 1.0
    while apart(high) > 0.0:
        high *= 2.0
    low = high
    while apart(low) < 0.0:
        low *= 0.5
        if low < 1e-12 * high:
            raise InputError("gas and solid part: expected velocities or pressures nearer by")
    return brentq(apart, low, high, xtol=1e-300, rtol=1e-15) if low < high else low
