"""What is said of a state that cannot be gone on from, and of steps that are too long."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from fsipetsc.errors import ComputationError
from fsipetsc.scheme.batch import longest_step
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, TOO_SHORT
from fsipetsc.state import Seen, State

#: Courant number beyond which steps are said to be long: the classical method, on a periodic grid,
#: is unstable beyond 1.6 to 2.8 (orders 8 to 2)
FAR = 1.5
#: the square of a larger number is none
TOO_LARGE = 1e150
#: fields that must be above 0; others need only be finite
POSITIVE = "rho", "T", "J", "x_X", "m0 c^2"
HELPS = (
    "what usually helps: shorter steps (-fsi_cfl or -ts_dt), a finer grid (-fsi_h); where there "
    "are shocks -fsi_coupling conservative -fsi_dissipation 1 -fsi_shock 1"
)


def described(state: State, t: float, step: int) -> str:
    """The first unphysical point of all ranks. Collective."""
    first = first_bad(state)
    m, when = state.problem.unit("m"), f"t = {t:.6g}{state.problem.unit('s')}, step {step}"
    if first is None:
        return f"the time step is not a number at {when}"

    def place(letters: str, x: Sequence[float]) -> str:
        return ", ".join(f"{letter} = {value:.6g}{m}" for letter, value in zip(letters, x))

    k, _, _, name, value, x, X = first
    what = f"{name} = {value:.6g}" if np.isfinite(value) else f"{name} is not a finite number"
    if TOO_LARGE <= abs(value) < np.inf:
        what += ", too large to go on with,"
    if name == "m0 c^2":
        what = f"waves have become imaginary, their {what}: the law has no meaning here,"
    where = f"in layer '{state.problem.layers[k].name}' at {place('xyz', x)} ({place('XYZ', X)})"
    return f"{what} {where}, {when}"


def first_bad(state: State) -> tuple[Any, ...] | None:
    """What ``_bad_points`` says of the first one of all ranks; None without any. Collective."""
    with np.errstate(all="ignore"):
        bad = [found for seen in state.seen() for found in _bad_points(seen)]
    return min((found for some in state.comm.allgather(bad) for found in some), default=None)


def _bad_points(seen: Seen) -> Iterator[tuple[Any, ...]]:
    """Of each field the first point that is not physical, or with numbers whose squares are none:
    (layer, number of the point, number of the field, field, value, x, X).
    """
    for number, (name, values) in enumerate(seen.values.items()):
        good = (np.abs(values) < TOO_LARGE) & ((values > 0) | (name not in POSITIVE))
        if not good.all():
            i = int(np.argmin(good))
            about = number, name, float(values[i]), seen.x[i].tolist(), seen.X[i].tolist()
            yield seen.layer, int(seen.numbers[i]), *about


def check(state: State, t: float, step: int, flags: Sequence[float], beyond: str) -> None:
    """Raise ComputationError if the state at t [s] cannot be gone on from. Collective.

    flags: flags and limits of the step; beyond: what ``beyond_bound`` said.
    """
    if flags[BAD] or not flags[RATE] < np.inf:
        cause = state.go_to_fault(partial(first_bad, state))
        about = described(state, t, step), *state.notes("failed"), beyond
        said = filter(None, (*about, cause or HELPS))
        raise ComputationError("; ".join(said))
    if flags[EXHAUSTED] or flags[TOO_SHORT]:
        when = f"t = {t:.6g}{state.problem.unit('s')}, step {step}"
        raise ComputationError(f"at {when} {state.used_up()}")


def beyond_bound(state: State, opt: Mapping[str, Any]) -> str:
    """By how much the steps that were asked for exceed their bound; "" if not by far."""
    rate = float(state.results[RATE])
    step = longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, rate)
    if not step * rate > FAR:
        return ""
    s = state.problem.unit("s")
    asked = f"-ts_dt {step:g}{s}" if opt["ts_dt"] else f"-fsi_cfl {opt['fsi_cfl']:g}"
    bound = f"the bound on the step at t = 0{s}, {1 / rate:.3g}{s}"
    return f"{asked} is {step * rate:.3g} times {bound}, beyond which methods are unstable"
