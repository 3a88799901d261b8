"""The command `convergence CASE`: a case over orders and grids, errors, observed orders and cost.

A case with an exact solution in all of its layers is compared with that, any other with itself:
fields at the end, at the nodes that all grids have in common. A difference is the norm in force (L1
or L2) of the mean over these, over the largest range on the finest grid of all fields of its unit
in layers of its kind.
"""

from collections.abc import Mapping, Sequence
from functools import partial, reduce
from itertools import pairwise
from typing import Any

import numpy as np

from fsipetsc.cases import load_case
from fsipetsc.checks import counted
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.options import Option, defaults
from fsipetsc.output.differences import common_nodes
from fsipetsc.output.quantities import unit_of
from fsipetsc.output.reader import Run
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.trials import ROUND_OFF, Row, Study, Trial, picture

#: names of the cost in the summary of a result
COST = "points", "steps", "rhs_evaluations", "wall_time"
OPTIONS = (
    Option("fsi_orders", "ints", None, "", "default: all with an exact solution", (2, 4, 6, 8)),
    Option("fsi_hs", "floats", None, "m", "default: -fsi_h times 2, 1, 1/2 …", check="positive"),
)


def convergence(arguments: list[str], comm: Comm) -> None:
    """Run the command. Collective; InputError, FileError; ComputationError if a run fails."""
    case = together(comm, lambda: load_case(arguments[0]))
    study = Study(comm, arguments[1:], OPTIONS, f"{case.NAME}-convergence", case)
    from fsipetsc.stepping.run import build_problem  # with PETSc, which has been started now

    opt, problem = study.opt, build_problem(case, study.opt, comm)
    exact = all(layer.exact is not None for layer in problem.layers)
    every = exact and "fsi_order" not in study.given
    orders = opt["fsi_orders"] or ((2, 4, 6, 8) if every else [opt["fsi_order"]])
    hs = spacings(case.NAME, opt, exact, problem.dimension)
    source, norm = "exact solution" if exact else "next grid", opt["fsi_norm"]
    end, unit = opt["ts_max_time"], " s" * (problem.units == "SI")
    about = f"{case.NAME}, distances from the {source} in {norm} at t = {end:g}{unit}"
    study.say(f"{about}, {counted(comm.size, 'rank')}\n")
    own = {name: opt[name] for name in defaults(case) if name.lower() in study.given}
    own |= {"fsi_output_dt": None, "fsi_output_times": end}
    power = {"L1": 1, "L2": 2}[norm]  # of the errors, of which the norm takes the mean
    combined: list[Row] = []

    def solved(trial: Trial) -> Run:
        """The result on a grid; what it has cost is printed."""
        run = trial.solve(arguments[0], **{**own, "fsi_h": trial.h})
        points, steps, _, seconds = (run.summary[name] for name in COST)
        cost = f"{points:>8.0f} points{steps:>8.0f} steps{seconds:>9.2f} s"
        study.say(f"{OPERATORS[trial.order].name}  h = {trial.h:<9.6g}{cost}")
        return run

    for trials in study.trials(dict.fromkeys(orders, hs)):
        runs, order = [*map(solved, trials)], trials[0].order
        kinds = runs[0].errors if exact else {}
        found = {f"{k}/{n}": [run.errors[k][n] for run in runs] for k in kinds for n in kinds[k]}
        if not exact:
            found = together(comm, partial(differences, runs, power))
        # closures err by order s at a fixed number of nodes
        smooth = order // 2 + 1.0 / power
        rate = trials[0].kinked(1.0 / power) if opt["fsi_shock"] > 0.0 else smooth
        rows = []
        for name, of in found.items():
            known = rate if exact or of[-1] <= 0.1 else None  # else the grids do not resolve it
            rows.append(Row(name, order, known, None if exact else ROUND_OFF, hs[: len(of)], of))
        study.say("")
        costs = {name: [run.summary[name] for run in runs] for name in COST}
        study.add(case.NAME, source, rows, costs)  # the table is written again after each order
        study.say("")
        combined += [row for row in rows if row.quantity.endswith("/combined")]
        study.on_first(partial(picture, about, combined, study.path.with_suffix(".png")))
    study.say(f"saved {study.path}")


def spacings(name: str, opt: Mapping[str, Any], exact: bool, dimension: int) -> list[float]:
    """Spacings of the grids, from coarse to fine. InputError if they cannot be compared."""
    factors = (4, 2, 1, 1 / 2, 1 / 4) if exact and dimension == 1 else (2, 1, 1 / 2)
    hs = sorted({*(opt["fsi_hs"] or [of * opt["fsi_h"] for of in factors])}, reverse=True)
    ratios = [coarse / fine for coarse, fine in pairwise(hs)]
    if not exact and (len(hs) < 3 or max(ratios) > 1.001 * min(ratios)):
        wrong = f"the case {name} has no exact solution: its grids are compared with each other"
        wanted = "three or more, each finer by the same factor, as in -fsi_hs 0.1,0.05,0.025"
        raise InputError(f"{wrong}; that takes {wanted}")
    return hs


def differences(runs: Sequence[Run], power: int) -> dict[str, list[float]]:
    """LAYER/FIELD -> relative differences of each run but the last, from coarse to fine, from the
    next one; and of each layer "combined", their mean. InputError where there is no common node.
    """
    values: dict[tuple[str, str], Any] = {}
    ranges: dict[tuple[str, str], float] = {}
    for layers in zip(*(run.layers for run in runs)):
        first, pairs = layers[0], [common_nodes(layers[0], layer, []) for layer in layers]
        every = reduce(np.intersect1d, [here for here, _ in pairs])
        if not len(every):
            wrong = f"layer '{first.name}': no node of the coarsest grid is on all others"
            wanted = "-fsi_hs takes grids with common nodes, as in -fsi_hs 0.1,0.05,0.025"
            raise InputError(f"{wrong}; {wanted}")
        nodes = [there[np.searchsorted(here, every)] for here, there in pairs]
        for name in first.fields:
            each = np.array([of.frame(-1)[name].ravel()[at] for of, at in zip(layers, nodes)])
            low, high = np.nanmin(each[-1]), np.nanmax(each[-1])
            size, sort = max(abs(low), abs(high)), (first.kind, unit_of(name) or name)
            span = high - low if high - low > 1e-9 * size else size  # else it is round-off
            ranges[sort] = max(ranges.get(sort, 0.0), float(span))
            values[first.name, name] = sort, each

    def mean(of: Any, axis: int) -> Any:
        return np.nanmean(np.abs(of) ** power, axis) ** (1 / power)

    found: dict[str, list[float]] = {}
    for layer in runs[0].layers:
        own = {}
        for name in layer.fields:
            sort, each = values[layer.name, name]
            own[name] = mean(np.diff(each, axis=0) / (ranges[sort] or 1.0), 1)
        own["combined"] = mean([*own.values()], 0)
        found |= {f"{layer.name}/{name}": of.tolist() for name, of in own.items()}
    return found
