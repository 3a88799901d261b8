"""The command `convergence CASE`: a case over orders and grids, errors, observed orders and cost.

A case with an exact solution in all of its layers is compared with that, any other with itself:
fields at the end, at the nodes that all grids have in common. A difference is the norm in force (L1
or L2) of the mean over these, over the largest range on the finest grid of all fields of its unit
in layers of its kind.
"""

from collections.abc import Sequence
from functools import partial, reduce
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from fsipetsc.cases import case_after, options_after
from fsipetsc.checks import counted
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.options import Option
from fsipetsc.output.differences import common_nodes
from fsipetsc.output.info import table
from fsipetsc.output.quantities import unit_of
from fsipetsc.output.reader import Run
from fsipetsc.process.together import Comm, together
from fsipetsc.studies import trials
from fsipetsc.studies.tables import Study, listed_in
from fsipetsc.studies.trials import Row, Trial

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
sections = partial(options_after, extra=OPTIONS)


def convergence(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; ComputationError if a run fails; FileError.
    """
    from fsipetsc.stepping.run import build_problem

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
    source = "exact solution" if exact else "next grid"
    end, unit = opt["ts_max_time"], " s" * (problem.units == "SI")
    about = f"{case.NAME}, distances from the {source} in {opt['fsi_norm']} at t = {end:g}{unit}"
    study.say(f"{about}, {counted(comm.size, 'rank')}")
    own = {**opt, "fsi_output_dt": None, "fsi_output_times": (end,), "fsi_quiet": True}
    panels: dict[str, dict[str, Row]] = {}
    lines: list[list[object]] = []
    with study.results_folder() as folder:
        for order in dict.fromkeys(orders):
            study.say("")
            runs: dict[float, Run] = {}
            for h in hs:
                trial = Trial(comm, folder, order, h)
                runs[h] = trial.solve(case, **{**own, "fsi_h": h})
                points, steps, _, seconds = (runs[h].summary[name] for name in COST)
                cost = f"{points:>8.0f} points{steps:>8.0f} steps{seconds:>9.2f} s"
                study.say(f"{OPERATORS[order].name}  h = {h:<9.6g}{cost}")
            rows = together(comm, partial(rows_of, case.NAME, trial, opt, exact, runs))
            study.say("\n" + table([trials.HEAD, *(row.cells for row in rows)], str.rjust))
            costs = [[run.summary[name] for name in COST] for run in runs.values()]
            for row in rows:
                lines += [[*a, *b] for a, b in zip(row.lines(comm.size, source), costs)]
                kind, _, name = row.quantity.partition("/")
                if name == "combined":
                    panels.setdefault(kind, {})[OPERATORS[order].name] = row
            study.save([*trials.COLUMNS, *COST], lines)  # and again after each order
            study.on_first(lambda: trials.picture(about, panels, study.path.with_suffix(".png")))
    study.say(f"\nsaved {study.path}")


def rows_of(case: str, trial: Trial, opt: Any, exact: bool, runs: dict[float, Run]) -> list[Row]:
    """The rows of an order: quantities are KIND/NAME or LAYER/NAME. InputError where grids have no
    node in common.
    """
    every, norm = [*runs.values()], opt["fsi_norm"]
    names = [(kind, name) for kind, of in every[0].errors.items() for name in of]
    found = {f"{kind}/{name}": [run.errors[kind][name] for run in every] for kind, name in names}
    if not exact:
        found = differences(every, norm)
    part = {"L1": 1.0, "L2": 0.5}[norm]
    # closures err by order s at a fixed number of nodes
    rate = trial.kinked(part) if opt["fsi_shock"] > 0.0 else trial.order // 2 + part
    how = rate, None if exact else trials.ROUND_OFF, not exact
    return [Row(case, name, trial.order, tuple(runs), of, *how) for name, of in found.items()]


def differences(runs: Sequence[Run], norm: str) -> dict[str, list[float]]:
    """LAYER/FIELD -> relative differences of each run but the last, from coarse to fine, from the
    next one; and of each layer "combined", their mean. InputError where there is no common node.
    """
    power, values, ranges = {"L1": 1, "L2": 2}[norm], {}, {}
    for layers in zip(*(run.layers for run in runs)):
        first, pairs = layers[0], [common_nodes(layers[0], layer, []) for layer in layers]
        every = reduce(np.intersect1d, [pair[0] for pair in pairs])
        if not len(every):
            raise InputError(
                f"layer '{first.name}': no node of the coarsest grid is on all others; "
                "-fsi_hs takes grids with common nodes, as in -fsi_hs 0.1,0.05,0.025"
            )
        nodes = [pair[1][np.searchsorted(pair[0], every)] for pair in pairs]
        for name in first.fields:
            each = [of.frame(-1)[name].ravel()[at] for of, at in zip(layers, nodes)]
            low, high = np.nanmin(each[-1]), np.nanmax(each[-1])
            size, sort = max(abs(low), abs(high)), (first.kind, unit_of(name) or name)
            span = high - low if high - low > 1e-9 * size else size  # else it is round-off
            ranges[sort] = max(ranges.get(sort, 0.0), float(span))
            values[first.name, name] = sort, each
    found: dict[str, list[float]] = {}
    for layer, members in groupby(values.items(), lambda item: item[0][0]):
        own = {}
        for (_, name), (sort, each) in members:
            gaps = [np.abs(b - a) / (ranges[sort] or 1.0) for a, b in pairwise(each)]
            own[name] = np.array([np.nanmean(gap**power) ** (1 / power) for gap in gaps])
        own["combined"] = np.mean(np.array([*own.values()]) ** power, axis=0) ** (1 / power)
        found |= {f"{layer}/{name}": of.tolist() for name, of in own.items()}
    return found
