"""What is said of a state that cannot be gone on from, of steps that are too long, of °C."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.columns import fields_of
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.errors import ComputationError
from fsipetsc.paper.fields import seen
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, TOO_SHORT
from fsipetsc.scheme.time_step import longest_step

if TYPE_CHECKING:
    from fsipetsc.stepping.state import State

#: Courant number beyond which steps are said to be long: the classical method, on a periodic grid,
#: is unstable beyond 1.6 to 2.8 (orders 8 to 2)
FAR = 1.5
#: a layer that is colder than this everywhere [K] has its temperature in °C, most likely
COLD = 100.0


def advice(opt: Mapping[str, Any]) -> str:
    """What usually helps, in words; opt: options in force."""
    paper = opt["fsi_coupling"] != "conservative"
    unused = [f"-{name} 1" for name in ("fsi_dissipation", "fsi_shock") if not opt[name]]
    shocks = " and ".join([*(["-fsi_coupling conservative"] * paper), *unused])
    steps = "a smaller -ts_dt" if opt["ts_dt"] else "a smaller -fsi_cfl"
    tried = [steps, "a finer grid (-fsi_h)", *([f"{shocks} where there are shocks"] * bool(shocks))]
    return f"what usually helps: {', '.join(tried)}"


def check(
    state: State, t: float, step: int, flags: Sequence[float], opt: Mapping[str, Any], beyond: str
) -> None:
    """Raise ComputationError if the state at t [s] cannot be gone on from.

    flags: flags and limits of the step; beyond: what ``beyond_bound`` said.
    """
    if flags[BAD] or not flags[RATE] < np.inf:
        said = filter(None, (state.failure(t, step), beyond, advice(opt)))
        raise ComputationError("; ".join(said))
    if not flags[EXHAUSTED] and not flags[TOO_SHORT]:
        return
    k = int(flags[EXHAUSTED] or flags[TOO_SHORT]) - 1
    record, m = state.records[k], state.problem.unit("m")
    side = 0 if record["end_kind"][0] >= 0 else 1
    name = f"fluid layer '{state.problem.layers[k].name}'"
    interface, boundary = record["x_interface"], record["end_x"][side]
    where = f"at t = {t:.6g}{state.problem.unit('s')}, step {step}, with its interface at "
    where += f"x = {interface:.6g}{m} and its boundary at x = {boundary:.6g}{m}"
    if flags[EXHAUSTED]:
        raise ComputationError(f"the points of {name} are used up {where}")
    least = f"the {state.op.name} operator needs {int(record['least'])} points"
    raise ComputationError(f"{name} has become too short {where}: {least}")


def beyond_bound(state: State, opt: Mapping[str, Any]) -> str:
    """By how much the steps that were asked for exceed their bound; "" if not by far."""
    rate = float(state.results[RATE])
    step = longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, rate)
    if not step * rate > FAR:
        return ""
    s = state.problem.unit("s")
    asked = f"-ts_dt {step:g}{s}" if opt["ts_dt"] else f"-fsi_cfl {opt['fsi_cfl']:g}"
    bound = f"the bound on the step at t = 0{s}, {1 / rate:.3g}{s}"
    return f"{asked} is {step * rate:.3g} times {bound}"


def cold_layers(state: State) -> list[str]:
    """A note for each layer whose temperature can hardly be in K. Collective."""
    problem = state.problem
    hottest = np.full(len(problem.layers), -np.inf)
    for k, T in _temperatures(state):
        hottest[k] = np.max(T, initial=-np.inf)
    state.comm.Allreduce(MPI.IN_PLACE, hottest, MPI.MAX)
    return [
        f"note: '{layer.name}' is nowhere warmer than T = {T:.6g} K: "
        "temperatures are in K; is this one in °C?"
        for layer, T in zip(problem.layers, hottest.tolist(), strict=True)
        if problem.units == "SI" and T < COLD
    ]


def _temperatures(state: State) -> Iterator[tuple[int, np.ndarray]]:
    """(number of the layer, temperatures [K] at this rank's points)."""
    problem = state.problem
    if not isinstance(problem, RunProblem):
        yield from ((part.layer, part.values["T"]) for part in seen(state))
        return
    for part in state.layout.parts:
        column = fields_of(problem.layers[part.k].kind, problem.dimension).index("T")
        yield part.k, state.fields(part.k)[:, column]
