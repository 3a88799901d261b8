"""Layers, in one dimension and in two, of which a function goes wrong: what it gives drives the
computation mad, or it fails.

mad_field of layer mad_layer, an unknown of the case's forcing, gets a rate of mad_rate above
mad_place of it, from mad_time on: large enough, the next state has a density or a temperature below
0, is folded, or is no number; place: the first wall moves at this speed.
Or the function mad_function raises an error from then on, on all ranks or on one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from mpi4py import MPI
from numba import njit

from fsipetsc.blocks import conditions
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.boundaries import Wall, clamped
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.fluid import Fluid as Gas
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "going_wrong"
SUMMARY = "layers of which a function goes wrong"
OPTIONS = (
    Option(
        "mad_layers",
        "str",
        "gsg",
        "",
        "g for a gas, s for a solid, from left to right or from below",
    ),
    Option("mad_plane", "bool", False, "", "in two dimensions"),
    Option("mad_layer", "int", 0, "", "which one"),
    Option(
        "mad_field",
        "str",
        "none",
        "",
        "which of its unknowns: rho, rho u, rho v, e; u, v, sigma, T, x, y; or place",
    ),
    Option("mad_rate", "float", 0.0, "", "what is added to its rate there"),
    Option("mad_place", "float", 0.5, "", "in parts of the layer"),
    Option("mad_time", "float", 0.01, "s", "from when on"),
    Option(
        "mad_function",
        "str",
        "none",
        "",
        "which one fails: initial, exact, forcing, edge, place, T, jumps",
    ),
    Option("mad_rank", "int", -1, "", "where; -1: on all ranks"),
    Option("mad_compiled", "bool", False, "", "compiled code raises the error"),
)
DEFAULTS = {
    "fsi_h": 0.0625,
    "fsi_order": 2,
    "ts_max_time": 0.1,
    "ts_dt": 1e-3,
    "fsi_output_dt": 1.0,
}
#: unknowns in the order of the forcing: dimension, kind
UNKNOWNS = {
    (1, "g"): ("rho", "rho u", "e"),
    (1, "s"): ("u", "sigma", "T", "x"),
    (2, "g"): ("rho", "rho u", "rho v", "e"),
    (2, "s"): ("u", "v", "T", "x", "y"),
}
GAS, BAR = Fluid(0.01, 0.03, 1.4, 1.0), Solid(20.0, 0.02, 2.0, 1.0)
AIR, PLATE = Gas(0.01, 0.03, 1.4, 1.0), ElasticSolid(5.0, 10.0, 0.02, 2.0, 1.0, p_ref=1.0)


def refuse() -> None:
    raise ValueError("nothing is known")


refuse_compiled = njit(refuse)


def build(opt: Mapping[str, Any]) -> Problem | BlockProblem:
    """Layers of thickness 1 at rest, in two dimensions of width 1; a gas that is the first one has
    a wall.
    """
    stack = [
        (_plane_layer if opt["mad_plane"] else _layer)(opt, k, kind)
        for k, kind in enumerate(opt["mad_layers"])
    ]
    fails, name = lambda function, what: _failing(opt, function, what), opt["mad_function"]
    first, last = opt["mad_layers"][0], opt["mad_layers"][-1]

    def wall(t: float) -> tuple[float, float]:
        """Place and velocity."""
        return opt["mad_rate"] * max(0.0, t - opt["mad_time"]), opt["mad_rate"] * (
            t >= opt["mad_time"]
        )

    if opt["mad_plane"]:
        lower, upper = (
            conditions.NoSlip() if kind == "g" else conditions.Clamped() for kind in (first, last)
        )
        if name == "place":
            lower = conditions.NoSlip(x=fails(lambda X, Y, t: (X, 0 * X), "place"))
        if opt["mad_field"] == "place":
            moves = (
                (lambda X, Y, t: (X, 0 * X + wall(t)[0])),
                (lambda X, Y, t: (0 * X, 0 * X + wall(t)[1])),
            )
            lower = conditions.Slip(*moves)
        if name == "T":
            lower = conditions.NoSlip(T=fails(lambda X, Y, t: 1 + 0 * X, "T"))
        if name == "edge":
            upper = conditions.Given(
                fails(lambda X, Y, t: (1 + 0 * X, 0 * X, 0 * X, 1 + 0 * X), "edge")
            )
        jumps = fails(lambda X, Y, t: (0 * X, 0 * X, 0 * X), "jumps") if name == "jumps" else None
        ends = {"lower": lower, "upper": upper, "jumps": jumps, "units": "none"}
        return layers(*stack, along=((0.0, 1.0),), h=opt["fsi_h"], order=opt["fsi_order"], **ends)
    place = fails(lambda t: 0.0, "place") if name == "place" else 0.0
    place = (lambda t: wall(t)[0]) if opt["mad_field"] == "place" else place
    heat = {"T": fails(lambda t: 1.0, "T")} if name == "T" else {}
    left = Wall(place, **heat) if first == "g" else clamped()
    right = (
        Wall(float(len(stack)))
        if last == "g"
        else clamped(fails(lambda t: 0.0, "edge") if name == "edge" else 0.0)
    )
    jumps = fails(lambda k, t: (0.0, 0.0, 0.0, 0.0), "jumps") if name == "jumps" else None
    return Problem(tuple(stack), left, right, jumps, units="none")


def _failing(opt: Mapping[str, Any], function: Callable[..., Any], what: str) -> Callable[..., Any]:
    """The function, which raises an error from mad_time on if it is the one that fails; its last
    argument is the time.
    """
    here = opt["mad_function"] == what and opt["mad_rank"] in (-1, MPI.COMM_WORLD.rank)

    def called(*arguments: Any) -> Any:
        if here and (what == "initial" or arguments[-1] > opt["mad_time"]):
            refuse_compiled() if opt["mad_compiled"] else refuse()
        return function(*arguments)

    return called


def _plane_layer(opt: Mapping[str, Any], k: int, kind: str) -> Layer:
    def gas(X, Y):
        return [1 + 0 * X, 0 * X, 0 * X, 1 + 0 * X]

    def plate(X, Y):
        return [0 * X, 0 * X, 1 + 0 * X, X, Y]

    if kind == "g":
        return Layer(
            f"gas {k}",
            AIR,
            (k, k + 1),
            _failing(opt, gas, "initial"),
            **_functions(opt, k, kind, 2, gas),
        )
    return Layer(f"bar {k}", PLATE, (k, k + 1), plate, **_functions(opt, k, kind, 2, plate))


def _layer(opt: Mapping[str, Any], k: int, kind: str) -> FluidLayer | SolidLayer:
    def gas(X):
        return [1 + 0 * X, 0 * X, 1 + 0 * X]

    def bar(X):
        return [0 * X, 0 * X - 1.0, 1 + 0 * X, X]

    if kind == "g":
        return FluidLayer(
            f"gas {k}",
            GAS,
            (k, k + 1),
            _failing(opt, gas, "initial"),
            **_functions(opt, k, kind, 1, gas),
        )
    return SolidLayer(f"bar {k}", BAR, (k, k + 1), bar, **_functions(opt, k, kind, 1, bar))


def _functions(
    opt: Mapping[str, Any], k: int, kind: str, dimension: int, initial: Callable[..., Any]
) -> dict[str, Any]:
    """Forcing and exact solution of a layer, where they are what goes wrong."""
    names, found = UNKNOWNS[dimension, kind], {}
    if opt["mad_function"] == "exact":
        found["exact"] = _failing(opt, lambda *arguments: initial(*arguments[:-1]), "exact")
    if k != opt["mad_layer"] or (opt["mad_field"] == "none" and opt["mad_function"] != "forcing"):
        return found

    def forcing(*arguments: Any) -> list[np.ndarray]:
        *places, t = arguments
        rates = [np.zeros(places[-1].shape) for _ in names]
        if t >= opt["mad_time"] and opt["mad_field"] in names:
            rates[names.index(opt["mad_field"])][places[-1] > k + opt["mad_place"]] = opt[
                "mad_rate"
            ]
        return rates

    return {**found, "forcing": _failing(opt, forcing, "forcing")}
