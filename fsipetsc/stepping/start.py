"""A run that begins with a frame of an earlier result, on whatever grid: -fsi_initial.

The initial data of the case's layers are replaced by functions that interpolate those of the frame, and time goes on from the
frame's. All that a frame does not hold follows as it does from data of a case: ghost points from the conditions there. Of
blocks: fsipetsc.blockrun.start_of_blocks.

Between points stand splines; at points that frame and grid have in common stands what the frame has. They are in the layers'
reference coordinates, of a gas in x.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.blockrun.start_of_blocks import BlockFrame, begun_with, block_frame
from fsipetsc.errors import InputError
from fsipetsc.output.reader import open_run
from fsipetsc.paper.layout import ghost_index
from fsipetsc.problem import FluidLayer, Problem
from fsipetsc.process.together import together
from fsipetsc.stepping.splines import interpolated

Array = np.ndarray
#: what is taken of a frame
_TAKEN = {"fluid": ("rho", "u", "T", "x"), "solid": ("u", "sigma", "T", "x")}
#: distance, as a fraction of a layer, within which its ends are the same
_ALIKE = 1e-6


@dataclass(frozen=True)
class Start:
    """What a run begins with instead of the case's data.

    problem: the case's, with other functions ``initial``. t: time [s]. line: what is to be said of it. cells: layer -> ghost
    index of gases, for fsipetsc.paper.layout.make_grids.
    """

    problem: Problem | RunProblem
    t: float
    line: str
    cells: Mapping[int, int]


@dataclass(frozen=True)
class _Frame:
    """Of a result. layers: kind, X of the points, and fields by name, at active points; of blocks BlockFrames."""

    place: str
    t: float
    dimension: int
    layers: list[Any]


def find_start(problem: Problem | RunProblem, opt: Mapping[str, Any], comm: MPI.Comm) -> Start | None:
    """What -fsi_initial asks for, if anything. Collective. FileError; InputError where the frame does not fit the case."""
    if opt["fsi_initial"] is None:
        return None
    frame = comm.bcast(together(comm, lambda: _read(opt) if comm.rank == 0 else None))
    s = problem.unit("s")
    if not frame.t < opt["ts_max_time"]:
        end = f"-ts_max_time {opt['ts_max_time']:g}{s}"
        raise InputError(f"{end}: expected more than t = {frame.t:g}{s}, at which the run begins, that of {frame.place}")
    line = f"begins with {frame.place}, t = {frame.t:.6g}{s}"
    fitted, cells = together(comm, lambda: _fitted(problem, frame, opt, (*problem.notes, line)))
    return Start(fitted, frame.t, line, cells)


def _fitted(
    problem: Problem | RunProblem, frame: _Frame, opt: Mapping[str, Any], notes: tuple[str, ...]
) -> tuple[Problem | RunProblem, dict[int, int]]:
    """The problem that begins with what the frame has, and ghost indices of gases. InputError."""
    if problem.dimension != frame.dimension:
        raise InputError(f"-fsi_initial: {frame.place} has {frame.dimension} dimension(s), the case {problem.dimension}")
    if isinstance(problem, RunProblem) != isinstance(frame.layers[0], BlockFrame):
        ways = "conservative", "projection, energy or traditional"
        there, here = ways if isinstance(frame.layers[0], BlockFrame) else ways[::-1]
        raise InputError(
            f"-fsi_initial: {frame.place} is of -fsi_coupling {there}, this run of {here}: "
            "expected the same method"
        )
    if isinstance(problem, RunProblem):
        return begun_with(problem, frame.layers, opt["fsi_order"], frame.place, notes), {}
    _check_layers(problem, frame)
    layers, cells = _layers(problem, frame, opt["fsi_order"], opt["fsi_h"])
    return replace(problem, layers=layers, notes=notes), cells


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
        if run.blocks:
            layers = [block_frame(layer, chosen, place) for layer in run.layers]
            return _Frame(place, float(run.time[chosen]), run.dimension, layers)
        for layer in run.layers:
            found = layer.frame(chosen)
            active = np.flatnonzero(np.isfinite(found["x"]))
            span = slice(active[0], active[-1] + 1) if active.size else slice(0)
            points, fields = layer.X[span], {name: found[name][span] for name in _TAKEN[layer.kind]}
            for name, values in fields.items():
                good = np.isfinite(values) & ((values > 0) | (name not in ("rho", "T")))
                if not values.size or not good.all():
                    worst = values[~good][0] if values.size else np.nan
                    raise InputError(f"-fsi_initial: {place}: {name} of layer '{layer.name}' is {worst:g}; take an earlier one")
            layers.append((layer.kind, points, fields))
        return _Frame(place, float(run.time[chosen]), run.dimension, layers)


def _check_layers(problem: Problem, frame: _Frame) -> None:
    """InputError for other kinds of layers, or others that reach from elsewhere to elsewhere."""
    kinds, there = [layer.kind for layer in problem.layers], [kind for kind, _, _ in frame.layers]
    if kinds != there:
        raise InputError(f"-fsi_initial: {frame.place} has the layers {', '.join(there)}; the case has {', '.join(kinds)}")
    for k, (layer, (kind, at, _)) in enumerate(zip(problem.layers, frame.layers, strict=True)):
        if kind == "fluid" and len(kinds) > 1:
            continue  # of gases beside solids X says nothing that these do not
        a, b = layer.X
        if max(abs(at[0] - a), abs(at[-1] - b)) > _ALIKE * (b - a):
            found = f"reaches from X = {at[0]:g} to {at[-1]:g}; '{layer.name}' from {a:g} to {b:g}"
            raise InputError(f"-fsi_initial: {frame.place}: layer {k + 1}, a {kind}, {found}")


def _layers(problem: Problem, frame: _Frame, order: int, h: float) -> tuple[tuple[Any, ...], dict[int, int]]:
    """Layers that begin with what the frame has, and ghost indices of gases. InputError where an end stands elsewhere."""
    layers, cells, last = [], {}, len(problem.layers) - 1
    for k, (layer, (_, X, fields)) in enumerate(zip(problem.layers, frame.layers, strict=True)):
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
        cells[k] = ghost_index((ends[1] - ends[0]) / h)
        place = ends[0] if k > 0 else ends[1]
        layers.append(replace(layer, initial=_Gas(columns[:, :3], x, order, layer.X[k == 0], place)))
    return tuple(layers), cells


def _outer_end(problem: Problem, side: int, x: Array, frame: _Frame) -> float:
    """Where an outer end of a gas stands [m]; InputError if that is not where the frame has it, x: of its points."""
    end = (problem.left, problem.right)[side]
    place = float(end.x)
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
    """initial(X) of a gas: columns (n, fields) at the places x = at; X lies at place + X - begin."""

    columns: Array
    at: Array
    order: int
    begin: float
    place: float

    def __call__(self, X: Array) -> list[Array]:
        places = _counted(self.place + X - self.begin, self.at)
        inside = np.clip(places, 0, len(self.at) - 1)  # what is beyond will be made from inside
        return list(interpolated(self.columns, inside, self.order).T)


def _counted(x: Array, at: Array) -> Array:
    """Coordinates in points, from those of equally spaced points."""
    return (x - at[0]) / (at[-1] - at[0]) * (len(at) - 1)
