"""What is said of a run: notes, for which NOTES says when they are due and in runs of which method;
states from which a run cannot go on; by how much mass, momentum, energy and entropy have departed
from their laws. All functions are collective.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from math import isqrt
from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.checks import place_text
from fsipetsc.equations.tensors import determinant
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.paper.paper_state import PaperState
from fsipetsc.scheme.conservation_check import Drifts
from fsipetsc.scheme.gas_forms import CONSERVED
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, TIME, TOO_SHORT, longest_step
from fsipetsc.state import Seen, State

Array = np.ndarray
#: Courant number beyond which steps are said to be long: the classical method, on a periodic grid,
#: is unstable beyond 1.6 to 2.8 (orders 8 to 2)
FAR = 1.5
#: the part of the larger of two pressures by which they may differ at an interface
JUMP = 0.01
#: part of its volume by which a gas may begin with more or less of it than its map says
STRETCHED = 0.01
#: part of the larger modulus K = rho dp/drho, p of a perfect gas, by which the pressures of
#: neighbouring nodes may differ
STEEP = 0.2
#: entries of F^T F - 1 below which the waves of a law are those at rest
SMALL = 0.02
#: part of the largest entry of the tensor that an eigenvalue below 0 must be more than
ROUND_OFF = 1e-8
#: entries of directions of waves, in as many dimensions, -so many … so many
FINEST = {1: 1, 2: 4, 3: 2}
#: the square of a larger number is none
TOO_LARGE = 1e150
#: fields that must be above 0; others need only be finite
POSITIVE = "rho", "T", "J", "x_X", "m0 c^2"
HELPS = (
    "what usually helps: shorter steps (-fsi_cfl or -ts_dt), a finer grid (-fsi_h); where there "
    "are shocks -fsi_coupling conservative -fsi_dissipation 1 -fsi_shock 1"
)
#: a part of the run's energy that may be round-off: of a smaller one no share is told
NOTHING = 1e-12


def asked_data(state: Any) -> list[str]:
    """Why Python is asked for data in each stage of a step."""
    why = [one for some in state.comm.allgather(state.phases.not_recorded) for one in some]
    words = "Python is asked for data in each stage of a step, which takes longer"
    return [f"{words}: {why[0]}"] if why else []


def heat_that_stays(state: Any) -> list[str]:
    """Faces with a temperature whose gas or solid does not conduct heat."""
    found = set()
    for (k, *_), met in state.problem.outer_faces.items():
        name, material = state.problem.blocks[k].name, state.problem.blocks[k].material
        conducts = material.kappa if material.kind == "fluid" else material.kappa_e
        if met.warms and not met.all_given and not conducts:
            found.add(
                f"{type(met).__name__} gives '{name}' a temperature, and it does not conduct heat: "
                "only its nodes at the face have that temperature, so results depend on the grid"
            )
    return sorted(found)


def pressure_jumps(state: Any) -> list[str]:
    """Interfaces at which the pressures of both sides differ; halos are filled."""
    problem, blocks, Pa = state.problem, state.problem.layers, state.problem.unit("Pa")
    pushes = np.zeros((len(problem.interfaces), 2, 2))  # of gas and solid: the sum, number of nodes
    for k, part in state.parts.items():
        for face, met in problem.faces_of(k).items():
            if problem.is_interface(k, *face):
                pair = (met.block, k) if part.block.kind == "solid" else (k, met.block)
                rows = part.part.rows_among(blocks[k].face_nodes(*face))
                found = part.pushes(state.y.ghosted(k), rows, *face)
                pushes[problem.interfaces.index(pair), pair.index(k)] += found.sum(), found.size
    state.comm.Allreduce(MPI.IN_PLACE, pushes)
    means = (pushes[..., 0] / pushes[..., 1]).tolist()
    return [
        f"at t = 0 '{blocks[gas].name}' has a pressure of {p:.4g}{Pa} where it meets "
        f"'{blocks[solid].name}', which pushes with {push:.4g}{Pa} (means of the interface): "
        "waves start there"
        for (gas, solid), (p, push) in zip(problem.interfaces, means, strict=True)
        if abs(p - push) > JUMP * max(abs(p), abs(push))
    ]


def stretched_gases(state: Any) -> list[str]:
    """Gases whose grids follow solids that do not begin where the gases end."""
    blocks, volumes = state.problem.layers, np.zeros((len(state.problem.layers), 2))
    for k, part in state.parts.items():
        if part.block.kind == "fluid" and part.block.exact is None:
            of_grid, of_map = state.y.owned(k)[:, 0], part.reference
            volumes[k] = part.weights @ of_grid, part.weights @ of_map
    state.comm.Allreduce(MPI.IN_PLACE, volumes)
    return [
        f"'{block.name}' begins with {100.0 * abs(volume / of_map - 1.0):.3g} % "
        f"{'more' if volume > of_map else 'less'} volume and mass than its map gives it: the first "
        "state of a solid beside it is not where it ends"
        for block, (volume, of_map) in zip(blocks, volumes.tolist(), strict=True)
        if abs(volume - of_map) > STRETCHED * of_map
    ]


def loose_forces(state: Any) -> list[str]:
    """Gases on which a constant force acts node by node."""
    found = []
    for gas in state.loose:
        keeps = "-fsi_coupling conservative" if isinstance(state, PaperState) else ""
        if not keeps and isinstance(gas.material.gas_law, CONSERVED):
            keeps = "-fsi_convection entropy"
        found.append(
            f"the force on '{gas.name}' is added node by node: a gas at rest stays so to the order "
            "of the scheme only, and small motions may grow"
            f"{f'; {keeps} keeps rest' if keeps else ''}"
        )
    return found


def steep_waves(state: Any) -> list[str]:
    """Where the pressure of a gas jumps from one node to the next, without -fsi_shock."""
    blocks, m = state.problem.layers, state.problem.unit("m")
    steepest = np.zeros((len(blocks), 1 + state.problem.dimension))  # the change, and where it is
    for k, part in () if state.shocks else state.parts.items():
        if part.block.kind == "fluid":
            at, change = part.owned, np.zeros(part.owned.size)
            with np.errstate(all="ignore"):  # corners of halos hold nothing, and are not used
                w = part.equations.primitive(tuple(state.y.ghosted(k).T))
                p, K = w[1], part.equations.law.bulk_modulus(w[0], w[2])
            sizes, stride = part.part.patch.ghosted, 1
            for size in sizes[: part.block.dimension]:
                beside = np.where(at // stride % size < size - 1, at + stride, at)
                apart = np.abs(p[beside] - p[at]) / np.maximum(K[beside], K[at])
                change, stride = np.maximum(change, apart), stride * size
            steepest[k] = change.max(), *part.X[:, at[change.argmax()]]
    every = np.array(state.comm.allgather(steepest))
    found = every[every[..., 0].argmax(axis=0), np.arange(len(blocks))]
    return [
        f"at the end the pressure in '{block.name}' changes by {100 * value:.0f} % from one node "
        f"to the next, at {place_text(X)}{m}: shocks need -fsi_shock 1 -fsi_dissipation 1"
        for block, (value, *X) in zip(blocks, found.tolist(), strict=True)
        if value > STEEP
    ]


def imaginary_waves(state: Any, t: float, told: Collection[int] = ()) -> dict[int, str]:
    """Solids, but those told of, whose waves have become imaginary at t [s], and where it is worst:
    number of the block -> text.
    """
    found = []
    for k, part in state.parts.items():
        if part.block.kind == "solid" and k not in told:
            with np.errstate(all="ignore"):  # a bad state has no stress, and is told otherwise
                rows, order, stretch = imaginary(part, state.y.ghosted(k))
            numbers = part.part.numbers[rows]
            for i in np.lexsort((numbers, order))[:1]:
                X = part.X[:, part.owned[rows[i]]].tolist()
                found.append((k, float(order[i]), int(numbers[i]), X, float(stretch[i])))
    every = sorted((one for some in state.comm.allgather(found) for one in some), reverse=True)
    worst = {k: (X, stretch) for k, _, _, X, stretch in every}
    m, when = state.problem.unit("m"), f"t = {t:.6g}{state.problem.unit('s')}"
    return {
        k: f"waves have become imaginary in '{state.problem.layers[k].name}' at "
        f"{place_text(X)}{m}, {when}, where the stretch along them is {stretch:.3g}: the law has "
        "no meaning here"
        for k, (X, stretch) in sorted(worst.items())
    }


def imaginary(part: SolidPart, q: Array) -> tuple[Array, Array, Array]:
    """Where waves are imaginary: rows, m0 c^2 below 0, the stretch along these waves.

    Waves along N are real if the acoustic tensor along N at constant entropy
    (fsipetsc.equations.solid) is positive: its leading minors are, and its eigenvalues are m0 c^2.
    Nodes with hardly any strain are left out, so that solids of small strain cost next to nothing.
    """
    part.monitor(q)
    d = part.block.dimension
    F = part.F[: d * d].T.reshape(-1, d, d)
    strain = np.abs(np.einsum("nki,nkj->nij", F, F) - np.eye(d)).max(axis=(1, 2))
    strain = np.maximum(strain, np.abs(part.F[d * d :].T - 1.0).max(axis=1, initial=0.0))
    rows = np.flatnonzero(strain > SMALL)
    strains, T, F = tuple(part.F[:, rows]), part.stressed(q, rows)[0], F[rows]
    modulus, stretch = np.zeros((2, rows.size))
    for N in _directions(d) if rows.size else ():
        Q = part.equations.acoustic_tensor(strains, T, tuple(N))
        Q = np.reshape(Q, (isqrt(len(Q)), -1, rows.size))[:d, :d]
        allowed = ROUND_OFF * np.abs(Q).max(axis=(0, 1))
        near = Q + allowed * np.eye(d)[..., None]
        minors = [determinant(tuple(near[:k, :k].reshape(k * k, -1))) for k in range(1, d + 1)]
        few = np.flatnonzero(np.min(minors, axis=0) < 0.0)
        least = np.linalg.eigvalsh(np.moveaxis(Q[..., few], -1, 0))[:, 0]
        worse = least < np.minimum(modulus[few], -allowed[few])
        few = few[worse]
        modulus[few], stretch[few] = least[worse], np.linalg.norm(F[few] @ N, axis=1)
    bad = modulus < 0.0
    return rows[bad], modulus[bad], stretch[bad]


def _directions(d: int) -> Array:
    """(m, d) unit vectors of directions of waves, one of each two that are opposite."""
    entries = range(-FINEST[d], FINEST[d] + 1)
    some = {N: np.linalg.norm(N) for N in product(entries, repeat=d) if N > (0,) * d}
    return np.unique([np.divide(N, size).round(15) for N, size in some.items()], axis=0)


def new_imaginary_waves(state: Any) -> Sequence[str]:
    """Solids whose waves have become imaginary, of which nothing was said before."""
    found = imaginary_waves(state, state.time, state.told)
    state.told.update(found)
    return [*found.values()]


#: when, of which states, what says something of them
NOTES = (
    ("begin", State, loose_forces),
    ("begin", BlockState, asked_data),
    ("begin", BlockState, heat_that_stays),
    ("begin", BlockState, stretched_gases),
    ("begin", BlockState, pressure_jumps),
    ("saved", BlockState, new_imaginary_waves),
    ("end", BlockState, steep_waves),
)


def long_steps(state: State, opt: Mapping[str, Any]) -> list[str]:
    """Steps that were asked for and are far longer than their bound."""
    rate = float(state.results[RATE])
    step = float(longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, rate))
    if not step * rate > FAR:
        return []
    s = state.problem.unit("s")
    asked = f"-ts_dt {step:g}{s}" if opt["ts_dt"] else f"-fsi_cfl {opt['fsi_cfl']:g}"
    bound = f"the bound on the step at t = 0{s}, {1 / rate:.3g}{s}"
    return [f"{asked} is {step * rate:.3g} times {bound}, beyond which methods are unstable"]


def notes(state: State, when: str, t: float = 0.0) -> list[str]:
    """What is to be said of the solution at the "begin", when it is "saved" at t [s], and at the
    "end".
    """
    state.time = t
    found = list(state.problem.notes) if when == "begin" else []
    for at, kind, say in NOTES:
        if at == when and isinstance(state, kind):
            found += say(state)
    return found


# states from which a run cannot go on


def check(state: State, t: float, step: int) -> None:
    """Raise ComputationError, or InputError of the first state, if the run cannot go on from the
    state at t [s]. Collective.
    """
    flags = state.results
    if flags[BAD] or not flags[RATE] < np.inf:
        first = first_bad(state)
        if step == 0:
            raise InputError(f"the run cannot begin: {described(state, first, t, step)}")
        state.go_back()
        begin = float(state.batch[TIME])
        waves = imaginary_waves(state, begin) if isinstance(state, BlockState) else {}
        causes = [*waves.values()] or [HELPS]
        first = state.repeat(partial(first_bad, state)) or first
        raise ComputationError("; ".join([described(state, first, t, step), *causes]))
    if flags[EXHAUSTED] or flags[TOO_SHORT]:
        when = f"t = {t:.6g}{state.problem.unit('s')}, step {step}"
        raise ComputationError(f"at {when} {state.used_up()}")


def described(state: State, first: tuple[Any, ...] | None, t: float, step: int) -> str:
    """Describe an unphysical point."""
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


# laws that must hold


class Ledgers(Drifts):
    """The largest departures of a problem's invariants, on rank 0, as records of steps come.

    The first three arguments are those of Drifts; memory: what ``kept`` was. tolerance: that of
    -fsi_check, or None; unit: what comes after a time in a message.

    departures   name -> largest relative departure of any step so far; nan if one was no number
    J_error      largest departure of J from the volume of the grid, over it; 0 if none is recorded
    energies     [J] kinetic and elastic energy of solids that all steps have lost, less what they
                 have won; the most that there was of it; the most that there was of all energy
    fault        the first departure beyond the tolerance, in words; None if there is none
    """

    def __init__(
        self,
        invariants: Mapping[str, Any],
        initial: Mapping[str, Any],
        memory: Mapping[str, Any] | None = None,
        tolerance: float | None = None,
        unit: str = " s",
    ) -> None:
        self._tolerance, self._unit, self.steps, self.J_error = tolerance, unit, 0, 0.0
        self.departures: dict[str, float] = {}
        first = (abs(initial.get(name, 0.0)) for name in ("solid_energy", "energy"))
        self.energies, self.fault = [0.0, *map(float, first)], None
        super().__init__(invariants, initial)
        vars(self).update(memory or {})

    @property
    def kept(self) -> dict[str, Any]:
        """What goes on from here, as JSON has it."""
        names = "steps", "departures", "J_error", "energies", "memory"
        return {name: getattr(self, name) for name in names}

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
        found = self.go_on({name: steps[name] for name in names})
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
        return summed / of_solids if of_solids > NOTHING * of_all else 0.0

    def _first_beyond(self, found: Mapping[str, np.ndarray], t: np.ndarray) -> str | None:
        """Return the first step, and the law, with a departure beyond the tolerance."""
        beyond = {name: ~(np.abs(drift) <= self._tolerance) for name, drift in found.items()}
        first = [(int(np.argmax(broken)), name) for name, broken in beyond.items() if broken.any()]
        if not first:
            return None
        step, name = min(first, key=lambda one: one[0])
        when = f"t = {t[step]:.6g}{self._unit}, step {self.steps + step + 1}"
        return f"{name} has drifted by {found[name][step]:.3g} (relative) at {when}"
