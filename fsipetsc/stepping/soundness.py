"""Whether a run can go on: states that are not physical, steps that are too long, and by how much
mass, momentum, energy and entropy have departed from their laws.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from fsipetsc.errors import ComputationError, InputError
from fsipetsc.scheme.conservation_check import Drifts
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, TOO_SHORT, longest_step
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
#: a part of the run's energy that may be round-off: of a smaller one no share is told
ROUND_OFF = 1e-12


def check(state: State, t: float, step: int, flags: Sequence[float], beyond: str) -> None:
    """Raise ComputationError, or InputError of the first state, if the state at t [s] cannot be
    gone on from. Collective.

    flags: flags and limits of the step; beyond: what ``beyond_bound`` said.
    """
    if flags[BAD] or not flags[RATE] < np.inf:
        cause = state.go_to_fault(partial(first_bad, state))
        if step == 0:
            raise InputError(f"the run cannot begin: {described(state, t, step)}")
        about = described(state, t, step), beyond
        raise ComputationError("; ".join(filter(None, (*about, cause or HELPS))))
    if flags[EXHAUSTED] or flags[TOO_SHORT]:
        when = f"t = {t:.6g}{state.problem.unit('s')}, step {step}"
        raise ComputationError(f"at {when} {state.used_up()}")


def described(state: State, t: float, step: int) -> str:
    """Describe the first unphysical point of all ranks. Collective."""
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
    """Return what ``_bad_points`` says of the first one of all ranks, if any. Collective."""
    with np.errstate(all="ignore"):
        bad = [found for seen in state.seen() for found in _bad_points(seen)]
    return min((found for some in state.comm.allgather(bad) for found in some), default=None)


def _bad_points(seen: Seen) -> Iterator[tuple[Any, ...]]:
    """Yield of each field the first point that is not physical, or with numbers whose squares are
    none: (layer, number of the point, number of the field, field, value, x, X).
    """
    for number, (name, values) in enumerate(seen.values.items()):
        good = (np.abs(values) < TOO_LARGE) & ((values > 0) | (name not in POSITIVE))
        if not good.all():
            i = int(np.argmin(good))
            about = number, name, float(values[i]), seen.x[i].tolist(), seen.X[i].tolist()
            yield seen.layer, int(seen.numbers[i]), *about


def beyond_bound(state: State, opt: Mapping[str, Any]) -> str:
    """Return by how much the steps that were asked for exceed their bound; "" if not by far."""
    rate = float(state.results[RATE])
    step = longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, rate)
    if not step * rate > FAR:
        return ""
    s = state.problem.unit("s")
    asked = f"-ts_dt {step:g}{s}" if opt["ts_dt"] else f"-fsi_cfl {opt['fsi_cfl']:g}"
    bound = f"the bound on the step at t = 0{s}, {1 / rate:.3g}{s}"
    return f"{asked} is {step * rate:.3g} times {bound}, beyond which methods are unstable"


class Ledgers:
    """The largest departures of a problem's invariants, on rank 0, as records of steps come.

    invariants: see fsipetsc.scheme.conservation_check.Drifts. tolerance: that of -fsi_check, or
    None; unit: what comes after a time in a message.

    departures   name -> largest relative departure of any step so far; nan if one was no number
    J_error      largest departure of J from the volume of the grid, over it; 0 if none is recorded
    energies     [J] kinetic and elastic energy of solids that all steps have lost, less what they
                 have won; the most that there was of it; the most that there was of all energy
    fault        the first departure beyond the tolerance, in words; None if there is none
    """

    def __init__(
        self, invariants: Mapping[str, Any], tolerance: float | None = None, unit: str = " s"
    ) -> None:
        self._invariants, self._tolerance, self._unit = invariants, tolerance, unit
        self.steps, self.J_error = 0, 0.0
        self.departures: dict[str, float] = {}
        self.energies = [0.0, 0.0, 0.0]
        self.fault: str | None = None

    def begin(self, initial: Mapping[str, Any], memory: Mapping[str, Any] | None = None) -> None:
        """initial: the integrals at the beginning of the run. memory: of the steps before."""
        memory = dict(memory or {})
        first = (abs(initial.get(name, 0.0)) for name in ("solid_energy", "energy"))
        self.energies[1:] = map(float, first)
        self._drifts = Drifts(self._invariants, initial, memory.pop("drifts", None))
        vars(self).update(memory)

    def memory(self) -> dict[str, Any]:
        """Return what ``begin`` takes to go on from here, as JSON has it."""
        kept = ("steps", "departures", "J_error", "energies")
        return {"drifts": self._drifts.memory, **{name: getattr(self, name) for name in kept}}

    def add(self, steps: np.ndarray) -> None:
        """Take the records of some more steps, with the sums over all ranks."""
        if not len(steps):
            return
        names = steps.dtype.names
        if "J_error" in names:
            self.J_error = float(np.maximum(self.J_error, steps["J_error"].max()))
        if "lost_energy" in names:  # step by step: the same sum however steps are cut
            self.energies[0] = float(np.cumsum([self.energies[0], *steps["lost_energy"]])[-1])
            for k, name in enumerate(("solid_energy", "energy"), start=1):
                self.energies[k] = float(np.maximum(self.energies[k], np.abs(steps[name]).max()))
        found = self._drifts.go_on({name: steps[name] for name in names})
        for name, drift in found.items():  # np.maximum: what is no number is larger than all
            largest = np.maximum(self.departures.get(name, 0.0), np.abs(drift).max())
            self.departures[name] = float(largest)
        if self._tolerance is not None and self.fault is None:
            self.fault = self._first_beyond(found, steps["t"])
        self.steps += len(steps)

    @property
    def lost(self) -> float:
        """Return the share of their largest energy that solids have lost to the steps."""
        summed, of_solids, of_all = self.energies
        return summed / of_solids if of_solids > ROUND_OFF * of_all else 0.0

    def _first_beyond(self, found: Mapping[str, np.ndarray], t: np.ndarray) -> str | None:
        """Return the first step, and the law, with a departure beyond the tolerance."""
        beyond = {name: ~(np.abs(drift) <= self._tolerance) for name, drift in found.items()}
        first = [(int(np.argmax(broken)), name) for name, broken in beyond.items() if broken.any()]
        if not first:
            return None
        step, name = min(first, key=lambda one: one[0])
        when = f"t = {t[step]:.6g}{self._unit}, step {self.steps + step + 1}"
        return f"{name} has drifted by {found[name][step]:.3g} (relative) at {when}"
