"""Compressible Navier–Stokes equations on a grid that moves with the velocity w, (3.2) and (4.20) for J = 1.

    (J rho)_t   + (rho (u-w))_X                                      = 0
    (J rho u)_t + (rho u (u-w) + p - tau)_X                          = J rho force,      tau = mu'/J u_X,  mu' = 4/3 mu
    (J e)_t     + (e (u-w) + u (p - tau) - kappa/J T_X)_X            = J rho u force

with p = (gamma-1)(e - rho u^2/2) = rho R T (R stands for R/M). X is the coordinate of the grid at rest, and J = x_X. In the
rigid frame J = 1 and w = s(t), the velocity of the fluid's own interface point. On a stretched grid J is uniform and w goes
linearly from one end to the other, so that J_t = w_X holds for the operator as it does for the derivative: a free stream
stays one to round-off. The viscous and heat fluxes stand inside the outer derivative, so that D is applied twice to u and T.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numba import njit

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, Array, number, numbers
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas, in_python
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.vectors import fma, numbers_from
from fsipetsc.physics.constant_transport import constant_transport
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.material_law import Law, check_law, formulas_of, numbers_of
from fsipetsc.physics.perfect_gas import perfect_gas


@dataclass(frozen=True)
class Fluid:
    """A gas; perfect, unless another law is given.

    mu: shear viscosity [Pa s]; kappa: heat conductivity [W/(m K)]; gamma: ratio of the specific heats, above 1;
    R: gas constant over molar mass [J/(kg K)]. law: the equation of state, as ``perfect_gas``; transport: what mu and kappa
    are multiplied with, as ``constant_transport`` or sutherland(…); force: body force per mass [m/s2]. InputError for what is
    no number or out of range.
    """

    mu: float
    kappa: float
    gamma: float
    R: float
    law: Formulas | Law = perfect_gas
    transport: Formulas | Law = constant_transport
    force: float = 0.0

    def __post_init__(self) -> None:
        numbers(self, "Fluid", {"mu": NONNEGATIVE, "kappa": NONNEGATIVE, "gamma": "above 1", "R": POSITIVE, "force": ANY})
        check_law(self.law, "Fluid: law", "bulk_modulus", "what gas_law(…) returns")
        check_law(self.transport, "Fluid: transport", "relative", "what transport_law(…) returns")

    @classmethod
    def with_prandtl(cls, mu: float, prandtl: float, gamma: float, R: float, **more: Any) -> Fluid:
        """A perfect gas with kappa(T) = cp mu(T) / Pr, Pr the Prandtl number; more: transport and force, as above.

        InputError, too, where the transport law does not multiply mu and kappa with the same, or the gas is another one.
        """
        of_mu = cls(mu, 0.0, gamma, R, **more)
        if formulas_of(of_mu.law) is not perfect_gas:
            raise InputError("Fluid.with_prandtl: law is given: expected none, because cp would not be a number")
        factors = np.array([of_mu.relative(T) for T in (100.0, 300.0, 3000.0)])
        if not np.allclose(factors[:, 0], factors[:, 1], rtol=1e-12, atol=0.0):
            raise InputError("Fluid.with_prandtl: transport has a law of its own for kappa: expected the same as for mu")
        cp = of_mu.cv * of_mu.gamma
        return replace(of_mu, kappa=cp * of_mu.mu / number(prandtl, "Fluid.with_prandtl: prandtl", POSITIVE))

    @property
    def cv(self) -> float:
        """Specific heat at constant volume [J/(kg K)]."""
        return self.R / (self.gamma - 1)

    @property
    def gas_numbers(self) -> tuple[float, ...]:
        """Those of the equation of state, as in a record."""
        return numbers_of(self.law)

    @property
    def transport_numbers(self) -> tuple[float, ...]:
        """Those of the transport law."""
        return numbers_of(self.transport)

    def sound_speed(self, T: float | Array, rho: float | Array = 1.0) -> float | Array:
        """Speed of sound [m/s] at temperature T [K] and density rho [kg/m3], which matters where the gas is not perfect."""
        return np.sqrt(self._of_law("sound_speed_squared", rho, T))

    def internal_energy(self, rho: float | Array, T: float | Array) -> float | Array:
        """Internal energy per mass [J/kg] at density rho [kg/m3] and temperature T [K]."""
        return self._of_law("energy", rho, T)

    def relative(self, T: float | Array) -> tuple[Any, Any]:
        """(mu(T)/mu, kappa(T)/kappa), of the transport law."""
        transport = formulas_of(self.transport)
        return in_python(transport.relative)(in_python(transport.constants)(self), T)

    def conserved(self, rho: Array, u: Array, T: Array) -> Array:
        """(rho, rho u, e) of shape (..., 3) from density, velocity and temperature."""
        return np.stack([rho, rho * u, rho * (self._of_law("energy", rho, T) + 0.5 * u * u)], axis=-1)

    def primitive(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """rho, u, T, p from the conserved variables q of shape (..., 3)."""
        rho = q[..., 0]
        u = q[..., 1] / rho
        T = self._of_law("temperature", rho, q[..., 2] / rho - 0.5 * u * u)
        return rho, u, T, self._of_law("pressure", rho, T)

    def _of_law(self, name: str, *values: Any) -> Any:
        """A formula of the law, by numpy."""
        law = formulas_of(self.law)
        return in_python(getattr(law, name))(in_python(law.constants)(self), *values)


@njit(**FORMULA)
def constants(law, layer):
    """(those of the gas law, 1/J, velocity of the grid at point 0, the next one's less that, those of transport, force)."""
    return law.gas.constants(layer), 1.0 / layer.J, layer.s, layer.spread, law.transport.constants(layer), layer.force


@njit(**FORMULA)
def velocity_and_temperature(law, constants, q):
    """(u, T) from J (rho, rho u, e)."""
    rho, m, e = q
    r = 1.0 / rho
    u = m * r
    return u, law.gas.temperature_in_loops(constants[0], rho * constants[1], e * r - 0.5 * u * u)


@njit(**OPTIONS)
def prescribe(layer, s, v, begin, end):
    """Where a boundary wants the gradients to see other values of u and T at its ghost point, these."""
    for side in range(2):
        ghost = layer.lo if side == 0 else layer.hi
        if layer.end_apart[side] != 0 and begin <= ghost < end:
            s[U64(v[0] + ghost)], s[U64(v[1] + ghost)] = layer.end_gradient[side, 0], layer.end_gradient[side, 1]


@njit(**FORMULA)
def gradients(law, layer, q, v):
    """mu'/J u_X and kappa/J T_X, with the mu and kappa of the material: what depends on T is a factor in the flux."""
    spacing = layer.J * layer.h
    return v, (layer.mu / spacing, layer.kappa / spacing)


@njit(**FORMULA)
def flux(law, constants, i, q, v, gradients):
    """(rho (u-w), rho u (u-w) + p - tau, e (u-w) + u (p - tau) - kappa/J T_X)."""
    (rho, m, e), (u, T) = q, v
    gas, per_J, s, spread, transport, _ = constants
    of_mu, of_kappa = law.transport.relative(transport, T)
    tau, conduction = of_mu * gradients[0], of_kappa * gradients[1]
    relative, pressing = (u - fma(spread, numbers_from(i), s)) * per_J, law.gas.pressure(gas, rho * per_J, T) - tau
    return rho * relative, fma(m, relative, pressing), fma(e, relative, fma(u, pressing, -1.0 * conduction))


@njit(**FORMULA)
def minus_divergence(law, constants, q, f, derivatives):
    """-f_X; the sign is in the factor."""
    return derivatives


@njit(**FORMULA)
def pulled_momentum(law, constants, q, f, derivatives):
    """-f_X + rho force."""
    return (fma(constants[5], q[0], derivatives[0]),)


@njit(**FORMULA)
def pulled_energy(law, constants, q, f, derivatives):
    """-f_X + rho u force."""
    return (fma(constants[5], q[1], derivatives[0]),)


def conservation_law(unknown: int, rate: Any = minus_divergence) -> Formulas:
    """q_t = -f_X of one unknown, or what a rate makes of it, for the sweep."""

    @njit(**FORMULA)
    def second(law, layer, q, f):
        return (f[unknown],), (-1.0 / layer.h,)

    return Formulas(unknowns=(unknown,), second=second, rate=rate)


#: the three, each in a loop of its own: their stencils together would not stay in registers
CONSERVATION_LAWS = tuple(conservation_law(unknown) for unknown in range(3))
#: with a body force; apart, because a force of zero would cost a load and an operation of each point
BALANCES = CONSERVATION_LAWS[0], conservation_law(1, pulled_momentum), conservation_law(2, pulled_energy)


def navier_stokes(gas: Formulas, transport: Formulas, undivided: tuple[Formulas, ...] = (), pulled: bool = False) -> Formulas:
    """The equations for a gas law and a transport law, as fsipetsc.scheme.sweep takes them.

    undivided: further terms; pulled: by a body force.
    """
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
        rates=BALANCES if pulled else CONSERVATION_LAWS,
        undivided=undivided,
    )
