"""Gas under a solid in two dimensions, with data that depend on time everywhere.

timed_kind: wall, the gas stands on a wall that moves and is warm, the solid is pressed and heated
from above, jumps and forcing; ends, the gas is given below and the solid clamped to what moves;
open, gas enters from below, and waves leave the solid; lid, walls at rest beside one that moves,
but not at its ends. timed_how: record, all functions can be;
table, one of them is a table of numpy's; bad, one of them returns no number from t = 0.02 on."""

import numpy as np

from fsipetsc import Fluid, Option
from fsipetsc.blocks.conditions import Absorbing, Clamped, Free, Given, NoSlip, Open
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.solid import ElasticSolid

KINDS = "wall", "ends", "open", "lid"
OPTIONS = (
    Option("timed_kind", str, "wall", "", "where data depend on time", KINDS),
    Option("timed_how", str, "record", "", "of the functions", ("record", "table", "bad")),
    Option("timed_size", float, 0.02, "m", "amplitude"),
    Option("timed_rate", float, 9.0, "1/s", "angular frequency"),
)
DEFAULTS = {"fsi_h": 0.125, "fsi_order": 2, "ts_max_time": 0.1, "fsi_output_dt": 0.05}
GAS = Fluid(0.01, 0.03, 1.4, 1.0)
SOLID = ElasticSolid(5.0, 10.0, 0.02, 2.0, 1.0, p_ref=1.0)
TIMES, TABLE = np.linspace(0.0, 1.0, 11), 1.0 + 0.1 * np.sin(np.linspace(0.0, 3.0, 11))


def build(opt):
    """The gas from Y = 0 to 1, the solid up to 2."""
    a, w, how = opt["timed_size"], opt["timed_rate"], opt["timed_how"]
    kind, beside = opt["timed_kind"], opt["timed_kind"] == "lid"

    def swing(X, t):
        return a * (1.0 - np.cos(w * t)) * np.sin(2 * np.pi * X) ** 2

    def speed(X, t):
        return a * w * np.sin(w * t) * np.sin(2 * np.pi * X) ** 2

    def T(X, Y, t):
        if how == "table":
            return np.interp(t, TIMES, TABLE) + 0.0 * X
        return np.where(t > 0.02, np.nan if how == "bad" else 1.5, 1.0) + 0.1 * np.exp(-t) * np.cos(
            2 * np.pi * X
        )

    def forcing(X, Y, t):
        return 0.0, 0.1 * np.sin(w * t) * np.cos(2 * np.pi * X), 0.0, np.tanh(t) * Y

    def jumps(X, Y, t):
        return 0.0, 0.01 * np.sqrt(1.0 + t) * np.cos(2 * np.pi * X), 0.1 * t

    def inflow(X, Y, t):
        return 1.0 + 0.1 * t**2.5, 0.0, 0.1 * speed(X, t), T(X, Y, t)

    def wind(X, Y, t):
        return 0.0, 0.1 * speed(X, t)

    def stress(X, Y, t):
        return -1.0 - 0.1 * np.tanh(t * (1.0 + X))

    def heat(X, Y, t):
        return 0.1 * np.log1p(t) * np.abs(X - 0.5)

    def place(X, Y, t):
        return X, Y + swing(X, t)

    def velocity(X, Y, t):
        return 0.0, speed(X, t)

    pressed = Free(lambda *x: -stress(*x), heat_flux=heat)
    lower, upper = {
        "wall": (NoSlip(x=place, T=T), pressed),
        "lid": (NoSlip(x=place, velocity=velocity), pressed),
        "ends": (Given(inflow), Clamped(x=place, velocity=velocity, T=T)),
        "open": (Open(lambda *x: inflow(*x)[0], wind, T), Absorbing(stress)),
    }[kind]
    walls, clamps = (NoSlip(), Clamped()) if beside else (None, None)
    of_gas = Layer(
        *("gas", GAS, (0.0, 1.0), lambda X, Y: (1.0, 0.0, 0.0, 1.0)), forcing=forcing, sides=walls
    )
    plate = Layer("plate", SOLID, (1.0, 2.0), lambda X, Y: (0.0, 0.0, 1.0, X, Y), sides=clamps)
    more = {"lower": lower, "upper": upper, "units": "none"}
    more |= {"jumps": jumps} if kind == "wall" else {}
    return layers(of_gas, plate, along=((0.0, 1.0),), h=opt["fsi_h"], order=2, **more)
