"""The command `convergence CASE`: one case over orders and grids, its errors, observed orders and cost.

Any case with an exact solution in all of its layers can be studied. The runs are made in this process, one after the
other, by the code of a normal run (fsipetsc.stepping.solve); under mpiexec all ranks share each of them. Results are
a table on the terminal, the same numbers as HDF5 and CSV, and two pictures: error against grid spacing (Fig. 6 of the
paper) and error against time (Fig. 7).
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fsipetsc.analysis import table1
from fsipetsc.analysis.convergence_table import ConvergenceStudy
from fsipetsc.cases import load_case
from fsipetsc.checks import counted
from fsipetsc.errors import ComputationError, FileError, InputError
from fsipetsc.options import Option, groups, read_options
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import together, wait_asleep
from fsipetsc.usage import program

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.blockrun.run_problem import RunProblem
    from fsipetsc.problem import Problem

#: by dimension, what -fsi_h is multiplied with for the grids of a study
FACTORS = {1: (4, 2, 1, 1 / 2, 1 / 4), 2: (2, 1, 2 / 3)}


def _orders_only(values: Sequence[int]) -> str | None:
    return None if values and set(values) <= {2, 4, 6, 8} else "orders out of 2, 4, 6, 8"


def _spacings(values: Sequence[float]) -> str | None:
    return None if values and min(values) > 0 else "grid spacings above 0"


OPTIONS = (
    Option("fsi_orders", "ints", (2, 4, 6, 8), "", "orders to study, instead of -fsi_order", check=_orders_only),
    Option(
        *("fsi_hs", "floats", None, "m"),
        help="grid spacings to study; default: 4, 2, 1, 1/2 and 1/4 times -fsi_h, in 2-D 2, 1 and 2/3 times",
        check=_spacings,
    ),
)


def convergence(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm.

    Raises InputError, also for a case without exact solution; ComputationError at the end if a run has failed;
    FileError.
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


def study(case: Any, opt: Mapping[str, Any], given: Container[str], comm: MPI.Comm) -> ConvergenceStudy:
    """Make all runs, print and save. Collective on comm.

    opt: options in force, those of this command included. given: names of those that the user gave.
    """
    from fsipetsc.output.plots.convergence import convergence_figures
    from fsipetsc.stepping.solve import build_problem, check_begin
    from fsipetsc.stepping.versions import versions

    check_begin(opt)
    path = _target(case, opt, given)
    orders, problem = tuple(dict.fromkeys(opt["fsi_orders"])), build_problem(case, opt, comm)
    spacings = opt["fsi_hs"] or tuple(factor * opt["fsi_h"] for factor in FACTORS[problem.dimension])
    table = ConvergenceStudy(
        *(case.NAME, opt["ts_max_time"], orders, _distinct(spacings), comm.size),
        {name: value for name, value in opt.items() if name not in ("fsi_order", "fsi_h", "fsi_output")},
        versions(),
        units=problem.units,
        dimension=problem.dimension,
    )
    _check(case, problem, opt, comm, table)
    say = (lambda text: None) if opt["fsi_quiet"] else (lambda text: _say(comm, text))
    say(f"{case.NAME} to {table.time} on {counted(comm.size, 'rank')}: {table.norm} errors and observed orders")
    for note in problem.notes:
        say(note)
    reached = _run_all(case, opt, comm, table, say)
    if len(table.hs) > 1:
        say("\n" + table.summary())
    else:
        say("\none grid shows no order: -fsi_hs takes several, as in -fsi_hs 0.05,0.025")
    if reached != {table.t} and reached:
        say(f"\nruns have ended before {table.time}, by -ts_max_steps: their errors are those of different times")
    if case.NAME == "mms" and len(table.hs) > 1:
        say("\n" + table1.compare(table))
    if comm.rank == 0:
        kept = table.save(path)
        if kept is not None:
            say(f"\nkept the earlier {path} as {kept}")
        files = [path, path.with_suffix(".csv"), *convergence_figures(table, path)]
        say("\nresults in " + ", ".join(map(str, files)))
    wait_asleep(comm)
    if table.failures:
        first = next(f"order {order}, h = {h:g}: {text}" for (order, h), text in table.failures.items())
        raise ComputationError(f"{len(table.failures)} of {counted(len(orders) * len(table.hs), 'run')} failed; {first}")
    return table


def _distinct(spacings: Sequence[float]) -> tuple[float, ...]:
    """Grid spacings from coarse to fine, each once; what is the same in six digits shows no order but round-off."""
    return tuple(sorted({f"{h:.6g}": h for h in spacings}.values(), reverse=True))


def _run_all(case: Any, opt: Mapping[str, Any], comm: MPI.Comm, table: ConvergenceStudy, say: Any) -> set[float]:
    """Fill the table, run by run, and say each row; the times that were reached [s]."""
    from fsipetsc.stepping.solve import solve

    reached = set()
    for i, order in enumerate(table.orders):
        say("\n" + table.head(i))
        # once for nothing: compiling or loading the kernels is no part of the cost
        with suppress(ComputationError):
            solve(case, {**opt, "fsi_order": order, "fsi_h": table.hs[0], "ts_max_steps": 1}, comm, say)
        for j, h in enumerate(table.hs):
            try:
                outcome = solve(case, {**opt, "fsi_order": order, "fsi_h": h}, comm)
                table.put(i, j, outcome)
                reached.add(outcome.t)
            except ComputationError as error:
                table.failures[order, h] = str(error)
            say(table.row(i, j))
    return reached


def _check(
    case: Any, problem: Problem | RunProblem, opt: Mapping[str, Any], comm: MPI.Comm, table: ConvergenceStudy
) -> None:
    """Lay every grid once, so that what does not fit is known before the first run. Collective; InputError."""
    from fsipetsc.stepping.solve import build_problem, make_state

    without = [layer.name for layer in problem.layers if layer.exact is None]
    if without:
        raise InputError(
            f"the case {case.NAME} has no exact solution in layer '{without[0]}', so there are no errors to study; "
            "a case has one where its layers are given exact=… (mms, pulse and plane_mms are such cases)"
        )
    for order in table.orders:
        for h in table.hs:
            own = {**opt, "fsi_order": order, "fsi_h": h}
            try:
                make_state(build_problem(case, own, comm), own, comm).destroy()
            except InputError as error:
                raise InputError(f"order {order}, h = {h:g}: {error}") from None


def _target(case: Any, opt: Mapping[str, Any], given: Container[str]) -> Path:
    """The HDF5 file of the table. InputError for options that a study has no use for; FileError."""
    if "fsi_order" in given:
        raise InputError("-fsi_order is for a single run; a study takes -fsi_orders, as in -fsi_orders 4,6")
    if "fsi_h" in given and "fsi_hs" in given:
        raise InputError("-fsi_h and -fsi_hs both say what the grids are; give one of them")
    path = Path(opt["fsi_output"] if "fsi_output" in given else f"{case.NAME}-convergence.h5")
    if path.suffix in (".csv", ".png"):
        raise InputError(f"-fsi_output {path} names the HDF5 file of a study; the CSV and PNG files get names like it")
    if not path.parent.is_dir() or path.is_dir():
        raise FileError(f"{path}: " + ("is a directory" if path.is_dir() else f"no directory {path.parent}"))
    return path


def _say(comm: MPI.Comm, text: str) -> None:
    if comm.rank == 0:
        print(text, flush=True)
