"""The command `convergence CASE`: a case over orders and grids, errors, observed orders and cost.

A case with an exact solution in all of its layers is compared with that, any other case with
itself. All ranks share each run. What is left is a table on the terminal and as CSV, and a picture.

Where grids are compared with each other, fields are at the end, at the nodes that all grids have in
common, series at SAMPLES equal distances of time. A difference is the norm in force (L1 or L2) of
the mean over these, over the largest range on the finest grid of all fields of its unit in layers
of its kind.
"""

from collections.abc import Mapping, Sequence
from functools import partial, reduce
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.cases import case_after, options_after
from fsipetsc.checks import counted
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.options import Option
from fsipetsc.output.differences import common_nodes, summed
from fsipetsc.output.quantities import unit_of
from fsipetsc.output.reader import Run, open_run
from fsipetsc.process.together import Comm, together
from fsipetsc.studies import tables
from fsipetsc.studies.tables import Row, Study, listed_in

#: what -fsi_h is multiplied with for the grids of a study: in one dimension with an exact solution,
#: in one without, and in more dimensions
FACTORS = (4, 2, 1, 1 / 2, 1 / 4), (2, 1, 1 / 2), (2, 1, 2 / 3)
#: times at which series are compared
SAMPLES = 10
#: series that are of the steps or of the method, not of the solution
NO_SOLUTION = "t", "dt", "least_J", "J_error", "lost_energy"
#: names of the cost in the summary of a result
COST = "points", "steps", "rhs_evaluations", "wall_time"
_ORDERS = "instead of -fsi_order; default: all, or the case's own if it has no exact solution"
_SPACINGS = "grid spacings; default: 4, 2, 1, 1/2, 1/4 times -fsi_h; not so many in 2-D and 3-D"
OPTIONS = (
    Option("fsi_orders", "ints", None, "", _ORDERS, check=listed_in((2, 4, 6, 8))),
    Option("fsi_hs", "floats", None, "m", _SPACINGS, check="positive"),
)
sections = partial(options_after, extra=OPTIONS)


def convergence(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; ComputationError at the end if a run has failed; FileError.
    """
    from fsipetsc.stepping.solve import build_problem

    case = together(comm, lambda: case_after("convergence", arguments))
    study = Study(comm, arguments[1:], OPTIONS, f"{case.NAME}-convergence", case)
    opt, problem = study.opt, build_problem(case, study.opt, comm)
    exact = all(layer.exact is not None for layer in problem.layers)
    factors = FACTORS[2] if problem.dimension > 1 else FACTORS[0] if exact else FACTORS[1]
    every = exact and "fsi_order" not in study.given
    orders = opt["fsi_orders"] or ((2, 4, 6, 8) if every else [opt["fsi_order"]])
    hs = sorted({*(opt["fsi_hs"] or [of * opt["fsi_h"] for of in factors])}, reverse=True)
    if not exact and len(hs) < 3:
        raise InputError(
            f"the case {case.NAME} has no exact solution: its grids are compared with each other, "
            "and that takes three, as in -fsi_hs 0.1,0.05,0.025"
        )
    time = f"t = {opt['ts_max_time']:g}" + " s" * (problem.units == "SI")
    what = "errors" if exact else "relative differences from the next grid"
    about = f"{case.NAME}, {what} in {opt['fsi_norm']} at {time}, {counted(comm.size, 'rank')}"
    study.say(about)
    end, parts = opt["ts_max_time"], 1 if exact else SAMPLES
    times = tuple(end * np.arange(1, parts + 1) / parts)
    own = {"fsi_output_dt": None, "fsi_output_times": times, "fsi_quiet": True}
    panels: dict[str, list[Row]] = {}
    lines: list[list[object]] = []
    failures: list[str] = []
    with study.results_folder() as folder:
        for order in dict.fromkeys(orders):
            study.say("")
            runs, failed = _runs(study, case, {**own, "fsi_order": order}, hs, folder)
            failures += failed
            rows = together(comm, partial(_rows, case.NAME, order, opt, exact, runs))
            study.say(f"\n{tables.told(rows)}" if rows else "")
            costs = [[run.summary[name] for name in COST] for run in runs.values()]
            for row in rows:
                table = row.lines(comm.size, "exact solution" if exact else "next grid")
                lines += [[*line, *cost] for line, cost in zip(table, costs)]
                kind, _, name = row.quantity.partition("/")
                if name == "combined":
                    panels.setdefault(kind, []).append(row)
    study.save([*tables.COLUMNS, *COST], lines, about)
    study.on_first(lambda: tables.picture(about, panels, study.path.with_suffix(".png")))
    study.say(f"\nsaved {study.path}")
    if failures:
        raise ComputationError(f"{counted(len(failures), 'run')} failed; {failures[0]}")


def _runs(
    study: Study, case: Any, own: Mapping[str, Any], hs: Sequence[float], folder: Path
) -> tuple[dict[float, Run], list[str]]:
    """Results by h of the grids that do not fail, and why others do. Collective; InputError,
    FileError. own: options of all these runs.
    """
    from fsipetsc.stepping.run import REMAINS, run_case

    order, runs, failures = own["fsi_order"], {}, []
    for h in hs:
        path, which = f"{folder}/{order}-{h!r}.h5", f"order {order}, h = {h:g}"
        try:
            run_case(case, {**study.opt, **own, "fsi_h": h, "fsi_output": path}, study.comm)
            runs[h] = together(study.comm, partial(open_run, path))
            points, steps, _, seconds = (runs[h].summary[name] for name in COST)
            outcome = f"{points:>8.0f} points{steps:>8.0f} steps{seconds:>9.2f} s"
        except InputError as error:
            raise InputError(f"{which}: {error}") from None
        except ComputationError as error:
            why, _, _ = str(error).partition(REMAINS)  # which is removed with the others
            failures.append(f"{which}: {why}")
            outcome = f"  failed: {why}"
        study.say(f"{operator(order).name}  h = {h:<9.6g}{outcome}")
    return runs, failures


def _rows(
    case: str, order: int, opt: Mapping[str, Any], exact: bool, runs: Mapping[float, Run]
) -> list[Row]:
    """The rows of an order: quantities are KIND/NAME, or LAYER/NAME and series/NAME. InputError
    where grids have no node in common.
    """
    found: dict[str, list[float]] = {}
    for run in runs.values() if exact else ():
        for kind, errors in run.errors.items():
            for name, error in errors.items():
                found.setdefault(f"{kind}/{name}", []).append(error)
    if not exact and len(runs) > 1:
        found = differences([*runs.values()], opt["fsi_norm"])
    part = {"L1": 1.0, "L2": 0.5}[opt["fsi_norm"]]
    # closures err by order s at a fixed number of nodes
    rate = tables.kinked(order, part) if opt["fsi_shock"] > 0.0 else order // 2 + part
    how = tables.Expected(rate, None if exact else tables.ROUND_OFF), not exact
    return [Row(case, name, order, tuple(runs), of, *how) for name, of in found.items()]


def differences(runs: Sequence[Run], norm: str) -> dict[str, list[float]]:
    """GROUP/NAME -> relative differences of each run but the last, from coarse to fine, from the
    next one; and of each group "combined", their mean. InputError where there is no common node.
    """
    values, power = _common_values(runs), {"L1": 1, "L2": 2}[norm]
    ranges: dict[tuple[str, str], float] = {}
    for _, _, sort, found in values:
        low, high = np.nanmin(found[-1]), np.nanmax(found[-1])
        size = max(abs(low), abs(high))
        span = high - low if high - low > 1e-9 * size else size  # else it is round-off
        ranges[sort] = max(ranges.get(sort, 0.0), float(span))
    groups: dict[str, dict[str, Any]] = {}
    for group, name, sort, found in values:
        gaps = [np.abs(b - a).ravel() / (ranges[sort] or 1.0) for a, b in pairwise(found)]
        means = [np.nanmean(gap**power) ** (1 / power) for gap in gaps]
        groups.setdefault(group, {})[name] = np.array(means)
    for own in groups.values():
        own["combined"] = np.mean(np.array([*own.values()]) ** power, axis=0) ** (1 / power)
    every = ((f"{group}/{name}", of) for group, own in groups.items() for name, of in own.items())
    return {name: of.tolist() for name, of in every}


def _common_values(runs: Sequence[Run]) -> list[tuple[str, str, tuple[str, str], list[Any]]]:
    """(group, name, kind of layer and unit, values of each run at what all have in common); what
    has no known unit has one of its own. InputError.
    """
    found = []
    for layer, *others in zip(*(run.layers for run in runs)):
        pairs = [common_nodes(layer, other, []) for other in (layer, *others)]
        every = reduce(np.intersect1d, [pair[0] if pair else [] for pair in pairs])
        if not len(every):
            raise InputError(
                f"layer '{layer.name}': no node of the coarsest grid is on all others; "
                "-fsi_hs takes grids with common nodes, as in -fsi_hs 0.1,0.05,0.025"
            )
        nodes = [pair[1][np.searchsorted(pair[0], every)] for pair in pairs if pair]
        for name in layer.fields:
            ends = [of.frame(-1)[name].ravel()[at] for of, at in zip((layer, *others), nodes)]
            found.append((layer.name, name, (layer.kind, unit_of(name) or name), ends))
    times = runs[0].time[1:]
    for name in runs[0].series:
        if name not in NO_SOLUTION and not name.startswith("residual_"):
            values = [summed(run, name)[np.isin(run.series["t"], times)] for run in runs]
            if len({v.shape for v in values}) == 1 and values[0].size:
                found.append(("series", name, ("series", unit_of(name) or name), values))
    return found
