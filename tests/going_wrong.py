"""Flat layers in one dimension or two, of which a function goes wrong: what it gives drives the
computation mad, or it fails.

mad_field of layer mad_layer, an unknown of the case's forcing, gets a rate of mad_rate in the upper
half of it, from mad_time on: large enough, the next state has a density or a temperature below 0,
is folded, or is no number; place: the first wall moves at this speed. Or the function mad_function
raises an error from then on, on all ranks or on one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from mpi4py import MPI
from numba import njit

from fsipetsc.blocks.conditions import Clamped, Given, NoSlip, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.options import Option

NAME = "going_wrong"
SUMMARY = "layers of which a function goes wrong"
_FUNCTIONS = "which one fails: initial, forcing, edge, T, jumps"
OPTIONS = (
    Option("mad_layers", "str", "gsg", "", "g for a gas, s for a solid, from below"),
    Option("mad_dimension", "int", 2, "", "1 or 2"),
    Option("mad_layer", "int", 0, "", "which one"),
    Option("mad_field", "str", "none", "", "which unknown of the forcing, or place"),
    Option("mad_rate", "float", 0.0, "", "what is added to its rate there"),
    Option("mad_time", "float", 0.01, "s", "from when on"),
    Option("mad_function", "str", "none", "", _FUNCTIONS),
    Option("mad_rank", "int", -1, "", "where; -1: on all ranks"),
    Option("mad_compiled", "bool", False, "", "compiled code raises the error"),
)
DEFAULTS = {"fsi_h": 1 / 16, "fsi_order": 2, "ts_max_time": 0.1, "ts_dt": 1e-3, "fsi_output_dt": 1}
AIR, PLATE = Fluid(0.01, 0.03, 1.4, 1.0), ElasticSolid(5.0, 10.0, 0.02, 2.0, 1.0, p_ref=1.0)


def refuse() -> None:
    raise ValueError("nothing is known")


refuse_compiled = njit(refuse)


def build(opt: Mapping[str, Any]) -> BlockProblem:
    """Layers of thickness 1 at rest, in two dimensions of width 1."""
    kinds, name, d = opt["mad_layers"], opt["mad_function"], opt["mad_dimension"]
    stack = [layer(opt, k, kind) for k, kind in enumerate(kinds)]
    lower, upper = (NoSlip() if kind == "g" else Clamped() for kind in (kinds[0], kinds[-1]))
    if opt["mad_field"] == "place":
        since = lambda t: max(0.0, t - opt["mad_time"])  # noqa: E731
        speed = opt["mad_rate"]

        def place(*X_and_t):
            *X, t = X_and_t
            return (*X[:-1], X[-1] + speed * since(t))

        def velocity(*X_and_t):
            *X, t = X_and_t
            return (*(0 * x for x in X[:-1]), 0 * X[-1] + speed * (since(t) > 0))

        lower = Slip(place, velocity)
    if name == "T":
        lower = NoSlip(T=failing(opt, lambda *X: 1 + 0 * X[0], "T"))
    if name == "edge":
        values = lambda *X: (1 + 0 * X[0], *[0 * X[0]] * d, 1 + 0 * X[0])  # noqa: E731
        upper = Given(failing(opt, values, "edge"))
    jumps = failing(opt, lambda *X: [0 * X[0]] * (d + 1), "jumps") if name == "jumps" else None
    ends = {"lower": lower, "upper": upper, "jumps": jumps, "units": "none"}
    along = ((0.0, 1.0),)[: d - 1]
    return layers(*stack, along=along, h=opt["fsi_h"], order=opt["fsi_order"], **ends)


def failing(opt: Mapping[str, Any], function: Callable[..., Any], what: str) -> Callable[..., Any]:
    """The function, which raises an error from mad_time on if it is the one that fails; its last
    argument is the time.
    """
    here = opt["mad_function"] == what and opt["mad_rank"] in (-1, MPI.COMM_WORLD.rank)

    def called(*arguments: Any) -> Any:
        if here and (what == "initial" or arguments[-1] > opt["mad_time"]):
            refuse_compiled() if opt["mad_compiled"] else refuse()
        return function(*arguments)

    return called


def layer(opt: Mapping[str, Any], k: int, kind: str) -> Layer:
    """Gas or solid at rest, with the forcing that goes wrong."""
    along = "xy"[: opt["mad_dimension"]]
    names = ("rho", *(f"rho {v}" for v in "uv"[: len(along)]), "e")
    if kind == "s":
        names = (*"uv"[: len(along)], "T", *along)

    def at_rest(*X):
        still, one = [0 * X[0]] * len(X), 1 + 0 * X[0]
        return [one, *still, one] if kind == "g" else [*still, one, *X]

    def forcing(*arguments: Any) -> list[np.ndarray]:
        *places, t = arguments
        rates = [np.zeros(places[-1].shape) for _ in names]
        if t >= opt["mad_time"] and opt["mad_field"] in names:
            rates[names.index(opt["mad_field"])][places[-1] > k + 0.5] = opt["mad_rate"]
        return rates

    more = {}
    if k == opt["mad_layer"] and (opt["mad_field"] != "none" or opt["mad_function"] == "forcing"):
        more["forcing"] = failing(opt, forcing, "forcing")
    name, material = ("gas", AIR) if kind == "g" else ("bar", PLATE)
    initial = failing(opt, at_rest, "initial") if kind == "g" else at_rest
    return Layer(f"{name} {k}", material, (k, k + 1), initial, **more)
