"""Three gases of different laws with solids between them, at one pressure and at rest.

Each layer has the length 1. Where all conduct, T is linear in each, with one flux of heat.
"""

import numpy as np

from fsipetsc import Fluid, Option
from fsipetsc.blocks.conditions import NoSlip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.own import gas_law
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas

OPTIONS = (
    Option("gases_T", "floats", (1.5, 1.5), "", "temperatures of the walls"),
    Option("gases_conduct", "bool", True, "", "the gases conduct heat"),
)
DEFAULTS = {"fsi_h": 0.125, "ts_max_time": 5.0}
P, R, B = 1.0, 0.7, 0.1
#: heat conductivities of the layers
KAPPA = 0.2, 0.4, 0.5, 0.25, 0.3


def pressure(rho, T):
    """Of molecules that have a volume."""
    return rho * R * T / (1.0 - B * rho)


def internal_energy(rho, T):
    """The specific heat grows with T."""
    return 2.0 * T + 0.25 * T * T


def temperature(rho, e):
    return e / (1.0 + np.sqrt(1.0 + 0.25 * e))


def density(p, T):
    return p / (R * T + B * p)


def temperature_of(rho, p):
    return p * (1.0 / rho - B) / R


FORMULAS = pressure, internal_energy, temperature, density, temperature_of


def materials(conduct=True):
    """Of the layers from below."""
    own = gas_law(**{formula.__name__: formula for formula in FORMULAS})
    laws = None, stiffened_gas(3.0, 0.75, 5.0), own
    of_gases = (kappa if conduct else 0.0 for kappa in KAPPA[::2])
    gases = [Fluid(0.02, kappa, 1.4, 1.0, law) for kappa, law in zip(of_gases, laws)]
    solids = [ElasticSolid(0.0, 20.0, kappa, 2.0, 1.2, p_ref=P) for kappa in KAPPA[1::2]]
    return gases[0], solids[0], gases[1], solids[1], gases[2]


def profile(x, T):
    """The temperature at places from 0 to 5 between walls of the temperatures T."""
    drops = np.cumsum([0.0, *(1.0 / kappa for kappa in KAPPA)])
    return np.interp(x, range(6), T[0] + (T[1] - T[0]) * drops / drops[-1])


def build(opt):
    T = opt["gases_T"]

    def layer(k, material):
        def initial(X):
            found = profile(X, T)
            return (0.0, found, X) if k % 2 else (material.gas_law.density(P, found), 0.0, found)

        name = ("perfect", "bar 1", "liquid", "bar 2", "own")[k]
        return Layer(name, material, (k, k + 1.0), initial)

    walls = {"lower": NoSlip(T=T[0]), "upper": NoSlip(T=T[1]), "units": "none"}
    stack = map(layer, range(5), materials(opt["gases_conduct"]))
    return layers(*stack, **walls, h=opt["fsi_h"], order=opt["fsi_order"])
