"""Values between points, by splines through all of them: each number is the same however few are asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.interpolate import BSpline  # when it is used: its import is a fifth of the start of a run

Array = np.ndarray
#: distance, in cells, within which points are the same
_SAME = 1e-9


def interpolated(values: Array, places: Array, order: int, periodic: bool = False) -> Array:
    """(m, fields) at places (m,), counted in points, of values (n, fields) there.

    The degree is one above the order, so that second derivatives have the order of the scheme.
    """
    nodes, on = _nodes(places, len(values), periodic)
    if on.all():
        return values[nodes]
    found = _spline(values, order, periodic)(places)
    found[on] = values[nodes[on]]
    return found


def _nodes(places: Array, count: int, periodic: bool) -> tuple[Array, Array]:
    """Numbers of the nearest points, and whether places are these."""
    nearest = np.rint(places).astype(int)
    on = np.abs(places - nearest) <= _SAME
    return nearest % count if periodic else np.clip(nearest, 0, count - 1), on


def _spline(values: Array, order: int, periodic: bool) -> BSpline:
    """Through values at 0, 1, … along the first axis."""
    if periodic:
        values = np.concatenate([values, values[:1]])
    count = len(values)
    degree = min(order + 1, count - 1 - count % 2)  # odd, and with points enough
    from scipy.interpolate import make_interp_spline

    return make_interp_spline(np.arange(count), values, degree, bc_type="periodic" if periodic else None)
