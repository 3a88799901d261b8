"""What a case says of a gas."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, described, number, numbers
from fsipetsc.equations.gas import Gas
from fsipetsc.errors import InputError
from fsipetsc.materials import own
from fsipetsc.materials.stiffened_gas import PerfectGas
from fsipetsc.materials.sutherland import ConstantTransport


@dataclass(frozen=True)
class Fluid:
    """A gas, which obeys the compressible Navier–Stokes equations; perfect without another law.

    Args:
        mu: shear viscosity [Pa s].
        kappa: heat conductivity [W/(m K)].
        gamma: ratio of the specific heats, above 1.
        R: gas constant over molar mass [J/(kg K)].
        law: None for the perfect gas of gamma and R; or what `stiffened_gas` or `gas_law` returns.
        transport: None for constants; or what `sutherland` or `transport_law` returns.
        force: body force per mass [m/s2], a number in one dimension, else d numbers.
    """

    mu: float
    kappa: float
    gamma: float
    R: float
    law: Any = None
    transport: Any = None
    force: float | tuple[float, ...] = 0.0
    kind = "fluid"

    def __post_init__(self) -> None:
        ranges = {"mu": NONNEGATIVE, "kappa": NONNEGATIVE, "gamma": "above 1", "R": POSITIVE}
        numbers(self, "Fluid", ranges)
        object.__setattr__(self, "force", force_in(self.force, 0, "Fluid"))
        self.equations(len(self.force))

    @property
    def gas_law(self) -> Any:
        law = PerfectGas(self.gamma, self.R) if self.law is None else self.law
        return own.checked_law(law, "Fluid: law", own.GAS)

    @property
    def transport_law(self) -> Any:
        transport = ConstantTransport() if self.transport is None else self.transport
        return own.checked_law(transport, "Fluid: transport", own.TRANSPORT)

    @property
    def cv(self) -> float:
        """Specific heat at constant volume of the perfect gas of gamma and R [J/(kg K)]."""
        return self.R / (self.gamma - 1.0)

    def sound_speed(self, T: Any, rho: Any = 1.0) -> Any:
        """Speed of sound [m/s] at T [K] and rho [kg/m3], numbers or arrays of one shape."""
        return np.sqrt(self.gas_law.sound_speed_squared(rho, T))

    def equations(self, d: int, symmetry: int = 0) -> Gas:
        """Its equations, also around an axis or a centre; InputError if force has not d numbers."""
        laws, force = (self.gas_law, self.transport_law), force_in(self.force, d, "Fluid")
        return Gas(*laws, self.mu, self.kappa, force, (0.0,) * symmetry)


def force_in(force: Any, d: int, owner: str) -> tuple[float, ...]:
    """A body force [m/s2], a number or several, as d numbers, 0: as many as it has. InputError."""
    given = force if isinstance(force, (tuple, list)) else (force,)
    if d and not any(given):
        return (0.0,) * d
    if len(given) not in ((d,) if d else (1, 2, 3)):
        wanted = f"expected {d or '1 to 3'} numbers [m/s2]"
        raise InputError(f"{owner}: force is {described(force)}: {wanted}")
    return tuple(number(b, f"{owner}: force[{k}]", ANY, "m/s2") for k, b in enumerate(given))
