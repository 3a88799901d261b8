"""The Riemann problem of a perfect gas and an elastic solid: what follows when both meet with a jump. Exact.

The gas stands on the left, the solid on the right; nothing is viscous or conducts heat. Both sides have one velocity u and one
pressure p at the interface, their temperatures differ. A wave, shock or fan, goes into either side.

Gas: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics, 3rd ed., Springer 2009, Sec. 4.2 to 4.5.

Solid, with F = x_X, P = sigma - p the stress, E = alpha m0 T:

    F_t = u_X,    m0 u_t = P_X,    (m0 u^2/2 + E)_t = (P u)_X,    sigma - K ln F = const,    p = gruneisen E / F

are the equations of fsipetsc.materials.line_solid in conservation form: x_t = u and sigma_t = K/F u_X make the fourth exact,
across shocks, too. The wave speed c over X, m0 c^2 = (K + p - gruneisen P) / F, falls with F: compression makes a shock,
expansion a fan. Across a shock of speed s into the state 0,

    u - u0 = -s (F - F0),    m0 s^2 (F - F0) = P - P0,    E - E0 = (P + P0)/2 (F - F0),

the last one from the energy; within a fan E_F = P, which has the solution

    E F^G = E0 F0^G + [F^(G+1)/(G+1) (K ln F + sigma0 - K ln F0 - K/(G+1))] from F0 to F,    G = gruneisen,

and u + int c dF is what it was before. One equation for F at the interface remains: that both sides have one velocity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid

#: points and weights of Gauss's quadrature over (-1, 1): int c dF is exact to round-off, unless F changes a hundredfold
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(32)
#: part of the jump that is left where a shock's structure is cut off
_TAIL = 1e-6
#: bisections of an interval that leave nothing of it
_HALVINGS = 64


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


def behind_shock(gas: Fluid, ahead: GasState, mach: float) -> tuple[GasState, float]:
    """(the gas behind a shock that goes to the right at a Mach number above 1, the speed of the shock [m/s])."""
    g, c = gas.gamma, _sound(gas, ahead)
    s = ahead.u + mach * c
    rho = ahead.rho * (g + 1) * mach**2 / ((g - 1) * mach**2 + 2)
    p = ahead.p * (1 + 2 * g / (g + 1) * (mach**2 - 1))
    return GasState(rho, s - (s - ahead.u) * ahead.rho / rho, p), s


def shock_structure(gas: Fluid, ahead: GasState, mach: float, width: float, w: float = 0.0) -> Callable[[np.ndarray], GasState]:
    """x [m] -> the gas in and around a shock that goes to the right, spread as dissipation of first order spreads it.

    Its wave is width/2 (|u - w| + c) U_x = f(U) - s U - (f(U) - s U ahead), U = (rho, rho u, e): what Lax's and Friedrichs'
    scheme makes of it on a grid of spacing ``width`` [m] and velocity w [m/s]. It has the mass of a jump at x = 0. What begins
    with a jump instead sends waves after the shock until the shock has this structure.
    """
    from scipy.integrate import solve_ivp

    behind, s = behind_shock(gas, ahead, mach)

    def flux(U: np.ndarray) -> tuple[np.ndarray, float]:
        u = U[1] / U[0]
        p = (gas.gamma - 1) * (U[2] - 0.5 * U[1] * u)
        return np.array([U[1], U[1] * u + p, u * (U[2] + p)]) - s * U, abs(u - w) + _sound(gas, GasState(U[0], u, p))

    low, high = _conserved(gas, ahead), _conserved(gas, behind)
    leaving, speed = flux(high)[0], _sound(gas, behind)
    fast = np.array([1.0, behind.u + speed, (high[2] + behind.p) / behind.rho + behind.u * speed])
    rates = behind.u + speed - s, s - ahead.u - _sound(gas, ahead)

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        change, rate = flux(y[:3])
        return np.append(change - leaving, 0.5 * width * rate)

    start = np.append(high - _TAIL * behind.rho * fast, 0.0)
    length = -np.log(_TAIL) * sum(1 / rate for rate in rates)
    solved = solve_ivp(slope, (0.0, length), start, rtol=1e-9, atol=1e-12, max_step=length / 400)
    U, x = solved.y[:3], solved.y[3]
    excess = np.sum(np.diff(x) * (0.5 * (U[0, 1:] + U[0, :-1]) - low[0]))
    x = x - excess / (high[0] - low[0])

    def at(place: np.ndarray) -> GasState:
        rho, m, e = (np.interp(place, x, row, left=b, right=a) for row, a, b in zip(U, low, high, strict=True))
        return GasState(rho, m / rho, (gas.gamma - 1) * (e - 0.5 * m * m / rho))

    return at


def _conserved(gas: Fluid, state: GasState) -> np.ndarray:
    """(rho, rho u, e)."""
    return np.array([state.rho, state.rho * state.u, state.p / (gas.gamma - 1) + 0.5 * state.rho * state.u**2])


def _sound(gas: Fluid, state: GasState) -> float:
    return np.sqrt(gas.gamma * state.p / state.rho)


@dataclass(frozen=True)
class GasWave:
    """What goes into the gas before is at rest or moves, to the left, where the interface has some pressure."""

    gas: Fluid
    before: GasState

    def velocity(self, p: Any) -> Any:
        """Velocity [m/s] behind the wave where the pressure there is p [Pa]."""
        rho, u, p0 = self.before
        g = self.gas.gamma
        shock = (p - p0) * np.sqrt(2 / rho / ((g + 1) * p + (g - 1) * p0))
        fan = 2 * _sound(self.gas, self.before) / (g - 1) * ((p / p0) ** ((g - 1) / (2 * g)) - 1)
        return u - np.where(p > p0, shock, fan)

    def behind(self, p: float) -> GasState:
        """The state behind the wave."""
        rho, _, p0 = self.before
        g, ratio = self.gas.gamma, p / p0
        compressed = ratio ** (1 / g) if p <= p0 else ((g + 1) * ratio + g - 1) / ((g - 1) * ratio + g + 1)
        return GasState(rho * compressed, float(self.velocity(p)), p)

    def speeds(self, p: float) -> tuple[float, float]:
        """Speeds [m/s] of the front and of the back of the wave; a shock has one."""
        behind = self.behind(p)
        if p <= self.before.p:
            return self.before.u - _sound(self.gas, self.before), behind.u - _sound(self.gas, behind)
        rho, u, _ = self.before
        s = (behind.rho * behind.u - rho * u) / (behind.rho - rho)
        return s, s

    def at(self, p: float, speed: np.ndarray) -> GasState:
        """The states at x = speed t."""
        g, before, behind = self.gas.gamma, self.before, self.behind(p)
        front, back = self.speeds(p)
        c0 = _sound(self.gas, before)
        c = np.clip((2 * c0 + (g - 1) * (before.u - speed)) / (g + 1), 0.0, None)
        fan = before.rho * (c / c0) ** (2 / (g - 1)), speed + c, before.p * (c / c0) ** (2 * g / (g - 1))
        which = [speed < front, speed < back]
        return GasState(*(np.select(which, [a, b], d) for a, b, d in zip(before, fan, behind, strict=True)))


@dataclass(frozen=True)
class SolidWave:
    """What goes into the solid, to the right, where the interface has some strain."""

    solid: Solid
    before: SolidState

    @property
    def least(self) -> float:
        """F that no shock reaches."""
        return self.before.F * self.solid.gruneisen / (self.solid.gruneisen + 2)

    def sigma(self, F: Any) -> Any:
        """sigma [Pa], which follows from F alone."""
        return self.before.sigma + self.solid.K * np.log(F / self.before.F)

    def heat(self, F: Any) -> Any:
        """alpha m0 T [J/m3] behind a wave to F."""
        G, K, F0, E0 = self.solid.gruneisen, self.solid.K, self.before.F, self._heat
        P0, change = self.before.sigma - G * E0 / F0, F - F0
        shocked = (E0 + 0.5 * change * (P0 + self.sigma(F))) / (1 + 0.5 * G * change / F)
        part = lambda F: F / (G + 1) * (self.sigma(F) - K / (G + 1))  # noqa: E731
        return np.where(F < F0, shocked, part(F) + (E0 - part(F0)) * (F0 / F) ** G)

    @property
    def _heat(self) -> float:
        return self.solid.alpha * self.solid.m0 * self.before.T

    def stress(self, F: Any) -> Any:
        """P = sigma - p [Pa] behind a wave to F."""
        return self.sigma(F) - self.solid.gruneisen * self.heat(F) / F

    def characteristic(self, F: Any) -> Any:
        """c [m/s] within a fan; 0 where such a solid would not be stable."""
        p = self.solid.gruneisen * self.heat(F) / F
        modulus = self.solid.K + p - self.solid.gruneisen * (self.sigma(F) - p)
        return np.sqrt(np.maximum(modulus, 0.0) / (self.solid.m0 * F))

    def velocity(self, F: Any) -> Any:
        """u [m/s] behind a wave to F."""
        F0, change = self.before.F, np.asarray(F - self.before.F, dtype=float)
        points = F0 + 0.5 * change[..., None] * (1 + _NODES)
        fan = 0.5 * change * (self.characteristic(np.maximum(points, F0)) @ _WEIGHTS)
        # s (F - F0), the speed from the jumps
        shock = -np.sqrt(np.maximum((self.stress(F) - self.before_stress) * change, 0.0) / self.solid.m0)
        return self.before.u - np.where(F < F0, shock, fan)

    @property
    def before_stress(self) -> float:
        """P = sigma - p [Pa] before the wave."""
        return self.before.sigma - self.solid.gruneisen * self._heat / self.before.F

    def speeds(self, F: float) -> tuple[float, float]:
        """Speeds [m/s], over X, of the front and of the back of the wave; a shock has one."""
        if F >= self.before.F:
            return float(self.characteristic(self.before.F)), float(self.characteristic(F))
        s = float(np.sqrt((self.stress(F) - self.before_stress) / (F - self.before.F) / self.solid.m0))
        return s, s

    def at(self, F: float, speed: np.ndarray) -> SolidState:
        """The states at X = speed t."""
        front, back = self.speeds(F)
        strain = np.select([speed > front, speed > back], [self.before.F, self._in_fan(F, speed)], F)
        heat, u = self.heat(strain), self.velocity(strain)
        return SolidState(u, self.sigma(strain), heat / (self.solid.alpha * self.solid.m0), strain)

    def _in_fan(self, F: float, speed: np.ndarray) -> np.ndarray:
        """F where c is the speed: by bisection, for c falls as F rises."""
        low, high = np.full(speed.shape, self.before.F), np.full(speed.shape, max(F, self.before.F))
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            faster = self.characteristic(middle) > speed
            low, high = np.where(faster, middle, low), np.where(faster, high, middle)
        return 0.5 * (low + high)


@dataclass(frozen=True)
class Riemann:
    """Gas | solid, from t = 0 on. InputError where the materials are others, or nothing would be left at the interface."""

    gas: Fluid
    solid: Solid
    left: GasState
    right: SolidState

    def __post_init__(self) -> None:
        if self.gas.law is not None or self.solid.pressing is not None:
            raise InputError("an exact solution is known of a perfect gas and of a solid with Grüneisen's pressure or none")
        if not min(self.left.rho, self.left.p, self.right.T, self.right.F) > 0:
            raise InputError(f"{self.left}, {self.right}: expected rho, p, T and F above 0")

    @property
    def gas_wave(self) -> GasWave:
        """What goes to the left."""
        return GasWave(self.gas, self.left)

    @property
    def solid_wave(self) -> SolidWave:
        """What goes to the right."""
        return SolidWave(self.solid, self.right)

    @cached_property
    def F(self) -> float:
        """x_X of the solid at the interface, to round-off."""
        wave = self.solid_wave

        def apart(F: float) -> float:
            """How much faster the gas would be; it falls as F does, until the gas lets go of the solid."""
            p = -float(wave.stress(F))
            return float(self.gas_wave.velocity(max(p, 0.0)) - wave.velocity(F))

        low = high = self.right.F
        while apart(low) > 0:
            low = 0.5 * (low + wave.least)
        while apart(high) < 0:
            if wave.stress(high) >= 0 or not wave.characteristic(high) > 0:
                raise InputError("gas and solid part, or the solid is torn: expected velocities or pressures that differ less")
            high *= 1.25
        return _root(apart, low, high)

    @property
    def p(self) -> float:
        """Pressure [Pa] at the interface."""
        return -float(self.solid_wave.stress(self.F))

    @property
    def u(self) -> float:
        """Velocity [m/s] of the interface."""
        return float(self.solid_wave.velocity(self.F))

    def in_gas(self, x: np.ndarray, t: float) -> GasState:
        """The gas at a distance x [m] from where the interface was at t = 0."""
        if t <= 0:
            return GasState(*(np.full(np.shape(x), value) for value in self.left))
        return self.gas_wave.at(self.p, np.asarray(x) / t)

    def in_solid(self, X: np.ndarray, t: float) -> tuple[SolidState, np.ndarray]:
        """(the solid at the material points X [m] behind the interface, where they are beside its place at t = 0 [m])."""
        if t <= 0:
            state = SolidState(*(np.full(np.shape(X), value) for value in self.right))
        else:
            state = self.solid_wave.at(self.F, np.asarray(X) / t)
        return state, state.u * t + state.F * X  # x/t = u + F X/t, as all depends on X/t


def _root(function: Any, low: float, high: float) -> float:
    """Where a function that rises is zero, to round-off."""
    from scipy.optimize import brentq

    if low == high:
        return low
    return brentq(function, low, high, xtol=1e-300, rtol=4 * np.finfo(float).eps)
