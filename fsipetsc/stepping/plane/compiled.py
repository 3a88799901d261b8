"""The compiled functions that the layers of a problem in two dimensions need, so that all can be compiled before it begins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.operators.formulas import Formulas
from fsipetsc.parallel.mpi import Requests
from fsipetsc.parallel.plane.fetch import exchange
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.scheme.burst import Notes
from fsipetsc.scheme.plane import entries
from fsipetsc.scheme.plane.equations import materials_of
from fsipetsc.scheme.plane.laws import compiled
from fsipetsc.stepping.plane.part import NO_FACTORS, NO_STAGE, OF_GAS, OF_SOLID

#: arguments of the types that entries get
_VALUES, _TABLE, _NUMBERS, _PLACES = np.empty(1), np.empty((1, 1)), np.empty(1, np.int64), np.empty((1, 1), np.int64)
_LINES, _STAGE = np.empty((2, 4, 1)), (*NO_STAGE, *NO_FACTORS)


def needed(
    layout: PlaneLayout, equations: Sequence[Formulas], faces: np.ndarray, operators: np.ndarray
) -> list[tuple[Any, tuple[Any, ...]]]:
    """(entry, arguments of the types that it gets), for all layers. equations: of each; faces: an INTERFACE array."""
    found = []
    layer = layout.records, 0
    common = *layer, operators, _VALUES
    line = operators, _TABLE, _VALUES, 1, 1, 1, 1, 1.0, _NUMBERS
    points = faces, 0, _TABLE, _NUMBERS
    settle = *layer, operators, _VALUES, _TABLE, _PLACES, _LINES, _VALUES, _PLACES, _TABLE, _TABLE
    for problem_layer, own in zip(layout.problem.layers, equations, strict=True):
        gas, law = problem_layer.kind == "fluid", materials_of(problem_layer)
        rates, look, save = OF_GAS if gas else OF_SOLID
        found += [
            (compiled(rates, own), (*common, _VALUES, _LINES, _VALUES, *_STAGE)),
            (compiled(look, law), (*common, _VALUES, _LINES, _VALUES, _VALUES, True)),
            (compiled(save, law), (*common, _VALUES, _LINES, _VALUES, np.empty((1, 1, 1)))),
            (compiled(entries.settle, law), settle),
        ]
        if gas:
            found += [(compiled(entries.meet_at, law), points)]
            found += [(compiled(entries.meet_sliding_at, law), (*points, *line))]
    requests, ending = Requests([]), (_TABLE, _PLACES, _PLACES, _VALUES, _VALUES, 0)
    fetched = _PLACES, _NUMBERS, _VALUES, requests.handles, requests.statuses, _NUMBERS, _VALUES, _VALUES, _PLACES
    return [
        *found,
        (exchange, (_VALUES, 0, *fetched)),
        (entries.end_stage, (*layer, operators, _VALUES, _VALUES, *ending, *_STAGE)),
        (entries.put_away_points, (layout.records, _VALUES, _NUMBERS, _NUMBERS, _VALUES)),
        (entries.put_away_others, (layout.records, _NUMBERS, np.empty((1, 1, 1)), _TABLE, _PLACES, _VALUES, _VALUES)),
        (entries.plan_next, (Notes(0, 0, 0, 0, 0), _VALUES)),
        (entries.account_of, (layout.records, _TABLE, _NUMBERS, _VALUES, _TABLE, _VALUES, _VALUES)),
        (entries.bounds_of, (_VALUES, 1, _VALUES, _VALUES)),
        (entries.advance_behind, (_VALUES, *NO_STAGE[:4], *NO_FACTORS)),
        (entries.grid_jacobian, (*common, _LINES, _TABLE)),
        (entries.edges_of, (*layer, operators, _VALUES, _VALUES)),
        (entries.line_normals, (operators, _TABLE, *line[1:])),
        (entries.slide_at, (faces, _PLACES, operators, _TABLE, _TABLE, _NUMBERS, _TABLE)),
    ]
