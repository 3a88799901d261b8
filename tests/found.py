"""Problems that once gave wrong values; found_what says which (test_found.py)."""

import numpy as np

from fsipetsc import Block, BlockProblem, Fluid, Option
from fsipetsc.blocks.conditions import Centre, Clamped, Free, Given, NoSlip, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.maps import off_axis, rectangle
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas

WHAT = "two gases", "air and water", "rest", "sound", "burst", "noh"
OPTIONS = (
    Option("found_what", str, "rest", "", "which problem", WHAT),
    Option("found_law", str, "log", "", "law of the steel of a sound"),
    Option("found_k", int, 1, "", "of noh: 1 around an axis, 2 around a centre"),
)
DEFAULTS = {"fsi_h": 0.1, "ts_max_time": 1.0}
P0, T0 = 1e5, 300.0
AIR = Fluid(1e-3, 0.03, 1.4, 287.0)
OTHERS = {
    "two gases": Fluid(1e-3, 0.1, 1.667, 2077.0),
    "air and water": Fluid(1e-3, 0.6, 4.4, 400.0, law=stiffened_gas(4.4, 1000.0, 6e8)),
}


def at_rest(gas):
    return lambda X: (gas.gas_law.density(P0, T0) + 0.0 * X, 0.0, T0)


def build(opt):
    return {"noh": noh, "rest": rest, "sound": sound}.get(opt["found_what"], line)(opt)


def line(opt):
    """Air, steel that conducts, another gas; or a liquid in which the pressure jumps."""
    what, more = opt["found_what"], {"h": opt["fsi_h"], "order": opt["fsi_order"]}
    if what == "burst":
        water = OTHERS["air and water"]

        def jump(X):
            p = np.where(X < 0.5, P0 + 1e6, P0)
            return water.gas_law.density(p, T0), 0.0, T0

        return layers(Layer("water", water, (0.0, 1.0), jump), lower=Slip(), upper=Slip(), **more)
    steel, other = ElasticSolid(8e10, 1.1e11, 15.0, 7800.0, 500.0, p_ref=P0), OTHERS[what]
    stack = (
        Layer("air", AIR, (0.0, 1.0), at_rest(AIR)),
        Layer("steel", steel, (1.0, 2.0), lambda X: (0.0, T0, X)),
        Layer("other", other, (2.0, 3.0), at_rest(other)),
    )
    return layers(*stack, lower=NoSlip(T=T0), upper=NoSlip(T=T0), **more)


def rest(opt):
    """A floor of rock under air."""
    rock = ElasticSolid(2e9, 3e9, 0.0, 2000.0, 800.0, p_ref=P0, heat="elastic")
    air = Fluid(0.0, 0.0, 1.4, 287.0)
    stack = (
        Layer("floor", rock, (-1.0, 0.0), lambda X, Y: (0.0, 0.0, T0, X, Y)),
        Layer("air", air, (0.0, 1.0), lambda X, Y: (P0 / 287.0 / T0, 0.0, 0.0, T0)),
    )
    more = {"h": opt["fsi_h"], "order": opt["fsi_order"]}
    return layers(*stack, along=((0.0, 1.0),), lower=Clamped(), upper=Slip(), **more)


def sound(opt):
    """Of 100 Pa in air on steel, whose strains are 1e-9."""
    law = {"p_ref": P0, "law": opt["found_law"], "heat": "elastic"}
    steel = ElasticSolid(8e10, 1.1e11, 0.0, 7800.0, 500.0, **law)

    def pulse(X):
        q = 100.0 * np.exp(-(((X - 0.1) / 0.03) ** 2)) / P0
        rho = P0 / 287.0 / T0 * (1.0 + q) ** (1.0 / 1.4)
        return rho, -q * P0 / (1.161 * 347.2), T0 * (1.0 + q) ** (0.4 / 1.4)

    stack = (
        Layer("steel", steel, (-0.05, 0.0), lambda X: (0.0, T0, X), cells=10),
        Layer("air", Fluid(0.0, 0.0, 1.4, 287.0), (0.0, 0.2), pulse, cells=40),
    )
    return layers(*stack, lower=Free(P0), upper=Slip(), h=0.005, order=opt["fsi_order"])


def noh(opt):
    """Cold gas falls on an axis or a centre: behind the shock rho is 4^(k + 1)."""
    k, n, p0 = opt["found_k"], 200, 1e-6

    def far(X, t):
        return (1 + t / X) ** k, -1.0 + 0 * X, p0 * (1 + t / X) ** (k * 2 / 3)

    gas, places = Fluid(0.0, 0.0, 5 / 3, 1.0), off_axis(rectangle(0.0, 1.0), n)
    block = Block("gas", gas, places, (n,), lambda X: (1.0, -1.0, p0))
    return BlockProblem((block,), {("gas", 0, 0): Centre(), ("gas", 0, 1): Given(far)}, symmetry=k)
