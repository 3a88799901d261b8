"""The command `flutter`: how a small motion of the panel grows, over dynamic pressure and Mach number, and where it begins to.

Each run of the case ``panel`` is made on one rank alone; the ranks share the runs. A run lasts a good period: the
modes are told apart by their shapes (fsipetsc.analysis.flutter_fit). Beside the lambda of each Mach number at which the growth
becomes positive stand those of quasi-steady and of potential theory (fsipetsc.analysis.flutter_theory), with the mass, the
thickness and the damping by the flow that the runs have. `flutter RUN.h5` says what the limit cycle of one run is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.cases import load_case
from fsipetsc.checks import counted
from fsipetsc.errors import ComputationError, FileError, InputError
from fsipetsc.options import Option, groups, read_options
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import agree, together, wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.analysis.flutter_fit import Motion
    from fsipetsc.analysis.flutter_table import FlutterRun, FlutterStudy

#: push of the panel, small enough that the motion is linear, where the user gives none
SMALL = 1e-5
#: periods of flutter that are looked at, samples in one, and chords that a sound wave against the flow runs before
PERIODS, SAMPLES, CHORDS = 1.25, 64, 2.0
#: frequency of the flutter of a clamped panel over sqrt(D/m)
FLUTTER = 52.0


def _above_one(values: Sequence[float]) -> str | None:
    return None if values and min(values) > 1 else "Mach numbers above 1"


def _positive(values: Sequence[float]) -> str | None:
    return None if values and min(values) > 0 else "numbers above 0"


OPTIONS = (
    Option("flutter_machs", "floats", (1.5, 2.0, 2.5, 3.0, 4.0), "", "Mach numbers, instead of -panel_mach", check=_above_one),
    Option(
        *("flutter_lambdas", "floats", (500.0, 600.0, 700.0, 800.0), "", "dynamic pressures, instead of -panel_lambda"),
        check=_positive,
    ),
)


def flutter(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm.

    Raises InputError; ComputationError at the end if a run has failed, or where a result has no limit cycle; FileError.
    """
    from fsipetsc.analysis.flutter_table import FlutterStudy

    if _result(arguments):
        from fsipetsc.analysis.flutter_cycles import report

        together(comm, lambda: None if comm.rank else print(report(arguments[0]), flush=True))
        return
    case = load_case("panel")
    given = start_petsc(arguments, comm)
    from fsipetsc.stepping.solve import check_begin  # PETSc has been started

    opt = read_options(case, given, OPTIONS)
    check_begin(opt)
    for name, instead in (("panel_mach", "flutter_machs"), ("panel_lambda", "flutter_lambdas")):
        if name in given:
            raise InputError(f"-{name} is for a single run; the command flutter takes -{instead}, a list")
    if "panel_push" not in given:
        opt["panel_push"] = SMALL
    path = _target(opt, "fsi_output" in given)
    machs, dynamics = (tuple(sorted(set(opt[name]))) for name in ("flutter_machs", "flutter_lambdas"))
    say = (lambda text: None) if opt["fsi_quiet"] or comm.rank else (lambda text: print(text, flush=True))
    runs = [(M, dynamic) for M, dynamic in product(machs, dynamics)]
    say(f"{counted(len(runs), 'run')} of panel on {counted(comm.size, 'rank')}, h = {opt['fsi_h']:g}, order {opt['fsi_order']}")
    end = opt["ts_max_time"] if "ts_max_time" in given else None
    study = FlutterStudy(opt["panel_mass"], opt["panel_thickness"], tuple(_all_runs(case, opt, runs, end, comm, say)))
    say("\n" + study.table())
    if comm.rank == 0:
        files = [study.save(path), *_pictures(study, path)]
        say("\nresults in " + ", ".join(map(str, files)))
    wait_asleep(comm)
    failures = [run for run in study.runs if run.failure]
    if failures:
        first = f"M = {failures[0].mach:g}, lambda = {failures[0].dynamic:g}: {failures[0].failure}"
        raise ComputationError(f"{len(failures)} of {counted(len(runs), 'run')} failed; {first}")


def _result(arguments: Sequence[str]) -> bool:
    """Whether a result is to be looked at. InputError for anything behind it."""
    if not arguments or arguments[0].startswith("-"):
        return False
    words = [word for word in arguments[1:] if word != "-fsi_debug"]
    if words:
        raise InputError(f"the command flutter takes one result file alone, or options: {words[0]} is too much")
    return True


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help."""
    return groups(load_case("panel"), OPTIONS)


def _target(opt: Mapping[str, Any], named: bool) -> Path:
    """The CSV file of the table. FileError."""
    path = Path(opt["fsi_output"] if named else "flutter.csv").with_suffix(".csv")
    if not path.parent.is_dir() or path.is_dir():
        raise FileError(f"{path}: " + ("is a directory" if path.is_dir() else f"no directory {path.parent}"))
    return path


def _pictures(study: FlutterStudy, path: Path) -> list[Path]:
    from fsipetsc.output.plots.flutter import flutter_figure

    return flutter_figure(study, path.with_suffix(".png"))


def _all_runs(
    case: Any, opt: dict[str, Any], runs: Sequence[tuple[float, float]], end: float | None, comm: MPI.Comm, say: Any
) -> list[FlutterRun]:
    """All of them, on all ranks; each rank makes its share. Collective."""
    together(comm, lambda: None if comm.rank else _compile(case, opt, say))  # once, and not on each rank
    mine, fault = [], None
    try:
        mine = [one_run(case, opt, M, dynamic, end) for M, dynamic in runs[comm.rank :: comm.size]]
    except InputError as error:
        fault = error
    agree(comm, fault)
    shares = comm.allgather(mine)
    return [shares[i % comm.size][i // comm.size] for i in range(len(runs))]


def _compile(case: Any, opt: dict[str, Any], say: Any) -> None:
    from mpi4py import MPI

    from fsipetsc.stepping.solve import build_problem, make_state

    with make_state(build_problem(case, opt, MPI.COMM_SELF), dict(opt), MPI.COMM_SELF) as state:
        state.compile(say)


def one_run(case: Any, opt: Mapping[str, Any], mach: float, dynamic: float, end: float | None = None) -> FlutterRun:
    """The modes of the panel at a Mach number and a lambda = dynamic, from a run on this rank alone, up to the time end, or of
    a good period. InputError.
    """
    from fsipetsc.analysis.flutter_fit import fit_modes
    from fsipetsc.analysis.flutter_table import FlutterRun
    from fsipetsc.analysis.flutter_theory import Flow

    flow = Flow(mach, opt["panel_mass"], opt["panel_thickness"])
    period = 2.0 * np.pi / (FLUTTER * flow.unit(dynamic))
    begin = CHORDS / (mach - 1.0)
    if end is None:
        end = begin + PERIODS * period
    own = {**opt, "panel_mach": mach, "panel_lambda": dynamic, "ts_max_time": end}
    motion, outcome, failure = None, None, ""
    try:
        motion, outcome = observe(case, own, np.arange(0.0, end, period / SAMPLES))
        modes = fit_modes(motion.after(begin))
        pair = tuple(complex(s) for s in modes.pair)
        return FlutterRun(mach, dynamic, pair, modes.misfit, outcome.steps, outcome.wall_time)
    except ComputationError as error:
        failure = str(error)
    return FlutterRun(mach, dynamic, failure=failure)


def observe(case: Any, opt: dict[str, Any], times: Sequence[float]) -> tuple[Motion, Any]:
    """(motion of the panel's middle row at these times, outcome of the run). On this rank alone.

    InputError, ComputationError.
    """
    from mpi4py import MPI

    from fsipetsc.analysis.flutter_fit import Motion
    from fsipetsc.stepping.solve import solve

    frames: list[tuple[float, np.ndarray, np.ndarray]] = []

    def look(state: Any, t: float) -> None:
        k = next(k for k, layer in enumerate(state.problem.layers) if layer.kind == "solid")
        columns, rows = state.problem.layers[k].shape
        middle = state.y.owned(k).reshape(rows, columns, -1)[rows // 2]  # displacement, velocity, energy
        frames.append((t, middle[:, 1].copy(), middle[:, 3].copy()))

    outcome = solve(case, dict(opt), MPI.COMM_SELF, times=times, look=look)
    wanted = [frame for frame in frames if np.min(np.abs(np.asarray(times) - frame[0])) < 1e-9 * max(1.0, frame[0])]
    return Motion(*(np.array(part) for part in zip(*wanted, strict=True))), outcome
