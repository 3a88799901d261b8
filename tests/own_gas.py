"""The closed box with a gas of Noble and Abel, p = rho R T / (1 - b rho), and e = cv T; b is 0 where gamma is 1.4.

The forms are those of the perfect gas, so that with b = 0 every bit is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsipetsc.cases import box
from fsipetsc.physics.own_laws import gas_law

OPTIONS = box.OPTIONS
DEFAULTS = box.DEFAULTS


def constants(record):
    return record.R, record.gamma, record.cv, 1.0 / record.cv, 0.5 * (record.gamma - 1.4)


def temperature(c, rho, e):
    return e / c[2]


def temperature_in_loops(c, rho, e):
    return e * c[3]


def energy(c, rho, T):
    return c[2] * T


def pressure(c, rho, T):
    return c[0] * rho * T / (1 - c[4] * rho)


def pressure_of_energy(c, rho, E):
    return (c[1] - 1) * E / (1 - c[4] * rho)


def density(c, p, T):
    return p / (c[0] * T + c[4] * p)


def temperature_of_pressure(c, rho, p):
    return p * (1 - c[4] * rho) / (c[0] * rho)


def heat_capacity(c, rho, T):
    return c[2]


def pressure_by_temperature(c, rho, T):
    return c[0] * rho / (1 - c[4] * rho)


def bulk_modulus(c, rho, T):
    room = 1 - c[4] * rho
    return c[0] * rho * T / (room * room)


def bulk_modulus_of_energy(c, rho, E):
    room = 1 - c[4] * rho
    return (c[1] - 1) * E / (room * room)


def sound_speed_squared(c, rho, T):
    room = 1 - c[4] * rho
    return c[1] * c[0] * T / (room * room)


def sound_speed_squared_of_energy(c, rho, e):
    room = 1 - c[4] * rho
    return c[1] * (c[1] - 1) * e / (room * room)


def entropy(c, rho, T):
    return c[2] * np.log(T) - c[0] * np.log(rho / (1 - c[4] * rho))


NAMES = (
    "constants temperature temperature_in_loops energy pressure pressure_of_energy density "
    "temperature_of_pressure heat_capacity pressure_by_temperature bulk_modulus bulk_modulus_of_energy "
    "sound_speed_squared sound_speed_squared_of_energy entropy"
).split()


def of_this_gas(layer, law):
    """A layer of the box with this law, under the same pressure."""
    material = replace(layer.material, law=law)
    b = constants(material)[4]

    def initial(X):
        rho, u, T = layer.initial(X)
        return rho / (1 + b * rho), u, T

    return replace(layer, material=material, initial=initial)


def build(opt):
    problem, law = box.build(opt), gas_law(**{name: globals()[name] for name in NAMES})
    layers = (of_this_gas(layer, law) if layer.kind == "fluid" else layer for layer in problem.layers)
    return replace(problem, layers=tuple(layers))
