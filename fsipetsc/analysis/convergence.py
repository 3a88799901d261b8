"""The command `convergence CASE`: a case over orders and grids, errors, observed orders and cost.

A case with an exact solution in all of its layers is compared with that. Any other case is compared
with itself (fsipetsc.analysis.grid_differences). The runs are made in this process, one after the
other, and their results kept until their order is done; under mpiexec all ranks share each of them.
What is left is a table on the terminal, the same numbers as CSV, and two pictures: error against
grid spacing (Fig. 6 of the paper) and error against time (Fig. 7).
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.analysis import table1
from fsipetsc.analysis.convergence_table import COST, ConvergenceStudy
from fsipetsc.analysis.tables import csv_target, listed_in, printer, results_folder
from fsipetsc.cases import load_case
from fsipetsc.checks import counted
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.options import Option, groups, read_options
from fsipetsc.output.reader import open_run
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import together, wait_asleep
from fsipetsc.usage import program

if TYPE_CHECKING:
    from mpi4py import MPI

#: what -fsi_h is multiplied with for the grids of a study: in one dimension with an exact solution,
#: in one without, and in more dimensions
FACTORS = (4, 2, 1, 1 / 2, 1 / 4), (2, 1, 1 / 2), (2, 1, 2 / 3)
OPTIONS = (
    Option(
        *("fsi_orders", "ints", None, ""),
        help="orders to study, instead of -fsi_order; default: all, "
        "or the case's own if it has no exact solution",
        check=listed_in((2, 4, 6, 8)),
    ),
    Option(
        *("fsi_hs", "floats", None, "m"),
        help="grid spacings to study; default: 4, 2, 1, 1/2 and 1/4 times -fsi_h, "
        "2, 1 and 1/2 times without an exact solution, in 2-D and 3-D 2, 1 and 2/3 times",
        check="positive",
    ),
)


def convergence(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm.

    Raises InputError; ComputationError at the end if a run has failed; FileError.
    """
    case = together(comm, lambda: _case(arguments))
    given = start_petsc(arguments[1:], comm)
    study(case, read_options(case, given, OPTIONS), given, comm)


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help: those of the case that is named, or of the command alone."""
    named = arguments and not arguments[0].startswith("-")
    return groups(_case(arguments), OPTIONS) if named else {"Study": OPTIONS}


def _case(arguments: Sequence[str]) -> Any:
    if not arguments or arguments[0].startswith("-"):
        usage = f"{program()} convergence CASE [-option value ...]"
        raise InputError(f"the command convergence wants a case, such as mms or pulse: {usage}")
    return load_case(arguments[0])


def study(
    case: Any, opt: Mapping[str, Any], given: Container[str], comm: MPI.Comm
) -> ConvergenceStudy:
    """Make all runs, print and save; rank 0 has all numbers. Collective on comm.

    opt: options in force, those of this command included. given: names of those that the user gave.
    """
    from fsipetsc.output.plots.studies import convergence_figures
    from fsipetsc.stepping.solve import build_problem, check_begin

    check_begin(opt)
    path, problem = _target(case, opt, given), build_problem(case, opt, comm)
    exact = all(layer.exact is not None for layer in problem.layers)
    factors = FACTORS[2] if problem.dimension > 1 else FACTORS[0] if exact else FACTORS[1]
    orders = opt["fsi_orders"] or ((2, 4, 6, 8) if exact else (opt["fsi_order"],))
    hs = _distinct(opt["fsi_hs"] or [factor * opt["fsi_h"] for factor in factors])
    if not exact and len(hs) < 3:
        raise InputError(
            f"the case {case.NAME} has no exact solution: its grids are compared with each other, "
            "and that takes three, as in -fsi_hs 0.1,0.05,0.025"
        )
    orders, norm = tuple(dict.fromkeys(orders)), opt["fsi_norm"]
    about = case.NAME, opt["ts_max_time"], orders, hs, comm.size, norm, problem.units, exact
    table, say = ConvergenceStudy(*about), printer(comm, opt)
    what = f"{norm} errors" if exact else "relative differences between neighbouring grids"
    say(f"{case.NAME} to {table.time} on {counted(comm.size, 'rank')}: {what} and observed orders")
    for note in problem.notes:
        say(note)
    _check(case, opt, comm, table, say)
    run_all(case, opt, comm, table, say, path.parent)
    if table.early:
        say(
            f"\nruns have ended before {table.time}, by -ts_max_steps: "
            "their errors are those of different times"
        )
    if len(hs) > 1 and table.errors:
        say("\n" + table.summary())
    elif table.errors:
        say("\none grid shows no order: -fsi_hs takes several, as in -fsi_hs 0.05,0.025")
    if case.NAME == "mms" and exact and len(hs) > 1 and table.errors:
        say("\n" + table1.compare(table))
    if comm.rank == 0:
        files = [table.save(path), *convergence_figures(table, path)]
        say("\nresults in " + ", ".join(map(str, files)))
    wait_asleep(comm)
    if table.failures:
        first = next(
            f"order {order}, h = {h:g}: {text}" for (order, h), text in table.failures.items()
        )
        raise ComputationError(
            f"{len(table.failures)} of {counted(len(orders) * len(hs), 'run')} failed; {first}"
        )
    return table


def _distinct(spacings: Sequence[float]) -> tuple[float, ...]:
    """From coarse to fine, each once; grids that are the same in six digits show round-off."""
    return tuple(sorted({f"{h:.6g}": h for h in spacings}.values(), reverse=True))


def run_all(
    case: Any,
    opt: Mapping[str, Any],
    comm: MPI.Comm,
    table: ConvergenceStudy,
    say: Any,
    beside: Path,
) -> None:
    """Fill the table; say each run, each order, and which layers are not resolved. Collective.

    beside: the folder in which results are kept for a while. InputError where grids have no node in
    common; FileError.
    """
    from fsipetsc.analysis.grid_differences import SAMPLES, unresolved
    from fsipetsc.stepping.run import run_case

    times = (table.t,) if table.exact else tuple(table.t * np.arange(1, SAMPLES + 1) / SAMPLES)
    own = {**opt, "fsi_quiet": True, "fsi_output_dt": None, "fsi_output_times": times}
    with results_folder(comm, beside, "convergence-") as folder:
        for i, order in enumerate(table.orders):
            say("")
            for j, h in enumerate(table.hs):
                own |= {
                    "fsi_order": order,
                    "fsi_h": h,
                    "fsi_output": str(folder / f"{order}-{j}.h5"),
                }
                try:
                    run_case(case, dict(own), comm)
                except ComputationError as error:
                    table.failures[order, h] = str(error)
                keep = partial(_keep, own["fsi_output"], table, i, j)
                together(comm, list if comm.rank else keep)
                say(table.row(i, j))
            notes = together(comm, list if comm.rank else partial(_compare, folder, table, i))
            if table.errors:
                say("\n".join([table.table(i), *notes, *unresolved(table, i)]))


def _keep(path: str, table: ConvergenceStudy, i: int, j: int) -> None:
    """What a run cost, and its errors, go into the table. FileError."""
    key = table.orders[i], table.hs[j]
    if key in table.failures:
        return
    with open_run(path) as run:
        cost = {name: run.summary[key] for name, key in COST.items()}
        table.put(i, j, cost, run.errors)
        table.early |= run.summary["t"] != table.t


def _compare(folder: Path, table: ConvergenceStudy, i: int) -> list[str]:
    """Differences of the grids of order i go into the table; what is to be said of the grids.

    InputError, FileError.
    """
    from fsipetsc.analysis.grid_differences import differences, unrefined

    good = [j for j, h in enumerate(table.hs) if (table.orders[i], h) not in table.failures]
    if table.exact or len(good) < 2:
        return []
    with ExitStack() as stack:
        runs = [stack.enter_context(open_run(folder / f"{table.orders[i]}-{j}.h5")) for j in good]
        for j, k, errors in zip(good, good[1:], differences(runs, table.norm)):
            if k == j + 1:
                table.put(i, j, {}, errors)
        return unrefined(runs)


def _check(
    case: Any, opt: Mapping[str, Any], comm: MPI.Comm, table: ConvergenceStudy, say: Any
) -> None:
    """Lay every grid once, so that what does not fit is known before the first run, and compile.

    Collective; InputError.
    """
    from fsipetsc.stepping.solve import build_problem, make_state

    for order in table.orders:
        for h in table.hs:
            own = {**opt, "fsi_order": order, "fsi_h": h}
            try:
                with make_state(build_problem(case, own, comm), own, comm) as state:
                    if (order, h) == (table.orders[-1], table.hs[-1]):
                        state.compile(say)
            except InputError as error:
                raise InputError(f"order {order}, h = {h:g}: {error}") from None


def _target(case: Any, opt: Mapping[str, Any], given: Container[str]) -> Path:
    """The CSV file of the table. InputError for options that a study has no use for; FileError."""
    if "fsi_order" in given:
        raise InputError(
            "-fsi_order is for a single run; a study takes -fsi_orders, as in -fsi_orders 4,6"
        )
    if "fsi_h" in given and "fsi_hs" in given:
        raise InputError("-fsi_h and -fsi_hs both say what the grids are; give one of them")
    return csv_target(opt["fsi_output"] if "fsi_output" in given else f"{case.NAME}-convergence")
