"""The command `flutter`: how a small motion of the panel grows, and where it begins to.

Each run of the case ``panel`` is made on one rank alone; the ranks share the runs. A run lasts a
good period: the modes are told apart by their shapes (fsipetsc.studies.panel_modes). The result
is the lambda of each Mach number at which the growth becomes positive.
"""

import tempfile
from collections.abc import Mapping, Sequence
from itertools import product
from math import ceil, pi
from typing import Any

from fsipetsc.cases import load_case
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.options import Option, groups
from fsipetsc.output.reader import open_run
from fsipetsc.process.together import Comm
from fsipetsc.studies.panel_modes import crossing, fit_modes, motion_of, unit_of
from fsipetsc.studies.tables import begin, printer, save_csv, shared, text_table

#: lambda at which a thin panel flutters without damping, its frequency there over sqrt(D/m)
CRITICAL = {"clamped": 636.57, "hinged": 343.36}
FREQUENCY = {"clamped": 52.0, "hinged": 32.0}
#: push of the panel, small enough that the motion is linear, where the user gives none
SMALL = 1e-5
#: periods that are looked at, samples in one, and chords that sound runs against the flow before
PERIODS, SAMPLES, CHORDS = 1.25, 64, 2.0
#: columns of the table: the faster mode, and both by frequency
HEAD = "mach lambda growth frequency growth_1 frequency_1 growth_2 frequency_2 misfit".split()
MACHS, LAMBDAS = (1.5, 2.0, 2.5, 3.0, 4.0), (500.0, 600.0, 700.0, 800.0)
_ABOVE = {"check": lambda values: None if min(values) > 1 else "Mach numbers above 1"}
OPTIONS = (
    Option("flutter_machs", "floats", MACHS, "", "instead of -panel_mach", **_ABOVE),
    Option("flutter_lambdas", "floats", LAMBDAS, "", "instead of -panel_lambda", check="positive"),
)
CASE = load_case("panel")
#: heading -> options for -help
SECTIONS = groups(CASE, OPTIONS)

#: a run: Mach number, lambda, s of the two modes that meet [unit of velocity over the panel's
#: length], misfit of the modes
FlutterRun = tuple[float, float, tuple[complex, complex], float]


def flutter(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; FileError; ComputationError.
    """
    instead = {"panel_mach": "flutter_machs", "panel_lambda": "flutter_lambdas"}
    opt, given, path = begin(CASE, arguments, comm, OPTIONS, "flutter", instead)
    if "panel_push" not in given:
        opt["panel_push"] = SMALL
    say, mass = printer(comm, opt), opt["panel_mass"]
    tasks = list(product(*(sorted({*opt[option.name]}) for option in OPTIONS)))
    end = opt["ts_max_time"] if "ts_max_time" in given else None
    least = max(later + 0.5 * period for later, period in (times_of(opt, *t) for t in tasks))
    if end is not None and end < least:
        expected = f"expected at least {ceil(10.0 * least) / 10.0:g}, to tell the modes apart"
        raise InputError(f"-ts_max_time is {end:g}: {expected}")
    runs = shared(comm, tasks, lambda task: one_run(opt, *task, end))
    facts, lines = f"mass {mass:g}, thickness {opt['panel_thickness']:g}", list(map(_row, runs))
    say(f"panel, {facts}: growth and angular frequency of its modes\n\n{text_table(HEAD, lines)}")
    say("\nonset of flutter: lambda, and frequency f in cycles per unit of time")
    say(onsets(runs, mass, opt["panel_ends"]))
    save_csv(comm, path, HEAD, lines)
    say(f"\nsaved {path}")


def times_of(opt: Mapping[str, Any], mach: float, dynamic: float) -> tuple[float, float]:
    """The time from which on modes are fitted, and the period of the panel without a flow."""
    frequency = FREQUENCY[opt["panel_ends"]] * unit_of(mach, opt["panel_mass"], dynamic)
    return CHORDS / (mach - 1.0), 2.0 * pi / frequency


def one_run(
    opt: Mapping[str, Any], mach: float, dynamic: float, end: float | None = None
) -> FlutterRun:
    """The modes of the panel at a Mach number and lambda = dynamic, from a run on this rank alone.

    It ends at the time end, or after a good period. InputError, ComputationError, FileError.
    """
    from mpi4py import MPI

    from fsipetsc.stepping.run import run_case

    later, period = times_of(opt, mach, dynamic)
    own = {**opt, "panel_mach": mach, "panel_lambda": dynamic, "fsi_quiet": True}
    own |= {"ts_max_time": end or later + PERIODS * period}
    own |= {"fsi_output_dt": period / SAMPLES, "fsi_output_times": None}
    with tempfile.TemporaryDirectory() as folder:
        own["fsi_output"] = f"{folder}/panel.h5"
        try:
            run_case(CASE, own, MPI.COMM_SELF)
            s, misfit = fit_modes(*motion_of(open_run(own["fsi_output"]), later))
        except ComputationError as error:
            raise ComputationError(f"M = {mach:g}, lambda = {dynamic:g}: {error}") from None
    return mach, dynamic, (complex(s[0]), complex(s[1])), misfit


def _row(run: FlutterRun) -> list[object]:
    """Under HEAD."""
    mach, dynamic, pair, misfit = run
    fastest = max(pair, key=lambda s: s.real)
    numbers = [f"{x:.6g}" for s in (fastest, *pair) for x in (s.real, s.imag)]
    return [f"{mach:g}", f"{dynamic:g}", *numbers, f"{misfit:.1e}"]


def onsets(runs: Sequence[FlutterRun], mass: float, ends: str) -> str:
    """A table of lambda and f of each Mach number; NaN where the runs do not show it. Beside it
    lambda over that of a thin panel."""
    rows, thin = [], CRITICAL[ends]
    for mach in dict.fromkeys(mach for mach, *_ in runs):
        _, dynamic, pairs, _ = zip(*(run for run in runs if run[0] == mach))
        found, s = crossing(mach, mass, dynamic, pairs)
        f = s.imag / (2.0 * pi)
        rows.append([f"{mach:g}", f"{found:.1f}", f"{f:.4f}", f"{found / thin:.3f}"])
    return text_table(["M", "lambda", "f", f"of {thin}"], rows)
