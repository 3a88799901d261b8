"""A gas that flows out: F(U_in).

With a pressure p_b beyond and a Mach number m < 1 through the face it is that of Lax and
Friedrichs, with U_out of density and velocity of U_in and of pressure p + (1 - m^2)(p_b - p); m = 0
where gas flows in. F(U) = n . (f(U) - v U), v the velocity of the grid.
"""

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from fsipetsc.blocks.conditions.condition import Datum, FaceNode, OfGas
from fsipetsc.checks import NONNEGATIVE
from fsipetsc.equations.vectors import along, choose, dot, mean, sub


def surface_flux(gas, w, n, g):
    """F(U) of the state w; g: n . v."""
    return along(gas.flux(w, n), -g, gas.densities(w))


def mixed_flux(gas, w, beyond, n, g):
    """1/2 (F(U_in) + F(U_out)) - 1/2 lambda (U_out - U_in), lambda = max over both of
    |n . (u - v)| + c |n| (local Lax-Friedrichs).
    """
    fastest = gas.fastest(w, n, g), gas.fastest(beyond, n, g)
    jump = sub(gas.densities(beyond), gas.densities(w))
    both = mean(surface_flux(gas, w, n, g), surface_flux(gas, beyond, n, g))
    return along(both, -0.5 * np.maximum(*fastest), jump)


@dataclass(frozen=True)
class Outflow(OfGas):
    """A face through which gas flows out.

    Args:
        pressure: pressure beyond [Pa], a number or a function of (*X, t), which is imposed where
            the flow is slower than sound; 0 where it nowhere is.
    """

    pressure: Datum = 0.0
    ranges = OfGas.ranges | {"pressure": NONNEGATIVE}
    passes = "gas"
    at_faces = MappingProxyType({"pressure": ("pressure",)})
    knows_inflow = False

    @staticmethod
    def leaving(gas, w, face: FaceNode):
        """F(U_in), or that of Lax and Friedrichs; see above."""
        n, g, pressure = face.n, face.g, face.pressure
        m = np.maximum((dot(n, gas.velocity(w)) - g) / face.size, 0.0) / gas.speed_of_sound(w)
        p = w[1] + np.maximum(1.0 - m * m, 0.0) * (pressure - w[1])
        held = gas.state(w[0], gas.velocity(w), gas.law.temperature_of(w[0], p))
        fast = surface_flux(gas, w, n, g)
        return choose(pressure == 0.0, fast, mixed_flux(gas, w, held, n, g))
