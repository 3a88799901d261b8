"""The command `convergence CASE`: a case over orders and grids, errors, observed orders and cost.

A case with an exact solution in all of its layers is compared with that, any other case with
itself. All ranks share each run. What is left is a table on the terminal and as CSV, and a picture.

Where grids are compared with each other, fields are at the end, at the nodes that all grids have in
common, series at SAMPLES equal distances of time. A difference is the norm in force (L1 or L2) of
the mean over these, over the largest range on the finest grid of all fields of its unit in layers
of its kind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial, reduce, wraps
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
from fsipetsc.output.differences import common_nodes, summed
from fsipetsc.output.quantities import unit_of
from fsipetsc.output.reader import Run, open_run
from fsipetsc.problem import Problem
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.tables import begin, listed_in, on_first, printer, results_folder, save_csv
from fsipetsc.studies.verdicts import COLUMNS, ROUND_OFF, Expected, Row, kinked, picture, told

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


def convergence(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; ComputationError at the end if a run has failed; FileError.
    """
    case = together(comm, lambda: case_after("convergence", arguments))
    name, instead = f"{case.NAME}-convergence", {"fsi_order": "fsi_orders"}
    opt, path = begin(case, arguments[1:], comm, OPTIONS, name, instead)
    case = _refining(case, opt["fsi_h"])
    orders, hs, exact, units = _plan(case, opt, comm)
    time = f"t = {opt['ts_max_time']:g}" + " s" * (units == "SI")
    what = "errors" if exact else "relative differences from the next grid"
    about = f"{case.NAME}, {what} in {opt['fsi_norm']} at {time}, {counted(comm.size, 'rank')}"
    say = printer(comm, opt)
    say(about)
    rows: list[Row] = []
    costs: dict[tuple[int, float], list[float]] = {}
    failures: list[str] = []
    with results_folder(comm, path.parent, "convergence-") as folder:
        for order in orders:
            say("")
            own = {**opt, "fsi_order": order}
            runs, failed = _run_order(case, own, comm, hs, exact, folder, say)
            failures += failed
            costs |= {(order, h): [run.summary[name] for name in COST] for h, run in runs.items()}
            found = _rows(case.NAME, own, comm, hs, exact, runs)
            if found:
                say(f"\n{told(found)}")
            rows += found
    if rows and len(hs) < 2:
        say("\none grid shows no order: -fsi_hs takes several, as in -fsi_hs 0.05,0.025")
    source = "exact solution" if exact else "next grid"
    lines: list[list[object]] = []
    for row in rows:
        for h, line in zip(hs, row.lines(comm.size, source)):
            lines.append([*line, *costs.get((row.order, h), [""] * len(COST))])
    compared = {(row.order, h) for row in rows for h in hs[: len(row.found)]}
    for (order, h), cost in costs.items():
        if (order, h) not in compared:  # the finest grid, with which the others are compared
            place = ["", order, h, comm.size]
            lines.append([case.NAME, *place, *[""] * (len(COLUMNS) - 5), *cost])
    save_csv(comm, path, [*COLUMNS, *COST], lines, about)
    panels: dict[str, list[Row]] = {}
    for row in rows:
        kind, _, name = row.quantity.partition("/")
        if name == "combined":
            panels.setdefault(kind, []).append(row)
    drawn = on_first(comm, lambda: picture(about, panels, path.with_suffix(".png")))
    say("\nsaved " + ", ".join(map(str, [path, *(drawn or ())])))
    if failures:
        every = counted(len(orders) * len(hs), "run")
        raise ComputationError(f"{len(failures)} of {every} failed; {failures[0]}")


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
    case: Any,
    opt: Mapping[str, Any],
    comm: Comm,
    hs: tuple[float, ...],
    exact: bool,
    folder: Path,
    say: Callable[[str], None],
) -> tuple[dict[float, Run], list[str]]:
    """Run all grids of an order: the results by h, and why others failed. Collective; FileError."""
    from fsipetsc.stepping.run import REMAINS, run_case

    order, end = opt["fsi_order"], opt["ts_max_time"]
    times = (end,) if exact else tuple(end * np.arange(1, SAMPLES + 1) / SAMPLES)
    own = {**opt, "fsi_quiet": True, "fsi_output_dt": None, "fsi_output_times": times}
    runs: dict[float, Run] = {}
    failures = []
    for h in hs:
        path = f"{folder}/{order}-{h!r}.h5"
        try:
            run_case(case, {**own, "fsi_h": h, "fsi_output": path}, comm)
            runs[h] = together(comm, partial(open_run, path))
            points, steps, _, seconds = (runs[h].summary[name] for name in COST)
            outcome = f"{points:>8.0f} points{steps:>8.0f} steps{seconds:>9.2f} s"
        except ComputationError as error:
            why, _, _ = str(error).partition(REMAINS)  # which is removed with the others
            failures.append(f"order {order}, h = {h:g}: {why}")
            outcome = f"  failed: {why}"
        say(f"{operator(order).name}  h = {h:<9.6g}{outcome}")
    return runs, failures


def _rows(
    name: str,
    opt: Mapping[str, Any],
    comm: Comm,
    hs: tuple[float, ...],
    exact: bool,
    runs: Mapping[float, Run],
) -> list[Row]:
    """The rows of an order: quantities are KIND/NAME, or LAYER/NAME and series/NAME. Collective;
    InputError where grids have no node in common."""
    errors = {h: run.errors for h, run in runs.items()}
    if not exact:
        several = [*runs.values()] if len(runs) > 1 else []  # of fewer nothing can be compared
        norm = opt["fsi_norm"]
        between = together(comm, lambda: [*differences(several, norm)] if several else [])
        errors = {
            h: found
            for h, next_h, found in zip(runs, [*runs][1:], between)
            if hs.index(next_h) == hs.index(h) + 1
        }
    names = dict.fromkeys((k, name) for of in errors.values() for k in of for name in of[k])
    grids, order = hs[: None if exact else -1], opt["fsi_order"]
    part = {"L1": 1.0, "L2": 0.5}[opt["fsi_norm"]]
    # closures err by order s at a fixed number of nodes
    rate = kinked(order, part) if opt["fsi_shock"] > 0.0 else order // 2 + part
    expected = Expected(rate, None if exact else ROUND_OFF)
    return [
        Row(name, f"{k}/{of}", order, hs, found, expected, not exact)
        for k, of in names
        for found in [tuple(errors[h][k][of] if h in errors else nan for h in grids)]
    ]


def differences(runs: Sequence[Run], norm: str) -> Iterator[dict[str, dict[str, float]]]:
    """Of each run but the last, from coarse to fine: group -> name -> relative difference from the
    next one; and "combined", their mean. InputError where there is no node in common.
    """
    values, power = _common_values(runs), {"L1": 1, "L2": 2}[norm]
    kinds = {layer.name: layer.kind for layer in runs[0].layers}

    # of which kind of layer and unit; what has no known unit has one of its own
    sort = {key: (kinds.get(key[0], key[0]), unit_of(key[1]) or key[1]) for key in values}
    ranges: dict[tuple[str, str], float] = {}
    for key, found in values.items():
        ranges[sort[key]] = max(ranges.get(sort[key], 0.0), _range(found[-1]))
    for j in range(len(runs) - 1):
        errors: dict[str, dict[str, float]] = {}
        for (group, name), found in values.items():
            gap = np.abs(found[j + 1] - found[j]) / (ranges[sort[group, name]] or 1.0)
            gap = gap[np.isfinite(gap)]
            mean = float(np.mean(gap**power) ** (1 / power)) if gap.size else np.nan
            errors.setdefault(group, {})[name] = mean
        for own in errors.values():
            every = np.array(list(own.values()))
            own["combined"] = float(np.nanmean(every**power) ** (1 / power))
        yield errors


def _common_values(runs: Sequence[Run]) -> dict[tuple[str, str], list[np.ndarray]]:
    """(group, name) -> values of each run at what all have in common. InputError."""
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    for k, layer in enumerate(runs[0].layers):
        layers = [run.layers[k] for run in runs]
        pairs = [common_nodes(layer, other, []) for other in layers]
        if any(pair is None for pair in pairs):
            raise InputError(
                f"layer '{layer.name}': no node of the coarsest grid is on all others; "
                "-fsi_hs takes grids with common nodes, as in -fsi_hs 0.1,0.05,0.025"
            )
        known = [pair for pair in pairs if pair is not None]
        every = reduce(np.intersect1d, [first for first, _ in known])
        nodes = [second[np.searchsorted(first, every)] for first, second in known]
        for name in layer.fields:
            ends = [other.frame(-1)[name].ravel() for other in layers]
            found[layer.name, name] = [end[of] for end, of in zip(ends, nodes)]
    times = runs[0].time[1:]
    for name in runs[0].series:
        if name not in NO_SOLUTION and not name.startswith("residual_"):
            values = [summed(r, name)[np.isin(r.series["t"], times)] for r in runs]
            if len({v.shape for v in values}) == 1 and values[0].size:
                found["series", name] = values
    return found


def _range(values: np.ndarray) -> float:
    """The largest less the smallest value; the largest size where that is round-off."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    largest, span = float(np.abs(known).max()), float(np.ptp(known))
    return span if span > 1e-9 * largest else largest
