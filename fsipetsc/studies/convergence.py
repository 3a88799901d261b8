"""The command `convergence CASE`: a case over orders and grids, errors, observed orders and cost.

A case with an exact solution in all of its layers is compared with that, any other case with itself
(fsipetsc.studies.grids). All ranks share each run. What is left is a table on the terminal and as
CSV, and a picture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial, wraps
from itertools import product
from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.cases import case_after, options_after
from fsipetsc.checks import counted
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.options import Option
from fsipetsc.output.reader import Run, open_run
from fsipetsc.problem import Problem
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.grids import SAMPLES, differences
from fsipetsc.studies.pictures import picture
from fsipetsc.studies.tables import begin, listed_in, on_first, printer, results_folder, save_csv
from fsipetsc.studies.verdicts import COLUMNS, ROUND_OFF, Expected, Row, Study, kinked, told

#: what -fsi_h is multiplied with for the grids of a study: in one dimension with an exact solution,
#: in one without, and in more dimensions
FACTORS = (4, 2, 1, 1 / 2, 1 / 4), (2, 1, 1 / 2), (2, 1, 2 / 3)
#: names of the cost in the summary of a result
COST = "points", "steps", "rhs_evaluations", "wall_time"
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
    case = _refining(case, opt["fsi_h"])
    orders, hs, exact, units = _plan(case, opt, comm)
    time = f"t = {opt['ts_max_time']:g}" + " s" * (units == "SI")
    what = "errors" if exact else "relative differences from the next grid"
    about = f"{case.NAME}, {what} in {opt['fsi_norm']} at {time}, {counted(comm.size, 'rank')}"
    say, study = printer(comm, opt), Study(orders, hs, exact)
    say(about)
    with results_folder(comm, path.parent, "convergence-") as folder:
        for order in orders:
            say("")
            own = _run_order(case, {**opt, "fsi_order": order}, comm, study, folder, say)
            if own:
                say(f"\n{told(own)}")
            study.rows += own
    if study.rows and len(hs) < 2:
        say("\none grid shows no order: -fsi_hs takes several, as in -fsi_hs 0.05,0.025")
    source = "exact solution" if exact else "next grid"
    lines: list[list[object]] = []
    compared = set()
    for row in study.rows:
        for h, line in zip(hs, row.lines(comm.size, source)):
            lines.append([*line, *study.costs.get((row.order, h), [""] * len(COST))])
            compared.add((row.order, h))
    for (order, h), cost in study.costs.items():
        if (order, h) not in compared:  # the finest grid, with which the others are compared
            place = ["", order, h, comm.size]
            lines.append([case.NAME, *place, *[""] * (len(COLUMNS) - 5), *cost])
    save_csv(comm, path, [*COLUMNS, *COST], lines, about)
    panels: dict[str, list[Row]] = {}
    for row in study.rows:
        kind, _, name = row.quantity.partition("/")
        if name == "combined":
            panels.setdefault(kind, []).append(row)
    drawn = on_first(comm, lambda: picture(about, panels, path.with_suffix(".png")))
    say("\nsaved " + ", ".join(map(str, [path, *(drawn or ())])))
    if study.failures:
        runs = counted(len(orders) * len(hs), "run")
        raise ComputationError(f"{len(study.failures)} of {runs} failed; {study.failures[0]}")


sections = partial(options_after, extra=OPTIONS)


def _refining(case: Any, h: float) -> Any:
    """The case, in which layers in one dimension whose own cells are the same for any -fsi_h are
    refined with it; h [m]: the -fsi_h to which these cells belong.
    """

    @wraps(case.build)
    def build(opt: Any) -> Any:
        found = case.build(opt)
        if not isinstance(found, Problem):
            return found
        layers, usual = list(found.layers), case.build(type(opt)({**opt, "fsi_h": h})).layers
        for k, (now, before) in enumerate(zip(layers, usual)):
            if now.cells and now.cells == before.cells:
                layers[k] = replace(now, cells=max(1, round(now.cells * h / opt["fsi_h"])))
        return replace(found, layers=layers)

    return SimpleNamespace(**{**vars(case), "build": build})


def _plan(
    case: Any, opt: Mapping[str, Any], comm: Comm
) -> tuple[tuple[int, ...], tuple[float, ...], bool, str]:
    """Orders, spacings, coarse to fine, whether the solution is known, and units. Each grid is laid
    out once. Collective; InputError."""
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
    for order, h in product(orders, hs):
        own = {**opt, "fsi_order": order, "fsi_h": h}
        try:
            make_state(build_problem(case, own, comm), own, comm).destroy()
        except InputError as error:
            raise InputError(f"order {order}, h = {h:g}: {error}") from None
    return orders, hs, exact, problem.units


def _run_order(
    case: Any, opt: Mapping[str, Any], comm: Comm, study: Study, folder: Path, say: Any
) -> list[Row]:
    """Run all grids of an order: its rows; costs and failures go to the study. Collective;
    InputError where grids have no node in common; FileError."""
    from fsipetsc.stepping.run import REMAINS, run_case

    order, end = opt["fsi_order"], opt["ts_max_time"]
    times = (end,) if study.exact else tuple(end * np.arange(1, SAMPLES + 1) / SAMPLES)
    own = {**opt, "fsi_quiet": True, "fsi_output_dt": None, "fsi_output_times": times}
    runs: dict[float, Run] = {}
    for h in study.hs:
        path = f"{folder}/{order}-{h!r}.h5"
        try:
            run_case(case, {**own, "fsi_h": h, "fsi_output": path}, comm)
            runs[h] = together(comm, partial(open_run, path))
            cost = study.costs[order, h] = [runs[h].summary[name] for name in COST]
            outcome = f"{cost[0]:>8.0f} points{cost[1]:>8.0f} steps{cost[3]:>9.2f} s"
        except ComputationError as error:
            why, _, _ = str(error).partition(REMAINS)  # which is removed with the others
            study.failures.append(f"order {order}, h = {h:g}: {why}")
            outcome = f"  failed: {why}"
        say(f"{operator(order).name}  h = {h:<9.6g}{outcome}")
    errors = {h: run.errors for h, run in runs.items()}
    if not study.exact:
        several = [*runs.values()] if len(runs) > 1 else []  # of fewer nothing can be compared
        norm = opt["fsi_norm"]
        between = together(comm, lambda: [*differences(several, norm)] if several else [])
        errors = {
            h: found
            for h, next_h, found in zip(runs, [*runs][1:], between)
            if study.hs.index(next_h) == study.hs.index(h) + 1
        }
    names = dict.fromkeys((k, name) for of in errors.values() for k in of for name in of[k])
    grids = study.hs[: None if study.exact else -1]
    part = {"L1": 1.0, "L2": 0.5}[opt["fsi_norm"]]
    # closures err by order s at a fixed number of nodes
    rate = kinked(order, part) if opt["fsi_shock"] > 0.0 else order // 2 + part
    expected = Expected(rate, None if study.exact else ROUND_OFF)
    return [
        Row(case.NAME, f"{k}/{name}", order, study.hs, found, expected, not study.exact)
        for k, name in names
        for found in [tuple(errors[h][k][name] if h in errors else nan for h in grids)]
    ]
