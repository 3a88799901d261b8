"""Conjugate heat transfer with an exact solution: a warm solid and a gas cool between cold ends.

Solid | gas at rest under the pressure p0 and of the temperature T0, which the clamped left end of
the solid and the wall at the right keep. A small disturbance decays in the slowest thermal mode of
both together: heat is conducted through the interface, the gas expands where it is warm, and pushes
the solid a little. The linear equations have the exact solution

    (rho, u, T)' = Re sum_j c_j (rho_j, u_j, T_j) exp(k_j x + s t)

in the gas, likewise (u, sigma, T)' in the solid, with four wave numbers k_j(s) in either layer: in
the gas the roots of

    (rho0 s - mu' z - R T0 rho0 z/s) (rho0 cv s - kappa z) = R rho0 p0 z,     z = k^2,

in the solid k = s/c, c^2 = K/m0, and k^2 = alpha m0 s/kappa_e, each with both signs. s is where the
eight conditions at the ends and at the interface have a solution. What remains of the error on fine
grids is of second order in the amplitude.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fsipetsc import Fluid, FluidLayer, InputError, Problem, Solid, SolidLayer, Wall, clamped
from fsipetsc.cases.common import Opt, gas_of, materials, solid_of
from fsipetsc.checks import Array, Fields

NAME = "heat"
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


@dataclass(frozen=True)
class Mode:
    """The slowest thermal mode of the two layers; InputError where there is none."""

    gas: Fluid
    solid: Solid

    def gas_waves(self, s: complex) -> tuple[Array, Array]:
        """(k, (rho, u, T)) of the four waves in the gas, shapes (4,) and (3, 4)."""
        gas, mu = self.gas, 4 / 3 * self.gas.mu
        # (a - b z)(c - d z) = e z
        a, b, c, d = RHO0 * s, mu + R * T0 * RHO0 / s, RHO0 * gas.cv * s, gas.kappa
        z = np.roots([b * d, -(a * d + b * c + R * RHO0 * P0), a * c]).astype(complex)
        k = np.concatenate([np.sqrt(z), -np.sqrt(z)])
        # of unit temperature: the sound of a slow mode hardly moves, and u/T of the other is small
        T = np.ones(4, complex)
        u = -(c - d * k * k) / (P0 * k)
        return k, np.array([-RHO0 * k * u / s, u, T])

    def solid_waves(self, s: complex) -> tuple[Array, Array]:
        """(k, (u, sigma, T)) of the four waves in the solid, shapes (4,) and (3, 4)."""
        solid, heat = self.solid, self.solid.alpha * self.solid.m0
        elastic, thermal = s * np.sqrt(solid.m0 / solid.K), np.sqrt(heat * s / solid.kappa_e + 0j)
        k = np.array([elastic, -elastic, thermal, -thermal])
        u = np.array([1.0, 1.0, 0.0, 0.0])
        T = np.array([-P0 * w / (heat * s - solid.kappa_e * w * w) for w in k[:2]] + [1.0, 1.0])
        return k, np.array([u, solid.K * k * u / s, T])

    def conditions(self, s: complex) -> Array:
        """What the ends and the interface ask of the eight amplitudes, (8, 8), gas first."""
        (k, (rho, u, T)), (q, (v, sigma, Ts)) = self.gas_waves(s), self.solid_waves(s)
        net = R * (RHO0 * T + T0 * rho) - 4 / 3 * self.gas.mu * k * u
        nothing, wall, left = np.zeros(4), np.exp(k * X[2]), np.exp(q * X[0])
        rows = [
            [nothing, v * left],
            [nothing, Ts * left],
            [u * wall, nothing],
            [T * wall, nothing],
            [u, -v],
            [net, sigma],
            [T, -Ts],
            [self.gas.kappa * k * T, -self.solid.kappa_e * q * Ts],
        ]
        return np.array([np.concatenate(row) for row in rows])

    def scaled(self, s: complex) -> Array:
        """The same with columns and rows of size 1: so its singular values say something."""
        matrix = self.conditions(s)
        matrix = matrix / np.abs(matrix).max(axis=0)
        return matrix / np.abs(matrix).max(axis=1)[:, None]

    @cached_property
    def rate(self) -> float:
        """s [1/s], real and negative: the one nearest to 0 with a solution.

        The determinant has one phase along the real axis, and changes its sign there.
        """
        from scipy.optimize import brentq

        gas, solid = self.gas, self.solid
        spread = gas.kappa / (RHO0 * GAMMA * gas.cv), solid.kappa_e / (solid.alpha * solid.m0)
        sizes = np.geomspace(1.2 * min(spread), 20.0 * max(spread), 400)
        determinant = lambda size: np.linalg.det(self.scaled(-size))  # noqa: E731
        with np.errstate(over="ignore", invalid="ignore"):
            values = [determinant(size) for size in sizes]
            for low, high, a, b in zip(sizes, sizes[1:], values, values[1:]):
                if (b / a).real < 0.0:
                    of = lambda x, a=a: float((determinant(x) / a).real)  # noqa: E731
                    found = brentq(of, low, high, xtol=1e-15, rtol=1e-15)
                    if np.linalg.svd(self.scaled(-found), compute_uv=False)[-1] < 1e-9:
                        return -found
        raise InputError("no thermal mode is found: expected conductivities closer to each other")

    @cached_property
    def amplitudes(self) -> Array:
        """Of the eight waves, for a largest disturbance of T of 1."""
        columns = np.abs(self.conditions(self.rate)).max(axis=0)
        raw = np.linalg.svd(self.scaled(self.rate))[2][-1].conj() / columns
        (k, gas), (q, solid) = self.gas_waves(self.rate), self.solid_waves(self.rate)
        x = np.linspace(0.0, 1.0, 201)
        warm = np.exp(np.outer(x, k)) @ (raw[:4] * gas[2])
        T = np.concatenate([warm, np.exp(np.outer(x - 1, q)) @ (raw[4:] * solid[2])])
        return raw / T[np.argmax(np.abs(T))]

    def fields(self, kind: str, x: Array, t: float) -> Array:
        """Disturbance of (rho, u, T) in the gas or (u, sigma, T) in the solid, shape (3, n)."""
        s, fluid = self.rate, kind == "gas"
        k, waves = self.gas_waves(s) if fluid else self.solid_waves(s)
        amplitudes = self.amplitudes[:4] if fluid else self.amplitudes[4:]
        return np.real((waves * amplitudes) @ np.exp(np.outer(k, x))) * np.exp(s * t)


def build(opt: Opt) -> Problem:
    """The solid clamped at X = -1, the wall at x = 1, both of the temperature T0."""
    gas, solid = gas_of(opt, GAMMA, R), solid_of(opt)
    mode = Mode(gas, solid)

    def in_gas(x: Array, t: float) -> Fields:
        rho, u, T = AMPLITUDE * mode.fields("gas", x, t)
        return [RHO0 + rho, u, T0 + T]

    def in_solid(X: Array, t: float) -> Fields:
        u, sigma, T = AMPLITUDE * mode.fields("solid", X, t)
        return [u, sigma - P0, T0 + T, X + u / mode.rate]

    layers = (
        SolidLayer("solid", solid, X[:2], lambda X: in_solid(X, 0.0), exact=in_solid),
        FluidLayer("gas", gas, X[1:], lambda x: in_gas(x, 0.0), exact=in_gas),
    )
    note = f"the mode decays as exp({mode.rate:.10g} t), as the linear equations have it"
    return Problem(layers, clamped(T=T0), Wall(X[2], T=T0), notes=(note,), units="none")
