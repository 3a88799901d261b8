"""Compressible Navier–Stokes equations in the rigid frame that moves with the interface, (3.2) and (4.20).

    rho_t     + (rho (u-s))_X                                        = 0
    (rho u)_t + (rho u (u-s) + p - mu' u_X)_X                        = 0,      mu' = 4/3 mu
    e_t       + (e (u-s) + u (p - mu' u_X) - kappa T_X)_X            = 0

with p = (gamma-1)(e - rho u^2/2) = rho R T (R stands for R/M) and s(t) the velocity of the fluid's own interface
point. The viscous and heat fluxes stand inside the outer derivative, so that D is applied twice to u and T.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from fsipetsc.checks import NONNEGATIVE, POSITIVE, formulas, numbers
from fsipetsc.operators.formulas import Formulas, in_python
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.vectors import fma
from fsipetsc.physics.constant_transport import constant_transport
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.perfect_gas import perfect_gas


@dataclass(frozen=True)
class Fluid:
    """A gas; perfect, unless another law is given.

    mu: shear viscosity [Pa s]; kappa: heat conductivity [W/(m K)]; gamma: ratio of the specific heats, above 1;
    R: gas constant over molar mass [J/(kg K)]. law: formulas of the equation of state, as ``perfect_gas``; transport: of what
    mu and kappa are multiplied with, as ``constant_transport``. InputError for what is no number or out of range.
    """

    mu: float
    kappa: float
    gamma: float
    R: float
    law: Formulas = perfect_gas
    transport: Formulas = constant_transport

    def __post_init__(self) -> None:
        numbers(self, "Fluid", {"mu": NONNEGATIVE, "kappa": NONNEGATIVE, "gamma": "above 1", "R": POSITIVE})
        formulas(self.law, "Fluid: law", "bulk_modulus", "what gas_law(…) returns")
        formulas(self.transport, "Fluid: transport", "relative", "what transport_law(…) returns")

    @property
    def cv(self) -> float:
        """Specific heat at constant volume [J/(kg K)]."""
        return self.R / (self.gamma - 1)

    def sound_speed(self, T: float | np.ndarray, rho: float | np.ndarray = 1.0) -> float | np.ndarray:
        """Speed of sound [m/s] at temperature T [K] and density rho [kg/m3], which matters where the gas is not perfect."""
        return np.sqrt(self._of_law("sound_speed_squared", rho, T))

    def conserved(self, rho: np.ndarray, u: np.ndarray, T: np.ndarray) -> np.ndarray:
        """(rho, rho u, e) of shape (..., 3) from density, velocity and temperature."""
        return np.stack([rho, rho * u, rho * (self._of_law("energy", rho, T) + 0.5 * u * u)], axis=-1)

    def primitive(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """rho, u, T, p from the conserved variables q of shape (..., 3)."""
        rho = q[..., 0]
        u = q[..., 1] / rho
        T = self._of_law("temperature", rho, q[..., 2] / rho - 0.5 * u * u)
        return rho, u, T, self._of_law("pressure", rho, T)

    def _of_law(self, name: str, *values: np.ndarray) -> np.ndarray:
        """A formula of the law, by numpy."""
        return in_python(getattr(self.law, name))(in_python(self.law.constants)(self), *values)


@njit(**FORMULA)
def constants(law, layer):
    """(those of the gas law, velocity s of the frame)."""
    return law.gas.constants(layer), layer.s


@njit(**FORMULA)
def velocity_and_temperature(law, constants, q):
    """(u, T) from (rho, rho u, e)."""
    rho, m, e = q
    r = 1.0 / rho
    u = m * r
    return u, law.gas.temperature_in_loops(constants[0], rho, e * r - 0.5 * u * u)


@njit(**OPTIONS)
def prescribe(layer, s, v, begin, end):
    """Where a boundary wants the gradients to see other values of u and T at its ghost point, these."""
    for side in range(2):
        ghost = layer.lo if side == 0 else layer.hi
        if layer.end_apart[side] != 0 and begin <= ghost < end:
            s[U64(v[0] + ghost)], s[U64(v[1] + ghost)] = layer.end_gradient[side]


@njit(**FORMULA)
def gradients(law, layer, q, v):
    """mu' u_X and kappa T_X, with the mu and kappa of the material: what depends on T is a factor in the flux."""
    return v, (layer.mu / layer.h, layer.kappa / layer.h)


@njit(**FORMULA)
def flux(law, constants, q, v, gradients):
    """(rho (u-s), rho u (u-s) + p - tau, e (u-s) + u (p - tau) - kappa T_X)."""
    (rho, m, e), (u, T) = q, v
    gas, s = constants
    of_mu, of_kappa = law.transport.relative(T)
    tau, conduction = of_mu * gradients[0], of_kappa * gradients[1]
    relative, pressing = u - s, law.gas.pressure(gas, rho, T) - tau
    return rho * relative, fma(m, relative, pressing), fma(e, relative, fma(u, pressing, -1.0 * conduction))


@njit(**FORMULA)
def minus_divergence(law, constants, q, f, derivatives):
    """-f_X; the sign is in the factor."""
    return derivatives


def conservation_law(unknown: int) -> Formulas:
    """q_t = -f_X of one unknown, for the sweep."""

    @njit(**FORMULA)
    def second(law, layer, q, f):
        return (f[unknown],), (-1.0 / layer.h,)

    return Formulas(unknowns=(unknown,), second=second, rate=minus_divergence)


#: the three, each in a loop of its own: their stencils together would not stay in registers
CONSERVATION_LAWS = tuple(conservation_law(unknown) for unknown in range(3))


def navier_stokes(gas: Formulas, transport: Formulas, undivided: tuple[Formulas, ...] = ()) -> Formulas:
    """The equations for a gas law and a transport law, as fsipetsc.scheme.sweep takes them; undivided: further terms."""
    return Formulas(
        kind=FLUID,
        gas=gas,
        transport=transport,
        unknowns=(0, 1, 2),
        prepared=(0, 1),
        fluxes=(0, 1, 2),
        constants=constants,
        prepare=velocity_and_temperature,
        prescribe=prescribe,
        first=gradients,
        flux=flux,
        rates=CONSERVATION_LAWS,
        undivided=undivided,
    )
