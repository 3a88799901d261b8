"""The command `convergence CASE`: a case over orders and grids, errors, observed orders and cost.

A case with an exact solution in all of its layers is compared with that, any other case with itself
(fsipetsc.studies.convergence_table). All ranks share each run. What is left is a table on the
terminal and as CSV, and a picture: error against grid spacing and against time.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.cases import case_after, options_after
from fsipetsc.checks import counted
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.options import Option
from fsipetsc.output.reader import open_run
from fsipetsc.process.together import Comm, together, wait_asleep
from fsipetsc.studies.convergence_figure import convergence_figure
from fsipetsc.studies.convergence_table import COST, SAMPLES, Study, differences, unresolved
from fsipetsc.studies.tables import begin, listed_in, printer, results_folder

#: what -fsi_h is multiplied with for the grids of a study: in one dimension with an exact solution,
#: in one without, and in more dimensions
FACTORS = (4, 2, 1, 1 / 2, 1 / 4), (2, 1, 1 / 2), (2, 1, 2 / 3)
_ORDERS = "instead of -fsi_order; default: all, or the case's own if it has no exact solution"
_SPACINGS = "grid spacings; default: 4, 2, 1, 1/2, 1/4 times -fsi_h; not so many in 2-D and 3-D"
OPTIONS = (
    Option("fsi_orders", "ints", None, "", _ORDERS, check=listed_in((2, 4, 6, 8))),
    Option("fsi_hs", "floats", None, "m", _SPACINGS, check="positive"),
)


def convergence(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; ComputationError at the end if a run has failed; FileError.
    """
    case = together(comm, lambda: case_after("convergence", arguments))
    name, instead = f"{case.NAME}-convergence", {"fsi_order": "fsi_orders"}
    opt, _, path = begin(case, arguments[1:], comm, OPTIONS, name, instead)
    table, say = _empty_table(case, opt, comm), printer(comm, opt)
    what = "errors" if table.exact else "relative differences between neighbouring grids"
    ranks = counted(comm.size, "rank")
    say(f"{case.NAME} to {table.time} on {ranks}: {table.norm} {what} and observed orders")
    with results_folder(comm, path.parent, "convergence-") as folder:
        for i in range(len(table.orders)):
            _run_order(case, opt, comm, table, i, folder, say)
    if table.errors and len(table.hs) < 2:
        say("\none grid shows no order: -fsi_hs takes several, as in -fsi_hs 0.05,0.025")
    if comm.rank == 0:
        files = [table.save(path), *convergence_figure(table, path.with_suffix(".png"))]
        say("\nresults in " + ", ".join(map(str, files)))
    wait_asleep(comm)
    if table.failures:
        (order, h), text = next(iter(table.failures.items()))
        runs = counted(len(table.orders) * len(table.hs), "run")
        first = f"order {order}, h = {h:g}: {text}"
        raise ComputationError(f"{len(table.failures)} of {runs} failed; {first}")


sections = partial(options_after, "convergence", extra=OPTIONS)


def _empty_table(case: Any, opt: Mapping[str, Any], comm: Comm) -> Study:
    """Orders and grids, each of which is laid out once. Collective; InputError."""
    from fsipetsc.stepping.solve import build_problem, make_state

    problem = build_problem(case, opt, comm)
    exact = all(layer.exact is not None for layer in problem.layers)
    factors = FACTORS[2] if problem.dimension > 1 else FACTORS[0] if exact else FACTORS[1]
    orders = opt["fsi_orders"] or ((2, 4, 6, 8) if exact else (opt["fsi_order"],))
    spacings = opt["fsi_hs"] or [factor * opt["fsi_h"] for factor in factors]
    hs = tuple(sorted(set(spacings), reverse=True))
    if not exact and len(hs) < 3:
        raise InputError(
            f"the case {case.NAME} has no exact solution: its grids are compared with each other, "
            "and that takes three, as in -fsi_hs 0.1,0.05,0.025"
        )
    orders = tuple(dict.fromkeys(orders))
    for order in orders:
        for h in hs:
            own = {**opt, "fsi_order": order, "fsi_h": h}
            try:
                make_state(build_problem(case, own, comm), own, comm).destroy()
            except InputError as error:
                raise InputError(f"order {order}, h = {h:g}: {error}") from None
    about = comm.size, opt["fsi_norm"], problem.units, exact
    return Study(case.NAME, opt["ts_max_time"], orders, hs, *about)


def _run_order(
    case: Any, opt: Mapping[str, Any], comm: Comm, table: Study, i: int, folder: Path, say: Any
) -> None:
    """Run all grids of order i, fill the table and say what is in it. Collective; InputError where
    grids have no node in common; FileError."""
    from fsipetsc.stepping.run import run_case

    times = (table.t,) if table.exact else tuple(table.t * np.arange(1, SAMPLES + 1) / SAMPLES)
    own = {**opt, "fsi_quiet": True, "fsi_output_dt": None, "fsi_output_times": times}
    paths: dict[int, str] = {}

    def keep(j: int) -> None:
        """What a run has cost, and its errors."""
        run = open_run(paths[j])
        table.put(i, j, run.errors if table.exact else {})
        for name in COST:
            table.cost[name][i, j] = run.summary[name]

    def compare() -> list[str]:
        """Differences of neighbouring grids; which layers are not resolved."""
        if table.exact or len(paths) < 2:
            return []
        found = differences([open_run(path) for path in paths.values()], table.norm)
        for j, k, errors in zip(paths, list(paths)[1:], found):
            if k == j + 1:
                table.put(i, j, errors)
        return unresolved(table, i)

    say("")
    for j, h in enumerate(table.hs):
        own |= {"fsi_order": table.orders[i], "fsi_h": h, "fsi_output": f"{folder}/{i}-{j}.h5"}
        try:
            run_case(case, dict(own), comm)
            paths[j] = own["fsi_output"]
        except ComputationError as error:
            table.failures[table.orders[i], h] = str(error)
        together(comm, lambda: None if comm.rank or j not in paths else keep(j))  # noqa: B023
        say(table.row(i, j))
    notes = together(comm, lambda: [] if comm.rank else compare())
    if table.errors:
        say("\n".join([table.table(i), *notes]))
