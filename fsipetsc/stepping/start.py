"""A run that begins with a frame of an earlier result, on whatever grid: -fsi_initial.

The initial data of the case's layers are replaced by functions that interpolate those of the frame, and time goes on from the
frame's. All that a frame does not hold follows as it does from data of a case: J from where the ends of a gas are, kinetic
energies of end points from velocities, ghost points from the conditions there. In two dimensions it holds J.

Between points stand splines (scipy.interpolate.make_interp_spline) of a degree one above the order of the scheme, so that
second derivatives have its order; at points that frame and grid have in common stands what the frame has. They are in the
layers' reference coordinates, of a gas in one dimension in x, of which each mapping of it is a linear function.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from mpi4py import MPI

from fsipetsc import given
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.boundaries import in_time
from fsipetsc.errors import InputError
from fsipetsc.output.reader import open_run
from fsipetsc.parallel.layout import ghost_index
from fsipetsc.plane import PlaneProblem
from fsipetsc.problem import FluidLayer, Problem
from fsipetsc.process.together import together

if TYPE_CHECKING:
    from scipy.interpolate import BSpline  # when it is used: its import is a fifth of the start of a run

Array = np.ndarray
#: what is taken of a frame
_TAKEN = {
    (1, "fluid"): ("rho", "u", "T", "x"),
    (1, "solid"): ("u", "sigma", "T", "x"),
    (2, "fluid"): ("rho", "u", "v", "T", "J"),
    (2, "solid"): ("u", "v", "T", "x", "y"),
}
#: distances, as fractions of a cell, within which points are the same, and of a layer, within which its ends are
_SAME, _ALIKE = 1e-9, 1e-6
#: a time [s] around that of the frame in which the motion of walls may be asked for
_INSTANT = 1e-6


@dataclass(frozen=True)
class Start:
    """What a run begins with instead of the case's data.

    problem: the case's, with other functions ``initial``. t: time [s]. line: what is to be said of it. cells: layer -> ghost
    index of gases on rigid grids, for fsipetsc.parallel.layout.make_grids. jacobians: in two dimensions, layer -> function
    of X and Y that gives J of a gas in a list.
    """

    problem: Problem | PlaneProblem
    t: float
    line: str
    cells: Mapping[int, int]
    jacobians: Mapping[int, Callable[[Array, Array], list[Array]]]


@dataclass(frozen=True)
class _Frame:
    """Of a result. layers: kind, reference coordinates of the points, (X,) or (X, Y), and fields by name, at active points."""

    place: str
    t: float
    dimension: int
    layers: list[tuple[str, tuple[Array, ...], dict[str, Array]]]


def find_start(problem: Problem | PlaneProblem, opt: Mapping[str, Any], comm: MPI.Comm) -> Start | None:
    """What -fsi_initial asks for, if anything. Collective. FileError; InputError where the frame does not fit the case."""
    if opt["fsi_initial"] is None:
        return None
    if isinstance(problem, RunProblem):
        raise InputError("-fsi_initial: a problem of blocks begins with the data of its case")
    frame = comm.bcast(together(comm, lambda: _read(opt) if comm.rank == 0 else None))
    s = problem.unit("s")
    if not frame.t < opt["ts_max_time"]:
        end = f"-ts_max_time {opt['ts_max_time']:g}{s}"
        raise InputError(f"{end}: expected more than t = {frame.t:g}{s}, at which the run begins, that of {frame.place}")
    layers, cells, jacobians = together(comm, lambda: _fitted(problem, frame, opt))
    line = f"begins with {frame.place}, t = {frame.t:.6g}{s}"
    return Start(replace(problem, layers=layers, notes=(*problem.notes, line)), frame.t, line, cells, jacobians)


def _fitted(problem: Problem | PlaneProblem, frame: _Frame, opt: Mapping[str, Any]) -> tuple[tuple[Any, ...], dict, dict]:
    """Layers that begin with what the frame has, and what else Start has. InputError."""
    _check_layers(problem, frame)
    if isinstance(problem, PlaneProblem):
        layers, jacobians = _plane_layers(problem, frame, opt["fsi_order"])
        return layers, {}, jacobians
    return *_layers(problem, frame, opt["fsi_order"], opt["fsi_h"], opt["fsi_mapping"]), {}


def _read(opt: Mapping[str, Any]) -> _Frame:
    """The frame that is asked for. FileError, InputError."""
    path, number, t = (opt[name] for name in ("fsi_initial", "fsi_initial_frame", "fsi_initial_time"))
    with open_run(path) as run:
        count = run.nframes
        if not count:
            raise InputError(f"-fsi_initial {path}: it has no frames")
        if number is not None and not -count <= number < count:
            raise InputError(f"-fsi_initial_frame {number}: {path} has the frames 0 to {count - 1}, or -{count} to -1")
        chosen = (run.at(t) if t is not None else -1 if number is None else number) % count
        place, layers = f"frame {chosen} of {path}", []
        for layer in run.layers:
            found = layer.frame(chosen)
            points = (layer.X,) if run.dimension == 1 else (layer.X, layer.Y)
            fields = {name: found[name] for name in _TAKEN[run.dimension, layer.kind]}
            if run.dimension == 1:
                active = np.flatnonzero(np.isfinite(fields["x"]))
                span = slice(active[0], active[-1] + 1) if active.size else slice(0)
                points, fields = (layer.X[span],), {name: values[span] for name, values in fields.items()}
            for name, values in fields.items():
                good = np.isfinite(values) & ((values > 0) | (name not in ("rho", "T", "J")))
                if not values.size or not good.all():
                    worst = values[~good][0] if values.size else np.nan
                    raise InputError(f"-fsi_initial: {place}: {name} of layer '{layer.name}' is {worst:g}; take an earlier one")
            layers.append((layer.kind, points, fields))
        return _Frame(place, float(run.time[chosen]), run.dimension, layers)


def _check_layers(problem: Problem | PlaneProblem, frame: _Frame) -> None:
    """InputError for other kinds of layers, or others that reach from elsewhere to elsewhere."""
    if problem.dimension != frame.dimension:
        raise InputError(f"-fsi_initial: {frame.place} has {frame.dimension} dimension(s), the case {problem.dimension}")
    kinds, there = [layer.kind for layer in problem.layers], [kind for kind, _, _ in frame.layers]
    if kinds != there:
        raise InputError(f"-fsi_initial: {frame.place} has the layers {', '.join(there)}; the case has {', '.join(kinds)}")
    for k, (layer, (kind, points, _)) in enumerate(zip(problem.layers, frame.layers, strict=True)):
        if isinstance(problem, PlaneProblem):
            spans = {"X": problem.span(k), "Y": layer.Y}
        else:  # of gases beside solids X says nothing that these do not
            spans = {"X": layer.X} if kind == "solid" or len(kinds) == 1 else {}
        for (name, (a, b)), at in zip(spans.items(), points):
            beyond = (at[-1] - at[0]) / (len(at) - 1) if name == "X" and getattr(problem, "periodic", False) else 0.0
            if max(abs(at[0] - a), abs(at[-1] + beyond - b)) > _ALIKE * (b - a):
                found = f"reaches from {name} = {at[0]:g} to {at[-1]:g}"
                wanted = f"from {a:g} to {b:g}" + (", and is periodic" if beyond else "")
                raise InputError(f"-fsi_initial: {frame.place}: layer {k + 1}, a {kind}, {found}; '{layer.name}' {wanted}")


# one dimension


def _layers(problem: Problem, frame: _Frame, order: int, h: float, mapping: str) -> tuple[tuple[Any, ...], dict[int, int]]:
    """Layers that begin with what the frame has, and ghost indices of rigid gases. InputError where an end stands elsewhere."""
    layers, cells, last = [], {}, len(problem.layers) - 1
    for k, (layer, (_, (X,), fields)) in enumerate(zip(problem.layers, frame.layers, strict=True)):
        columns = np.stack([*fields.values()], axis=-1)
        if not isinstance(layer, FluidLayer):
            layers.append(replace(layer, initial=_Solid(columns, X, order)))
            continue
        x, ends = fields["x"], []
        for side, neighbour in ((0, k - 1), (1, k + 1)):
            if 0 <= neighbour <= last:
                ends.append(float(frame.layers[neighbour][2]["x"][side - 1]))
            else:
                ends.append(_outer_end(problem, side, x, frame))
        stretched = problem.is_stretched(k, mapping)
        if not stretched:
            cells[k] = ghost_index((ends[1] - ends[0]) / h)
        begin, slope = (layer.X[0], (ends[1] - ends[0]) / (layer.X[1] - layer.X[0])) if stretched else (layer.X[k == 0], 1.0)
        place = ends[0] if stretched or k > 0 else ends[1]
        layers.append(replace(layer, initial=_Gas(columns[:, :3], x, order, begin, place, slope)))
    return tuple(layers), cells


def _outer_end(problem: Problem, side: int, x: Array, frame: _Frame) -> float:
    """Where an outer end of a gas stands [m]; InputError if that is not where the frame has it, x: of its points."""
    end = (problem.left, problem.right)[side]
    moves = "x" in in_time(end)
    place = given.end_motion(problem, side, frame.t, _INSTANT)[0] if moves else float(end.x)
    cell = (x[-1] - x[0]) / (len(x) - 1)
    beyond = (x[-1] - place if side else place - x[0]) / cell  # a ghost point may stand behind it
    if not -_ALIKE * len(x) <= beyond <= 1.0 + _ALIKE * len(x):
        name = f"the {('left', 'right')[side]} end"
        raise InputError(f"-fsi_initial: {name} stands at x = {place:g}; in {frame.place} the gas reaches to {x[-side]:g}")
    return place


@dataclass(frozen=True)
class _Solid:
    """initial(X) of a solid: columns (n, fields) at the points at."""

    columns: Array
    at: Array
    order: int

    def __call__(self, X: Array) -> list[Array]:
        return list(interpolated(self.columns, _counted(X, self.at), self.order).T)


@dataclass(frozen=True)
class _Gas:
    """initial(X) of a gas: columns (n, fields) at the places x = at; X lies at place + slope (X - begin)."""

    columns: Array
    at: Array
    order: int
    begin: float
    place: float
    slope: float

    def __call__(self, X: Array) -> list[Array]:
        places = _counted(self.place + self.slope * (X - self.begin), self.at)
        inside = np.clip(places, 0, len(self.at) - 1)  # what is beyond will be made from inside
        return list(interpolated(self.columns, inside, self.order).T)


def _counted(x: Array, at: Array) -> Array:
    """Coordinates in points, from those of equally spaced points."""
    return (x - at[0]) / (at[-1] - at[0]) * (len(at) - 1)


def interpolated(values: Array, places: Array, order: int) -> Array:
    """(m, fields) at places (m,), counted in points, of values (n, fields) there."""
    nodes, on = _nodes(places, len(values), False)
    if on.all():
        return values[nodes]
    found = _spline(values, order)(places)
    found[on] = values[nodes[on]]
    return found


def _nodes(places: Array, count: int, periodic: bool) -> tuple[Array, Array]:
    """Numbers of the nearest points, and whether places are these."""
    nearest = np.rint(places).astype(int)
    on = np.abs(places - nearest) <= _SAME
    return nearest % count if periodic else np.clip(nearest, 0, count - 1), on


def _spline(values: Array, order: int, periodic: bool = False) -> BSpline:
    """Through values at 0, 1, … along the first axis."""
    if periodic:
        values = np.concatenate([values, values[:1]])
    count = len(values)
    degree = min(order + 1, count - 1 - count % 2)  # odd, and with points enough
    from scipy.interpolate import make_interp_spline

    return make_interp_spline(np.arange(count), values, degree, bc_type="periodic" if periodic else None)


# two dimensions


def _plane_layers(problem: PlaneProblem, frame: _Frame, order: int) -> tuple[tuple[Any, ...], dict[int, Any]]:
    """Layers that begin with what the frame has, and J of gases."""
    layers, jacobians = [], {}
    for k, (layer, (kind, points, fields)) in enumerate(zip(problem.layers, frame.layers, strict=True)):
        planes = dict(fields)
        if kind == "solid":  # what of places is periodic are displacements
            planes["x"], planes["y"] = fields["x"] - points[0], fields["y"] - points[1][:, None]
        else:
            jacobians[k] = _Plane(planes.pop("J").T[..., None], points, order, problem.periodic)
        layers.append(replace(layer, initial=_Plane(np.stack([*planes.values()]).T, points, order, problem.periodic)))
    return tuple(layers), jacobians


@dataclass(frozen=True)
class _Plane:
    """initial(X, Y) of a layer in two dimensions, X, Y of rows and columns of a grid: values (nx, ny, fields) at the points."""

    values: Array
    points: tuple[Array, Array]
    order: int
    periodic: bool

    def __call__(self, X: Array, Y: Array) -> list[Array]:
        columns, rows = _counted(X[0], self.points[0]), _counted(Y[:, 0], self.points[1])
        found = list(between(self.values, columns, rows, self.order, self.periodic).T)
        if len(found) == len(_TAKEN[2, "solid"]):
            found[3:] = found[3] + X, found[4] + Y
        return found


def between(values: Array, columns: Array, rows: Array, order: int, periodic: bool) -> Array:
    """(l, m, fields) at columns (l,) and rows (m,), counted in points, of values (nx, ny, fields) there.

    Splines go through all values, so that each number is the same however few are asked for.
    """
    column, on_column = _nodes(columns, values.shape[0], periodic)
    row, on_row = _nodes(rows, values.shape[1], False)
    if on_column.all() and on_row.all():
        return values[np.ix_(column, row)]
    along = _spline(values, order, periodic)
    in_rows = np.moveaxis(along.c, 1, 0)
    lines = _spline(in_rows, order)(rows)
    lines[on_row] = in_rows[row[on_row]]
    found = type(along)(along.t, np.moveaxis(lines, 1, 0), along.k)(columns)
    found[np.ix_(on_column, on_row)] = values[np.ix_(column[on_column], row[on_row])]
    return found
