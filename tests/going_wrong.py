"""Flat layers at rest in two dimensions, of which a function goes wrong from mad_time on.

mad_field of layer mad_layer, an unknown of its forcing, gets a rate of mad_rate in its upper half;
place: the lower wall moves at this speed. Or the function mad_function fails, on all ranks or on
one."""

import numpy as np
from mpi4py import MPI

from fsipetsc import Fluid, Option
from fsipetsc.blocks.conditions import Clamped, Given, NoSlip, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = (
    Option("mad_layers", "str", "gsg", "", "g for a gas, s for a solid, from below"),
    Option("mad_layer", "int", 0, "", "which one"),
    Option("mad_field", "str", "none", "", "which unknown of the forcing, or place"),
    Option("mad_rate", "float", 0.0, "", "what is added to its rate there"),
    Option("mad_time", "float", 0.01, "s", "from when on"),
    Option("mad_function", "str", "none", "", "initial, forcing, edge, jumps"),
    Option("mad_rank", "int", -1, "", "where; -1: on all ranks"),
)
DEFAULTS = {"fsi_h": 1 / 16, "fsi_order": 2, "ts_max_time": 0.1, "ts_dt": 1e-3, "fsi_output_dt": 1}
AIR, PLATE = Fluid(0.01, 0.03, 1.4, 1.0), ElasticSolid(5.0, 10.0, 0.02, 2.0, 1.0, p_ref=1.0)
NAMES = {"g": ("rho", "rho u", "rho v", "e"), "s": ("u", "v", "T", "x", "y")}


def build(opt):
    """Layers of thickness 1 and width 1."""
    function, field = opt["mad_function"], opt["mad_field"]
    rate, begin = opt["mad_rate"], opt["mad_time"]

    def failing(what, usual):
        """The function, which raises an error if it is the one; its last argument is the time."""
        here = function == what and opt["mad_rank"] in (-1, MPI.COMM_WORLD.rank)

        def called(*arguments):
            if here and (what == "initial" or arguments[-1] > begin):
                raise ValueError("nothing is known")
            return usual(*arguments)

        return called

    def layer(k, kind):
        def at_rest(X, Y):
            return (1.0, 0.0, 0.0, 1.0) if kind == "g" else (0.0, 0.0, 1.0, X, Y)

        def forcing(X, Y, t):
            rates = [np.zeros(Y.shape) for _ in NAMES[kind]]
            if t >= begin and field in NAMES[kind]:
                rates[NAMES[kind].index(field)][Y > k + 0.5] = rate
            return rates

        mad = k == opt["mad_layer"] and (field != "none" or function == "forcing")
        more = {"forcing": failing("forcing", forcing)} if mad else {}
        name, material = (f"gas {k}", AIR) if kind == "g" else (f"bar {k}", PLATE)
        initial = failing("initial", at_rest) if kind == "g" else at_rest
        return Layer(name, material, (k, k + 1), initial, **more)

    kinds = opt["mad_layers"]
    lower, upper = (NoSlip() if kind == "g" else Clamped() for kind in (kinds[0], kinds[-1]))
    if field == "place":
        place = lambda X, Y, t: (X, Y + rate * max(0.0, t - begin))  # noqa: E731
        lower = Slip(x=place, velocity=lambda X, Y, t: (0.0, rate * (t > begin)))
    if function == "edge":
        upper = Given(failing("edge", lambda X, Y, t: (1.0, 0.0, 0.0, 1.0)))
    jumps = failing("jumps", lambda X, Y, t: (0.0, 0.0, 0.0)) if function == "jumps" else None
    more = {"lower": lower, "upper": upper, "jumps": jumps, "units": "none"}
    stack = [layer(k, kind) for k, kind in enumerate(kinds)]
    return layers(*stack, along=((0.0, 1.0),), h=opt["fsi_h"], order=opt["fsi_order"], **more)
