"""What is said of a state that cannot be gone on from, and of steps that are much too long."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.errors import ComputationError
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, TOO_SHORT
from fsipetsc.scheme.time_step import longest_step
from fsipetsc.stepping.advice import advice

if TYPE_CHECKING:
    from fsipetsc.stepping.state import State

#: Courant number beyond which steps are said to be long: the classical method, on a periodic grid, is unstable beyond 1.6
#: to 2.8 (orders 8 to 2)
FAR = 1.5


def unsound(flags: Sequence[float] | np.ndarray) -> bool:
    """A number is not finite, or a density, temperature or length not above 0; flags: flags and limits of a step."""
    return bool(flags[BAD] or not flags[RATE] < np.inf)


def left_the_domain(flags: Sequence[float] | np.ndarray) -> bool:
    """The state is not one of the equations any more: it is ``unsound``, or a boundary has left its grid."""
    return unsound(flags) or bool(flags[EXHAUSTED])


def no_step(state: State, t: float, step: int, dt: float, wanted: float, opt: Mapping[str, Any]) -> str:
    """What is said where step-size control refuses a step of dt [s] to t [s] and has none left to try. Collective.

    wanted: the step that it would make [s].
    """
    s = state.problem.unit("s")
    if unsound(state.results):
        words, topic = state.failure(t, step)
        return f"{words}, after a step of {dt:.3g}{s} as after all longer ones; {advice(topic, opt)}"
    said = f"step-size control finds no step at t = {t - dt:.6g}{s}, step {step}: it wants {wanted:.3g}{s}"
    return f"{said}; {advice('control', opt)}"


def check(state: State, t: float, step: int, flags: Sequence[float], opt: Mapping[str, Any], beyond: str) -> None:
    """Raise ComputationError if the state at t [s] cannot be gone on from.

    opt: options in force; beyond: what ``beyond_bound`` said.
    """
    layers, s = state.problem.layers, state.problem.unit("s")
    if unsound(flags):
        words, topic = state.failure(t, step)
        raise ComputationError("; ".join(filter(None, (words, beyond, advice(topic, opt)))))
    if flags[EXHAUSTED]:
        k = int(flags[EXHAUSTED]) - 1
        raise ComputationError(
            f"the points of fluid layer '{layers[k].name}' are used up at t = {t:.6g}{s}, step {step}, "
            f"{_boundary(state, k)}: its boundary crossed more than one cell in a step; {advice('crossed', opt)}"
        )
    if flags[TOO_SHORT]:
        k = int(flags[TOO_SHORT]) - 1
        least = int(state.layout.records[k]["least"])
        raise ComputationError(
            f"fluid layer '{layers[k].name}' has become too short at t = {t:.6g}{s}, step {step}, "
            f"{_boundary(state, k)}: the {state.op.name} operator needs {least} points; {advice('short', opt)}"
        )


def beyond_bound(state: State, opt: Mapping[str, Any]) -> str:
    """By how much the steps that were asked for exceed their bound, in words; "" if not by far."""
    rate = float(state.results[RATE])
    step, s = longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, rate), state.problem.unit("s")
    if opt["ts_adapt_type"] != "none" or not step * rate > FAR:
        return ""
    asked = f"-ts_dt {step:g}{s}" if opt["ts_dt"] else f"-fsi_cfl {opt['fsi_cfl']:g}"
    return f"{asked} is {step * rate:.3g} times the bound on the step at t = {state.begin:.6g}{s}, {1 / rate:.3g}{s}"


def _boundary(state: State, k: int) -> str:
    record = state.layout.records[k]
    side = 0 if record["end_kind"][0] >= 0 else 1
    interface, boundary = record["x_interface"], record["end_x"][side]
    m = state.problem.unit("m")
    return f"with its interface at x = {interface:.6g}{m} and its boundary at x = {boundary:.6g}{m}"
