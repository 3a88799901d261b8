"""The closed box with a gas of Noble and Abel, p = rho R T / (1 - b rho), e = cv T.

b is 0 where gamma is 1.4.

The forms are those of the perfect gas, so that with b = 0 every bit is.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fsipetsc.cases import box

OPTIONS = box.OPTIONS
DEFAULTS = box.DEFAULTS


class NobleAbel(NamedTuple):
    """gamma, R, b."""

    gamma: float
    R: float
    b: float

    def pressure(self, rho, T):
        return rho * (self.R * T) / (1.0 - self.b * rho)

    def internal_energy(self, rho, T):
        return self.R / (self.gamma - 1.0) * T

    def energy_density(self, rho, T):
        return rho * (self.R / (self.gamma - 1.0) * T)

    def temperature(self, rho, e):
        return (self.gamma - 1.0) / self.R * e

    def density(self, p, T):
        return p / (self.R * T + self.b * p)

    def temperature_of(self, rho, p):
        return p * (1.0 - self.b * rho) / (self.R * rho)

    def heat_capacity(self, rho, T):
        return self.R / (self.gamma - 1.0)

    def sound_speed_squared(self, rho, T):
        room = 1.0 - self.b * rho
        return self.gamma * self.R * T / (room * room)

    def bulk_modulus(self, rho, T):
        room = 1.0 - self.b * rho
        return rho * (self.R * T) / (room * room)

    def pressure_by_temperature(self, rho, T):
        return self.R * rho / (1.0 - self.b * rho)

    def entropy(self, rho, T):
        return self.R / (self.gamma - 1.0) * np.log(T) - self.R * np.log(rho / (1.0 - self.b * rho))


def of_this_gas(layer):
    """A layer of the box with this law, under the same pressure."""
    b = 0.5 * (layer.material.gamma - 1.4)

    def initial(X):
        rho, u, T = layer.initial(X)
        return rho / (1 + b * rho), u, T

    law = NobleAbel(layer.material.gamma, layer.material.R, b)
    return replace(layer, material=replace(layer.material, law=law), initial=initial)


def build(opt):
    problem = box.build(opt)
    layers = (of_this_gas(layer) if layer.kind == "fluid" else layer for layer in problem.layers)
    return replace(problem, layers=tuple(layers))
