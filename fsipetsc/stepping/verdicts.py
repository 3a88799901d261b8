"""What is said of a state that cannot be gone on from, of steps that are too long, of °C."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import ComputationError
from fsipetsc.scheme.batch import longest_step
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, TOO_SHORT

if TYPE_CHECKING:
    from fsipetsc.stepping.state import State

#: Courant number beyond which steps are said to be long: the classical method, on a periodic grid,
#: is unstable beyond 1.6 to 2.8 (orders 8 to 2)
FAR = 1.5
#: a layer that is colder than this everywhere [K] has its temperature in °C, most likely
COLD = 100.0
#: the square of a larger number is none
TOO_LARGE = 1e150


class Seen(NamedTuple):
    """What a rank sees of a layer. numbers: of the points, (n,), as they count over all ranks;
    values: field -> (n,), those first of which others are made; positive: fields that must be
    above 0, the others need only be finite; place(i): of point i.
    """

    layer: int
    numbers: np.ndarray
    values: Mapping[str, np.ndarray]
    positive: frozenset[str]
    place: Callable[[int], str]


def described(state: State, t: float, step: int) -> str:
    """The first unphysical point of all ranks. Collective."""
    with np.errstate(all="ignore"):
        bad = [found for found in map(_first_bad, state.seen()) if found]
    every = state.comm.allgather(min(bad, default=None))
    first = min((found for found in every if found), default=None)
    when = f"t = {t:.6g}{state.problem.unit('s')}, step {step}"
    if first is None:
        return f"the time step is not a number at {when}"
    k, _, name, value, place = first
    what = f"{name} = {value:.6g}" if np.isfinite(value) else f"{name} is not a finite number"
    if TOO_LARGE <= abs(value) < np.inf:
        what += ", too large to go on with,"
    return f"{what} in layer '{state.problem.layers[k].name}' at {place}, {when}"


def _first_bad(seen: Seen) -> tuple[int, int, str, float, str] | None:
    """(layer, number of the point, field, value, place) of the first point that is not physical, or
    with numbers whose squares are none.
    """
    bad = []
    for name, values in seen.values.items():
        good = np.abs(values) < TOO_LARGE
        if name in seen.positive:
            good &= values > 0
        if not good.all():
            bad.append((int(np.argmin(good)), name))
    if not bad:
        return None
    i, name = min(bad, key=lambda entry: entry[0])
    return seen.layer, int(seen.numbers[i]), name, float(seen.values[name][i]), seen.place(i)


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
        said = filter(None, (described(state, t, step), beyond, advice(opt)))
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
    for part in state.seen():
        hottest[part.layer] = np.max(part.values["T"], initial=-np.inf)
    state.comm.Allreduce(MPI.IN_PLACE, hottest, MPI.MAX)
    return [
        f"note: '{layer.name}' is nowhere warmer than T = {T:.6g} K: "
        "temperatures are in K; is this one in °C?"
        for layer, T in zip(problem.layers, hottest.tolist(), strict=True)
        if problem.units == "SI" and T < COLD
    ]
