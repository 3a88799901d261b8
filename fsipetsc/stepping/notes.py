"""What is said of a run: notes, by the table at the end; states from which a run cannot go on; by
how much mass, momentum, energy and entropy depart from their laws. All but the last are collective.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import product
from math import isqrt
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import Array, place_text
from fsipetsc.equations.tensors import determinant
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.scheme.observables import drifts
from fsipetsc.scheme.plan import BAD, OFF_GRID, RATE, TIME, longest_step
from fsipetsc.state import State
from fsipetsc.stepping.block_state import BlockState
from fsipetsc.stepping.parts import SolidPart

#: Courant number beyond which steps are said to be long: the classical method, on a periodic grid,
#: is unstable beyond 1.6 to 2.8 (orders 8 to 2)
FAR = 1.5
#: part of the larger modulus K = rho dp/drho, p of a perfect gas, by which the pressures of
#: neighbouring nodes may differ
STEEP = 0.2
#: entries of F - 1 below which the waves of a law are those at rest
SMALL = 0.01
#: what a minor of an acoustic tensor, over its largest entry, must be below
ROUND_OFF = 1e-8
#: entries of directions of waves, in as many dimensions, -so many … so many
FINEST = {1: 1, 2: 4, 3: 2}
#: the square of a larger number is none
TOO_LARGE = 1e150
#: fields that must be above 0; others need only be finite
POSITIVE = "rho", "T", "J", "x_X", "m0 c^2 of waves"
#: a part of the run's energy that may be round-off: of a smaller one no share is told
NOTHING = 1e-12


class Moment(NamedTuple):
    """What notes are of: a state at t [s], options; told: solids told of as beyond their law."""

    state: State
    opt: Mapping[str, Any]
    t: float
    told: set[int]


def python_is_asked(now: Moment) -> list[str]:
    asked = "Python is asked for data in each stage of a step, which takes longer: "
    return [asked + why for why in now.state.not_recorded[:1]]


def heat_stays(now: Moment) -> list[str]:
    stays, problem = set(), now.state.problem
    for (k, *_), met in problem.outer_faces.items() if isinstance(now.state, BlockState) else ():
        name, material = problem.blocks[k].name, problem.blocks[k].material
        conducts = material.kappa if material.kind == "fluid" else material.kappa_e
        if (met.warms or met.heat_flux not in (None, 0.0)) and not conducts:
            stays.add(
                f"{type(met).__name__} gives '{name}' a temperature or heat, and it conducts none: "
                "only its nodes at the face get it, so results depend on the grid"
            )
    return sorted(stays)


def steep_waves(now: Moment) -> list[str]:
    """Gases in which the pressure jumps from one node to the next, without -fsi_shock."""
    state = now.state
    if now.opt["fsi_shock"] or not isinstance(state, BlockState):
        return []
    steepest = np.zeros((len(state.problem.blocks), 1 + state.problem.dimension))  # and where
    for k, part in state.parts.items():
        if part.block.kind == "fluid":
            steepest[k] = part.steepest(state.ghosted(k))
    every = np.array(state.comm.allgather(steepest))
    found = every[every[..., 0].argmax(axis=0), np.arange(len(steepest))]
    m = state.problem.unit("m")
    return [
        f"at the end the pressure in '{block.name}' changes by {100 * value:.0f} % from one node "
        f"to the next, at {place_text(X)}{m}: shocks need -fsi_shock 1 -fsi_dissipation 1"
        for block, (value, *X) in zip(state.problem.blocks, found.tolist(), strict=True)
        if value > STEEP
    ]


def long_steps(now: Moment) -> list[str]:
    """Steps that were asked for and are far longer than their bound."""
    state, opt, t, _ = now
    rate = float(state.results[RATE])
    step = float(longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, rate))
    if not step * rate > FAR:
        return []
    s = state.problem.unit("s")
    asked = f"-ts_dt {step:g}{s}" if opt["ts_dt"] else f"-fsi_cfl {opt['fsi_cfl']:g}"
    bound = f"the bound on the step at t = {t:g}{s}, {1 / rate:.3g}{s}"
    return [f"{asked} is {step * rate:.3g} times {bound}, and few methods are stable far beyond it"]


def imaginary_waves(now: Moment) -> list[str]:
    """Solids, but those told of, whose waves are imaginary."""
    found, (state, _, t, told) = [], now
    for k, part in state.parts.items() if isinstance(state, BlockState) else ():
        if part.block.kind == "solid" and k not in told:
            with np.errstate(all="ignore"):  # a bad state has no stress, and is told otherwise
                found += [(k, *one) for one in worst_waves(part, state.ghosted(k))]
    every = [one for of_rank in state.comm.allgather(found) for one in of_rank]
    worst = {one[0]: one[3:] for one in sorted(every, reverse=True)}  # the worst comes last
    told.update(worst)
    m, when = state.problem.unit("m"), f"t = {t:.6g}{state.problem.unit('s')}"
    return [
        f"waves have become imaginary in '{state.problem.layers[k].name}' at "
        f"{place_text(X)}{m}, {when}, where the stretch along them is {stretch:.3g}: the law has "
        "no meaning here"
        for k, (X, stretch) in sorted(worst.items())
    ]


def worst_waves(part: SolidPart, q: Array) -> list[tuple[float, int, list[float], float]]:
    """Where waves are imaginary, the worst of each direction: how bad, node, X, stretch along it.

    Waves along N are real if the acoustic tensor along N at constant entropy
    (fsipetsc.equations.elasticity) is positive, so that all its leading minors are. Nodes with
    hardly any strain are left out, so that solids of small strain cost next to nothing.
    """
    part.measure(q)
    d, found = part.block.dimension, []
    rest = np.append(np.eye(d), np.ones(len(part.F) - d * d))  # the last ones are of hoops
    rows = np.flatnonzero(np.abs(part.F.T - rest).max(axis=1) > SMALL)
    F = part.F[: d * d].T.reshape(-1, d, d)
    strains, T, numbers = tuple(part.F[:, rows]), part.stressed(q, rows)[0], part.numbers[rows]
    entries = range(-FINEST[d], FINEST[d] + 1)
    some = [N / np.linalg.norm(N) for N in product(entries, repeat=d) if N > (0,) * d]
    for N in np.unique(np.round(some, 15), axis=0) if rows.size else ():
        Q = np.array(part.laws.acoustic_tensor(strains, T, tuple(N)))
        Q = Q.reshape(isqrt(len(Q)), -1, rows.size)[:d, :d]
        size = np.abs(Q).max(axis=(0, 1))
        Q = Q / size + ROUND_OFF * np.eye(d)[..., None]
        minors = [determinant(tuple(Q[:k, :k].reshape(k * k, -1))) for k in range(1, d + 1)]
        least = size * np.min(minors, axis=0)
        i = np.lexsort((numbers, least))[0]  # what is no number comes last
        if least[i] < 0.0:
            X, stretch = part.X[:, part.owned[rows[i]]], np.linalg.norm(F[rows[i]] @ N)
            found.append((float(least[i]), int(numbers[i]), X.tolist(), float(stretch)))
    return found


def help_with(opt: Mapping[str, Any]) -> str:
    """What usually helps a run that fails, beside the options that are in force."""
    steps = "shorter steps " + ("(-ts_dt)" if opt["ts_dt"] else "(-fsi_cfl or -ts_dt)")
    more = " -fsi_coupling conservative" * (opt["fsi_coupling"] != "conservative")
    more += " -fsi_dissipation 1" * (opt["fsi_dissipation"] <= 0)
    more += " -fsi_shock 1" * (not opt["fsi_shock"])
    at_shocks = f"; where there are shocks{more}" if more else ""
    return f"what usually helps: {steps}, a finer grid (-fsi_h){at_shocks}"


def check(state: State, opt: Mapping[str, Any], t: float, step: int) -> None:
    """ComputationError, at first InputError, if the run cannot go on from the state at t [s]."""
    flags, when = state.results, f"t = {t:.6g}{state.problem.unit('s')}, step {step}"
    if flags[BAD] or not flags[RATE] < np.inf:
        first = first_bad(state) or "the time step is not a number"
        if step == 0:
            raise InputError(f"the run cannot begin: {first}, {when}")
        state.go_back()
        waves = imaginary_waves(Moment(state, opt, float(state.batch[TIME]), set()))
        first = state.repeat(partial(first_bad, state)) or first
        raise ComputationError("; ".join([f"{first}, {when}", *(waves or [help_with(opt)])]))
    if flags[OFF_GRID]:
        raise ComputationError(f"at {when} {state.used_up()}")


def first_bad(state: State) -> str:
    """Describe the first point of all ranks that is not physical, or too large; "" if none is."""
    bad, m = [], state.problem.unit("m")
    for k, numbers, fields, x, X in state.seen():
        for order, (name, values) in enumerate(fields.items()):
            with np.errstate(all="ignore"):
                good = (np.abs(values) < TOO_LARGE) & ((values > 0) | (name not in POSITIVE))
            for i in np.flatnonzero(~good)[:1].tolist():
                v = values[i]
                number = f"= {v:.6g}" if np.isfinite(v) else "is not a finite number"
                where = f"{place_text(x[i], 'xyz')}{m}, {place_text(X[i])}{m}"
                text = f"{name} {number} in layer '{state.problem.layers[k].name}' at {where}"
                bad.append((k, int(numbers[i]), order, text))
    return min((one for some in state.comm.allgather(bad) for one in some), default=("",))[-1]


def of_laws(
    series: Mapping[str, Array], laws: Mapping[str, Any], initial: Mapping[str, Any]
) -> dict[str, Any]:
    """What the summary says of all steps. departures: name -> largest relative departure from a
    law; initial: the integrals before the first step. J_error: on blocks the largest departure of J
    from the volume of the grid, over it. lost_energy: the share of their largest kinetic and
    elastic energy that solids have lost to the steps. What is no number stays nan.
    """
    departures = {k: float(np.abs(of).max()) for k, of in drifts(laws, initial, series).items()}
    found: dict[str, Any] = {"departures": departures}
    if "J_error" in series:
        found["J_error"] = float(np.max(series["J_error"]))
    if "solid_energy" in initial:
        of_solids, of_all = (
            float(np.max(np.abs(series.get(name, 0.0)), initial=abs(initial[name])))
            for name in ("solid_energy", "energy")
        )
        lost = float(np.sum(series.get("lost_energy", 0.0)))
        found["lost_energy"] = lost / of_solids if of_solids > NOTHING * of_all else 0.0
    return found


BEGIN, FRAME, END = "a run begins", "a frame is saved", "a run ends"
#: when something is looked for, and what, if it is there, is said of it
NOTES: Mapping[str, tuple[Callable[[Moment], Sequence[str]], ...]] = {
    BEGIN: (lambda now: now.state.problem.notes, python_is_asked, heat_stays, long_steps),
    FRAME: (imaginary_waves,),
    END: (steep_waves,),
}


def notes(when: str, now: Moment) -> list[str]:
    """What is to be said at a moment."""
    return [text for look in NOTES[when] for text in look(now)]
