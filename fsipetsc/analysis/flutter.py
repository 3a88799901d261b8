"""The command `flutter`: how a small motion of the panel grows, over dynamic pressure and Mach number, and where it begins to.

Each run of the case ``panel`` is made on one rank alone; the ranks share the runs. A run lasts a good period: the
modes are told apart by their shapes (fsipetsc.analysis.flutter_motion). Beside the lambda of each Mach number at which the
growth becomes positive stand those of quasi-steady and of potential theory (fsipetsc.analysis.flutter_theory), with the mass,
the thickness and the damping by the flow that the runs have. `flutter RUN.h5` says what the limit cycle of one run is.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.analysis.flutter_motion import crossing, fit_modes, limit_cycle, motion_of
from fsipetsc.analysis.tables import csv_target, printer, save_csv, shared, text_table
from fsipetsc.cases import load_case
from fsipetsc.checks import counted
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.options import Option, groups, read_options
from fsipetsc.output.reader import open_run
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import together, wait_asleep

if TYPE_CHECKING:
    from mpi4py import MPI

#: push of the panel, small enough that the motion is linear, where the user gives none
SMALL = 1e-5
#: periods of flutter that are looked at, samples in one, and chords that a sound wave against the flow runs before
PERIODS, SAMPLES, CHORDS = 1.25, 64, 2.0
NO = complex("nan")
#: columns of the table: the faster mode, and both by frequency
HEAD = ("mach", "lambda", "growth", "frequency", "growth_1", "frequency_1", "growth_2", "frequency_2")
HEAD += ("misfit", "steps", "wall_s", "failure")


def _above_one(values: Sequence[float]) -> str | None:
    return None if values and min(values) > 1 else "Mach numbers above 1"


_DYNAMIC = "dynamic pressures, instead of -panel_lambda"
OPTIONS = (
    Option("flutter_machs", "floats", (1.5, 2.0, 2.5, 3.0, 4.0), "", "Mach numbers, instead of -panel_mach", check=_above_one),
    Option("flutter_lambdas", "floats", (500.0, 600.0, 700.0, 800.0), "", _DYNAMIC, check="positive"),
)


@dataclass(frozen=True)
class FlutterRun:
    """A run: Mach number, lambda, s of the two modes that meet [unit of velocity over the panel's length], misfit of the modes;
    steps and wall time [s]. failure: why there are none of these.
    """

    mach: float
    dynamic: float
    pair: tuple[complex, complex] = (NO, NO)
    misfit: float = float("nan")
    steps: int = 0
    wall_time: float = 0.0
    failure: str = ""

    @property
    def fastest(self) -> complex:
        """The s of the two whose growth is larger."""
        return max(self.pair, key=lambda s: s.real)


def flutter(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm.

    Raises InputError; ComputationError at the end if a run has failed, or where a result has no limit cycle; FileError.
    """
    if arguments and not arguments[0].startswith("-"):
        words = [word for word in arguments[1:] if word != "-fsi_debug"]
        if words:
            raise InputError(f"the command flutter takes one result file alone, or options: {words[0]} is too much")
        together(comm, lambda: None if comm.rank else print(report(arguments[0]), flush=True))
        return
    case = load_case("panel")
    given = start_petsc(arguments, comm)
    from fsipetsc.analysis.flutter_theory import CRITICAL
    from fsipetsc.output.plots.studies import flutter_figure
    from fsipetsc.stepping.solve import build_problem, check_begin, make_state  # PETSc has been started

    opt = read_options(case, given, OPTIONS)
    check_begin(opt)
    for name, instead in (("panel_mach", "flutter_machs"), ("panel_lambda", "flutter_lambdas")):
        if name in given:
            raise InputError(f"-{name} is for a single run; the command flutter takes -{instead}, a list")
    if "panel_push" not in given:
        opt["panel_push"] = SMALL
    path, say = csv_target(opt["fsi_output"] if "fsi_output" in given else "flutter"), printer(comm, opt)
    tasks = list(product(*(sorted(set(opt[name])) for name in ("flutter_machs", "flutter_lambdas"))))
    say(f"{counted(len(tasks), 'run')} of panel on {counted(comm.size, 'rank')}, h = {opt['fsi_h']:g}")

    def compile_once() -> None:
        from mpi4py import MPI

        with make_state(build_problem(case, opt, MPI.COMM_SELF), dict(opt), MPI.COMM_SELF) as state:
            state.compile(say)

    together(comm, lambda: None if comm.rank else compile_once())
    end = opt["ts_max_time"] if "ts_max_time" in given else None
    runs = shared(comm, tasks, lambda task: one_run(case, opt, *task, end))
    mass, thickness, lines = opt["panel_mass"], opt["panel_thickness"], rows(runs)
    facts = f"mass {mass:g}, thickness {thickness:g}"
    say(f"\npanel, {facts}: growth and angular frequency of its modes\n\n{text_table(HEAD, lines)}")
    say("\nonset of flutter: lambda, frequency f in cycles per unit of time; theory with the mass and the flow's damping")
    say(onset_table(runs, mass, thickness))
    if comm.rank == 0:
        figures = flutter_figure(curves(runs, mass), CRITICAL, facts, path.with_suffix(".png"))
        say("\nresults in " + ", ".join(map(str, [save_csv(path, HEAD, lines), *figures])))
    wait_asleep(comm)
    failures = [run for run in runs if run.failure]
    if failures:
        first = f"M = {failures[0].mach:g}, lambda = {failures[0].dynamic:g}: {failures[0].failure}"
        raise ComputationError(f"{len(failures)} of {counted(len(runs), 'run')} failed; {first}")


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help."""
    return groups(load_case("panel"), OPTIONS)


def one_run(case: Any, opt: Mapping[str, Any], mach: float, dynamic: float, end: float | None = None) -> FlutterRun:
    """The modes of the panel at a Mach number and a lambda = dynamic, from a run on this rank alone, up to the time end, or of
    a good period. InputError, FileError.
    """
    from mpi4py import MPI

    from fsipetsc.analysis.flutter_theory import Flow
    from fsipetsc.stepping.run import run_case

    period = Flow(mach, opt["panel_mass"], opt["panel_thickness"]).period(dynamic)
    begin = CHORDS / (mach - 1.0)
    with tempfile.TemporaryDirectory() as folder:
        own = {**opt, "panel_mach": mach, "panel_lambda": dynamic, "ts_max_time": end or begin + PERIODS * period}
        own |= {"fsi_output": f"{folder}/panel.h5", "fsi_output_dt": period / SAMPLES, "fsi_output_times": None}
        try:
            run_case(case, {**own, "fsi_quiet": True}, MPI.COMM_SELF)
            with open_run(own["fsi_output"]) as run:
                motion, summary = motion_of(run)[0], run.summary
            s, misfit = fit_modes(motion.after(begin))
        except ComputationError as error:
            return FlutterRun(mach, dynamic, failure=str(error))
    return FlutterRun(mach, dynamic, (complex(s[0]), complex(s[1])), misfit, summary["steps"], summary["wall_time"])


def good_runs(runs: Sequence[FlutterRun]) -> dict[float, list[FlutterRun]]:
    """Mach number -> its runs that went well."""
    return {mach: [run for run in runs if run.mach == mach and not run.failure] for mach in {run.mach: 0 for run in runs}}


def rows(runs: Sequence[FlutterRun]) -> list[list[object]]:
    """A line for each run, under HEAD."""
    lines: list[list[object]] = []
    for run in runs:
        both = [f"{x:.6g}" for s in (run.fastest, *run.pair) for x in (s.real, s.imag)]
        cost = [f"{run.misfit:.1e}", run.steps, f"{run.wall_time:.3g}"]
        lines.append([f"{run.mach:g}", f"{run.dynamic:g}", *both, *cost, run.failure])
    return lines


def onset_table(runs: Sequence[FlutterRun], mass: float, thickness: float) -> str:
    """A line for each Mach number: by the runs, NaN where they do not show it, and by theories; thick: with shear and rotary
    inertia.
    """
    from fsipetsc.analysis.flutter_theory import CRITICAL, Flow

    head = ["M", "lambda", "f", f"of {CRITICAL}", "quasi-\nsteady", "potential", "potential,\nthick", "\nf"]
    rows = []
    for mach, own in good_runs(runs).items():
        thin, thick = Flow(mach, mass), Flow(mach, mass, thickness)
        found, s = float("nan"), NO
        if len(own) > 1:
            dynamic = [run.dynamic for run in own]
            found, s = crossing(dynamic, [thin.unit(d) for d in dynamic], [run.pair for run in own])
        f = s.imag * thin.unit(found) / (2.0 * np.pi)
        theories = [flow.onset(theory) for flow, theory in ((thin, "quasi-steady"), (thin, "potential"), (thick, "potential"))]
        numbers = [f"{found:.1f}", f"{f:.4f}", f"{found / CRITICAL:.3f}", *(f"{value:.1f}" for value, _ in theories)]
        rows.append([f"{mach:g}", *numbers, f"{theories[2][1].imag / (2.0 * np.pi):.4f}"])
    return text_table(head, rows)


def curves(runs: Sequence[FlutterRun], mass: float) -> list[Any]:
    """What the picture shows: runs, and a thin panel in quasi-steady flow."""
    from fsipetsc.analysis.flutter_theory import Flow
    from fsipetsc.output.plots.studies import Curves

    found = []
    for mach, own in good_runs(runs).items():
        if own:
            flow, dynamic = Flow(mach, mass), np.array([run.dynamic for run in own])
            s = np.array([np.array(run.pair) / flow.unit(run.dynamic) for run in own])
            fine = np.linspace(dynamic[0], dynamic[-1], 201)
            found.append(Curves(mach, dynamic, s, fine, np.array([flow.quasi_steady(d)[:2] / flow.unit(d) for d in fine])))
    return found


def report(path: str) -> str:
    """What the second half of a result says, and the theory beside it, in lines. InputError, FileError; ComputationError where
    there are not two periods.
    """
    from fsipetsc.analysis.flutter_theory import Flow, von_karman

    with open_run(path) as run:
        motion, X = motion_of(run)
        found, opt = limit_cycle(motion.after(0.5 * motion.t[-1]), X), run.options
    h = opt.get("panel_thickness", float("nan"))
    lines = [
        f"{path}: the last {found.periods} periods, at X = {found.X:.4g}, where the panel moves most",
        f"amplitude {found.amplitude:.5g} = {found.amplitude / h:.3g} thicknesses about {found.mean:.2g}; frequency "
        f"{found.frequency:.5g}; their maxima differ by {100 * found.spread:.2g} % of the amplitude",
    ]
    if run.case == "panel":
        flow, dynamic = Flow(opt["panel_mach"], opt["panel_mass"], h), opt["panel_lambda"]
        if flow.quasi_steady(dynamic)[:2].real.max() > 0.0:
            theory = limit_cycle(*von_karman(flow, dynamic, h, *(n * flow.period(dynamic) for n in (40.0, 60.0))))
            lines.append(
                f"von Karman's panel in quasi-steady flow: amplitude {theory.amplitude:.5g} = {theory.amplitude / h:.3g} "
                f"thicknesses; frequency {theory.frequency:.5g}"
            )
    return "\n".join(lines)
