"""Convergence of a case without an exact solution: its grids, compared with each other.

Fields are compared at the end, at the nodes that all grids have in common, series at SAMPLES equal
distances of time. A difference is the norm in force (L1 or L2) of the mean over these, over the
range of the field on the finest grid, or of the fields of its unit in the layer, if one has more.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.analysis.convergence_table import ROUND_OFF, ConvergenceStudy
from fsipetsc.errors import ComputationError, FileError, InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.output.as_xarray import FIELDS, INTEGRALS
from fsipetsc.output.differences import _common_nodes
from fsipetsc.output.reader import Run, open_run
from fsipetsc.process.together import together

if TYPE_CHECKING:
    from mpi4py import MPI

Array = np.ndarray
#: times at which series are compared
SAMPLES = 10
#: series that are of the steps or of the method, not of the solution
NO_SOLUTION = "t", "dt", "least_J", "J_error"
#: a relative difference of the two finest grids that is too much, and part of the order that is too little
COARSE, SLOW = 0.1, 0.5


def compare_grids(case: Any, opt: Mapping[str, Any], comm: MPI.Comm, table: ConvergenceStudy, say: Any) -> None:
    """Fill the table, say each run and each order, and which layers are not resolved. Collective.

    Results of the runs are kept in a folder beside that of the study until their order is done. InputError
    where grids have no node in common; FileError.
    """
    folder = Path(comm.bcast(together(comm, lambda: _folder(opt) if comm.rank == 0 else None)))
    own = {
        **opt,
        **{"fsi_quiet": True, "fsi_output_dt": None},
        "fsi_output_times": tuple(table.t * np.arange(1, SAMPLES + 1) / SAMPLES),
    }
    try:
        for i, order in enumerate(table.orders):
            say("")
            for j, h in enumerate(table.hs):
                _run(case, {**own, "fsi_order": order, "fsi_h": h}, comm, folder / f"{j}.h5", table, (i, j))
                say(table.row(i, j))
            together(comm, lambda: _compare(folder, table, i) if comm.rank == 0 else None)  # noqa: B023
            if table.errors:
                say("\n".join([table.table(i), *unresolved(table, i)]))
    finally:
        comm.Barrier()
        if comm.rank == 0:
            shutil.rmtree(folder, ignore_errors=True)


def _folder(opt: Mapping[str, Any]) -> str:
    """A new folder. FileError."""
    try:
        return tempfile.mkdtemp(dir=Path(opt["fsi_output"]).parent, prefix="convergence-")
    except OSError as error:
        raise FileError(f"{error.filename}: cannot keep results there: {error.strerror}") from None


def _run(
    case: Any, opt: dict[str, Any], comm: MPI.Comm, path: Path, table: ConvergenceStudy, at: tuple[int, int]
) -> None:
    """One run with its result in a file; what it costs goes into the table. Collective."""
    from fsipetsc.stepping.run import run_case

    path.unlink(missing_ok=True)
    try:
        run_case(case, {**opt, "fsi_output": str(path)}, comm)
    except ComputationError as error:
        table.failures[opt["fsi_order"], opt["fsi_h"]] = str(error)
        return
    if comm.rank == 0:
        with open_run(path) as run:
            names = {"points": "points", "steps": "steps", "evaluations": "rhs_evaluations", "wall_time": "wall_time"}
            table.put(*at, {name: run.summary[key] for name, key in names.items()}, {})


def _compare(folder: Path, table: ConvergenceStudy, i: int) -> None:
    """The differences of order i go into the table. InputError, FileError."""
    good = [j for j, h in enumerate(table.hs) if (table.orders[i], h) not in table.failures]
    with ExitStack() as stack:
        runs = {j: stack.enter_context(open_run(folder / f"{j}.h5")) for j in good}
        if not runs:
            return
        values = _common_values(list(runs.values()))
        power = {"L1": 1, "L2": 2}[table.norm]
        for j, k in zip(good, good[1:]):
            if k == j + 1:
                errors = _differences(values, good.index(j), power)
                table.put(i, j, {}, errors)


def _common_values(runs: list[Run]) -> dict[str, dict[str, list[Array]]]:
    """Group -> name -> values of each run at what all have in common. InputError where layers have nothing."""
    found: dict[str, dict[str, list[Array]]] = {}
    for k, layer in enumerate(runs[0].layers):
        layers = [run.layers[k] for run in runs]
        pairs = [_common_nodes(layer, other, []) for other in layers]
        if any(pair is None for pair in pairs):
            raise InputError(
                f"layer '{layer.name}': no node of the coarsest grid is on all others; "
                "-fsi_hs takes grids with common nodes, as in -fsi_hs 0.1,0.05,0.025"
            )
        axes = [_in_all(axis) for axis in zip(*(zip(*pair) for pair in pairs if pair is not None))]
        own = found[layer.name] = {}
        for name in layer.fields:
            ends = [other.frame(-1)[name] for other in layers]
            own[name] = [end[np.ix_(*(axis[j] for axis in axes))] for j, end in enumerate(ends)]
    times = runs[0].time[1:]
    for name in (n for n in runs[0].series if n not in NO_SOLUTION and not n.startswith("residual_")):
        values = [run.series[name][np.isin(run.series["t"], times)] for run in runs]
        if len({v.shape for v in values}) == 1 and values[0].size:
            found.setdefault("series", {})[name] = values
    return found


def _in_all(pairs: Any) -> list[Array]:
    """Of one axis: numbers of the nodes that all grids have, on each; pairs: (of the coarsest, of each)."""
    common = pairs[0][0]
    for first, _ in pairs:
        common = np.intersect1d(common, first)
    return [second[np.searchsorted(first, common)] for first, second in pairs]


def _differences(values: Mapping[str, Mapping[str, list[Array]]], j: int, power: int) -> dict[str, dict[str, float]]:
    """Group -> name -> difference between run j and the next, relative; and "combined", their mean."""
    found: dict[str, dict[str, float]] = {}
    for group, names in values.items():
        ranges: dict[str, float] = {}
        for name, runs in names.items():
            unit = _unit(name)
            ranges[unit] = max(ranges.get(unit, 0.0), _range(runs[-1]))
        own = found[group] = {}
        for name, runs in names.items():
            gap = np.abs(runs[j + 1] - runs[j])
            mean = float(np.mean(gap[np.isfinite(gap)] ** power)) if np.isfinite(gap).any() else np.nan
            own[name] = mean ** (1 / power) / (ranges[_unit(name)] or 1.0)
        own["combined"] = float(np.mean(np.array(list(own.values())) ** power) ** (1 / power))
    return found


def _unit(name: str) -> str:
    """Of a field or series; those without a name in the tables have a unit of their own."""
    return {**FIELDS, **INTEGRALS}.get(name, (name, ""))[0]


def _range(values: Array) -> float:
    """The largest less the smallest value; the largest size where all are the same but for round-off."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    largest, span = float(np.abs(known).max()), float(np.ptp(known))
    return span if span > 1e-9 * largest else largest


def unresolved(table: ConvergenceStudy, i: int) -> list[str]:
    """A line for each layer that its grids do not resolve: they differ by much, or come together slowly."""
    lines, op = [], operator(table.orders[i])
    expected = table.orders[i] // 2 + 1  # closures of half the order count one order more in the solution
    for group in table.errors:
        if group == "series":
            continue
        last, rates = table.errors[group]["combined"][i, -2], table.rates(group)[i]
        fields = {name: e[i, -2] for name, e in table.errors[group].items() if name != "combined"}
        worst = max(fields, key=lambda name: np.nan_to_num(fields[name]))
        rate = rates[-2]
        if last > COARSE:
            why = f"the two finest grids differ by {100 * fields[worst]:.0f} % of the range of {worst}"
        elif last > ROUND_OFF and not rate >= SLOW * expected:
            seen = f"of order {rate:.1f}" if np.isfinite(rate) else "of no order"
            why = f"its grids come together {seen}, where {op.name} has {expected} for smooth solutions"
        else:
            continue
        lines.append(f"layer '{group}' is not resolved: {why}; the worst is {worst}")
    return lines
