"""Opens the result file of a run, finished or not. Needs numpy and h5py only.

Example::

    with fsipetsc.open_run("rod.h5") as run:
        fluid, solid = run.layers[:2]
        frame = run.at(0.45)
        plt.plot(fluid.x[frame], fluid["T"][frame], solid.x[frame], solid["T"][frame])
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.checks import Array, counted
from fsipetsc.output import file_layout
from fsipetsc.output.interface_line import InterfaceLine, along_face
from fsipetsc.output.result_source import Damaged, Frames, Source, damage

if TYPE_CHECKING:
    import xarray


class Run:
    """A result. Arrays are read from the file when they are asked for, and then kept.

    case, options       name of the case; dict of every option in force
    header              what was known at the start: versions, ranks, created, …
    summary             steps, rhs_evaluations, wall_time (s) … of the whole run, part: since its last restart; points, ranks,
                        versions …; unfinished: the header's
    errors              layer kind -> name -> error at the end, L2 or as -fsi_norm says; empty where no exact solution is known
    complete            whether the run came to its end; if not, summary["status"] may say why
    time, nframes       (nframes,) times of the saved frames
    layers              tuple of :class:`Layer`, from left to right
    dimension           1, 2 or 3; in two `interface` has the lines between gas and solid
    blocks              of a problem of blocks name -> :class:`BlockLayer`, in 1 to 3 dimensions; else empty
    interfaces          their names, from left to right
    points              recorded at each step (-fsi_points, -fsi_probes): tuple of (name of the interface or block, (X, …))
    series              name -> (nsteps,) or (nsteps, m), one row per time step: "t", "dt", "x_interface", …

    Use it as a context manager or call `close`; what was read before stays usable.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        name = os.fspath(path)
        if name.endswith(".parts") and os.path.isdir(name):  # the pieces of a run that goes on or was killed
            name = f"{name.removesuffix('.parts')}.h5"
        self.path = os.path.abspath(name)
        with damage(os.fspath(path)):
            self._source = Source(self.path, name)
            try:
                self._read()
            except BaseException:
                self.close()
                raise

    def _read(self) -> None:
        self.header: dict[str, Any] = self._source.header
        _check_header(self.header)
        self.case: str = self.header["case"]
        self.options: dict[str, Any] = _Named("option", self.header["options"])
        self.interfaces: tuple[str, ...] = tuple(self.header.get("interfaces", ()))
        points = self.header.get("points", ())
        self.points: tuple[tuple[str, tuple[float, ...]], ...] = tuple((name, tuple(X)) for name, X in points)
        known: dict[str, Any] = {name: self.header[name] for name in ("versions", "ranks") if name in self.header}
        self.summary: dict[str, Any] = _Named("summary entry", {**known, **self._source.summary})
        self.complete = self._source.complete and self.summary.get("status", "done") == "done"
        errors = {kind: _Named("error", values) for kind, values in self._source.errors.items()}
        self.errors: dict[str, dict[str, float]] = _Named("layer kind with errors", errors)
        chunks = [self._source.frames(i) for i in range(len(self.header["layers"]))]
        time = self._source.time()
        self.nframes = min([len(time), *(_covered(c) for c in chunks)])
        self.time: Array = time[: self.nframes]
        if not np.all(np.isfinite(self.time)) or np.any(np.diff(self.time) < 0):
            raise Damaged("the times of its frames are not ascending numbers")
        self.dimension = int(self.header.get("dimension", 1))
        self.layers = tuple(
            self._layer(entry)(self.path, entry, own, self.nframes) for entry, own in zip(self.header["layers"], chunks)
        )
        self.blocks = _Named("block", {layer.name: layer for layer in self.layers if isinstance(layer, BlockLayer)})
        self.series: Mapping[str, Array] = Arrays(self.path, "series", self._source.series, self._source.column)

    def _layer(self, entry: Mapping[str, Any]) -> Any:
        """What kind of layer an entry of the header tells of."""
        return BlockLayer if "shape" in entry else Layer

    def at(self, t: float) -> int:
        """Number of the frame saved nearest to time t."""
        if not self.nframes:
            raise IndexError(f"{self.path} has no frames")
        return int(np.argmin(np.abs(self.time - t)))

    def interface(self, k: int | str) -> InterfaceLine:
        """Interface k (counted from below, or its name) of a run in two dimensions, over the frames: motion, traction, heat.

        KeyError or IndexError if there is none.
        """
        names = list(self.interfaces) if self.dimension == 2 else []
        if isinstance(k, str) and k not in names:
            raise KeyError(_unknown("line of an interface", k, names))
        number = names.index(k) if isinstance(k, str) else range(len(names))[k]
        solid, axis, side = self.header["interface_faces"][number]
        kappa_e = self.header["layers"][solid].get("kappa_e", np.nan)
        return along_face(names[number], solid, self.layers[solid], axis, side, kappa_e)

    def to_xarray(self) -> xarray.Dataset:
        """All frames and series with dimensions, coordinates and units; see :mod:`fsipetsc.output.as_xarray`."""
        from fsipetsc.output.as_xarray import to_xarray

        return to_xarray(self)

    def close(self) -> None:
        self._source.close()

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        span = f", t = {self.time[0]:g} … {self.time[-1]:g}" if self.nframes else ""
        state = "" if self.complete else ", unfinished"
        kinds = ", ".join(f"{layer.name} ({layer.size})" for layer in self.layers)
        return f"<Run {self.case!r}: {counted(self.nframes, 'frame')}{span}; {kinds}{state}>"


class Arrays(Mapping[str, Array]):
    """Named arrays that are read from the file when first asked for."""

    def __init__(self, path: str, what: str, names: Iterable[str], read: Callable[[str], Array]) -> None:
        self._path, self._what, self._read = path, what, read
        self._kept: dict[str, Array | None] = dict.fromkeys(names)

    def __getitem__(self, name: str) -> Array:
        if name not in self._kept:
            raise KeyError(_unknown(self._what, name, self._kept))
        values = self._kept[name]
        if values is None:
            with damage(self._path, name):
                values = self._kept[name] = self._read(name)
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._kept)

    def __len__(self) -> int:
        return len(self._kept)

    __eq__, __hash__ = object.__eq__, object.__hash__  # not that of Mapping, which compares all values

    def __repr__(self) -> str:
        return f"<{self._what}: {', '.join(self._kept)}>"


class Layer(Arrays):
    """A layer of a run; `layer[name]` is (nframes, n), NaN outside the active part.

    name, kind   kind is "fluid" or "solid"
    fields       names of what is stored: fluid rho, u, T, p, x; solid u, sigma, T, x, p
    X, h         (n,) Lagrangian grid, the largest one of the run if it has grown; its spacing
    x            (nframes, n) Eulerian positions
    """

    def __init__(self, path: str, entry: Mapping[str, Any], chunks: list[Frames], nframes: int) -> None:
        self.name: str = entry["name"]
        self.kind: str = entry["kind"]
        self.fields = file_layout.columns(entry)
        super().__init__(path, f"field in layer {self.name!r}", self.fields, self._read_field)
        self._nframes = nframes
        self._chunks = [chunk for chunk in chunks if chunk.first < nframes]
        for chunk in self._chunks:
            if chunk.dataset.shape != (len(chunk.X), chunk.count * len(self.fields)):
                raise Damaged(f"frames of layer {self.name!r} have the shape {chunk.dataset.shape}")
        self.X, self.h = _merge_grids(self._chunks)

    @property
    def x(self) -> Array:
        return self["x"]

    @property
    def size(self) -> str:
        """Of its grid, in words."""
        return counted(len(self.X), "point")

    def frame(self, number: int) -> dict[str, Array]:
        """All fields of one frame, name -> (n,): much cheaper than whole fields of a long run."""
        if not -self._nframes <= number < self._nframes:
            raise IndexError(f"frame {number}: there are {self._nframes}")
        number %= self._nframes
        chunk = next(c for c in self._chunks if c.first <= number < c.first + c.count)
        start = (number - chunk.first) * len(self.fields)
        values = np.full((len(self.fields), len(self.X)), np.nan)
        with damage(self._path, f"frame {number}"):
            values[:, chunk.place] = chunk.dataset[:, start : start + len(self.fields)].T
        return dict(zip(self.fields, values))

    def place(self, number: int) -> tuple[str, int, tuple[int, int]]:
        """Where frame `number` (from 0) stands: name of its dataset in the file, its first column, the dataset's shape."""
        chunk = next(c for c in self._chunks if c.first <= number < c.first + c.count)
        return chunk.dataset.name, (number - chunk.first) * len(self.fields), chunk.dataset.shape

    def _read_field(self, name: str) -> Array:
        column = self.fields.index(name)
        values = np.full((self._nframes, len(self.X)), np.nan)
        for chunk in self._chunks:
            last = min(chunk.first + chunk.count, self._nframes)
            frames = chunk.dataset[...].reshape(len(chunk.X), chunk.count, len(self.fields))
            values[chunk.first : last, chunk.place] = frames[:, : last - chunk.first, column].T
        return values

    def __repr__(self) -> str:
        span = f", X = {self.X[0]:g} … {self.X[-1]:g}" if len(self.X) else ""
        return f"<{self.kind} layer {self.name!r}: {self.size}{span}; {', '.join(self.fields)}>"


class BlockLayer(Arrays):
    """A block of a run in d dimensions; `block[name]` is (nframes, n_{d-1}, …, n_0).

    name, kind, fields   gas rho, u, v, w, T, p, J, x, y, z; solid u, v, w, T, stresses, x, y, z, as far as there are dimensions
    shape                (n_{d-1}, …, n_0)
    X, Y, Z              places in the reference map, of the same shape; where X depends on axis 0 alone, Y on axis 1 …, (n_0,),
                         (n_1,), …
    places, periodic     (…, d) the same as they are; whether axis 0, 1, … is periodic
    x, y, z              (nframes, …) positions
    """

    places: Array
    X: Array
    Y: Array
    Z: Array

    def __init__(self, path: str, entry: Mapping[str, Any], chunks: list[Frames], nframes: int) -> None:
        self._points = Layer(path, entry, chunks, nframes)
        self.name, self.kind, self.fields = self._points.name, self._points.kind, self._points.fields
        super().__init__(path, f"field in block {self.name!r}", self.fields, self._read_field)
        self.shape = tuple(int(n) for n in entry["shape"])
        d = len(self.shape)
        if not chunks:  # nor is anything known of the places
            self.places, self.periodic = np.empty((*(0,) * d, d)), (False,) * d
            self.X = self.Y = self.Z = np.empty(0)
            return
        places = chunks[0].places
        if places is None or places.shape != (math.prod(self.shape), d):
            raise Damaged(f"places of block {self.name!r} are missing")
        self.places = places.reshape(*self.shape, d)
        self.periodic = tuple(entry.get("periodic", [False] * d)[::-1])
        full = [self.places[..., axis] for axis in range(d)]
        self.X, self.Y, self.Z = _short(full) + [np.zeros(1)] * (3 - d)

    @property
    def rings(self) -> tuple[int, ...]:
        """Axes of the arrays along which the block closes where it begins, as an annulus does."""
        d, found = len(self.shape), []
        for axis in range(d):
            ends = [np.take(self.places, at, axis=axis) for at in (0, 1, -1)]
            step, gap = (np.linalg.norm(end - ends[0], axis=-1).max() for end in ends[1:])
            if self.periodic[d - 1 - axis] and gap < 3.0 * step:
                found.append(axis)
        return tuple(found)

    x = property(lambda self: self["x"])
    y = property(lambda self: self["y"])
    z = property(lambda self: self["z"])

    @property
    def h(self) -> float:
        """Mean spacing [m] of X along axis 0."""
        X = self.X if self.X.ndim == 1 else self.X.reshape(-1, self.shape[-1])[0]
        return float(X[-1] - X[0]) / max(1, len(X) - 1)

    @property
    def size(self) -> str:
        """Of its grid, in words."""
        return f"{' by '.join(map(str, self.shape[::-1]))} points"

    def frame(self, number: int) -> dict[str, Array]:
        """All fields of one frame, name -> (n_{d-1}, …, n_0)."""
        return {name: values.reshape(self.shape) for name, values in self._points.frame(number).items()}

    def place(self, number: int) -> tuple[str, int, tuple[int, int]]:
        """As of a Layer."""
        return self._points.place(number)

    def _read_field(self, name: str) -> Array:
        return self._points[name].reshape(-1, *self.shape)

    def __repr__(self) -> str:
        return f"<{self.kind} block {self.name!r}: {self.size}; {', '.join(self.fields)}>"


def _short(places: list[Array]) -> list[Array]:
    """Coordinates as arrays along their own axes, if each depends on its own axis alone."""
    d = len(places)
    lines = []
    for axis, values in enumerate(places):
        own = d - 1 - axis  # the axis of the array
        line = values[tuple(slice(None) if k == own else 0 for k in range(d))]
        shape = [-1 if k == own else 1 for k in range(d)]
        if not np.allclose(values, line.reshape(shape), rtol=0.0, atol=1e-12 * np.ptp(values)):
            return places
        lines.append(line)
    return lines


class _Named(dict[str, Any]):
    """A dict that says what it holds when asked for something else."""

    def __init__(self, what: str, content: Mapping[str, Any]) -> None:
        super().__init__(content)
        self._what = what

    def __missing__(self, name: str) -> Any:
        raise KeyError(_unknown(self._what, name, self))


def open_run(path: str | os.PathLike[str]) -> Run:
    """Open a result file. Raises FileError if there is none, it is not a result of fsipetsc, or it is damaged."""
    return Run(path)


def _check_header(header: Mapping[str, Any]) -> None:
    """Raise Damaged if what the reader and its users rely on is not there, or something else."""

    def texts(values: Any) -> bool:
        return isinstance(values, (list, tuple)) and all(isinstance(value, str) for value in values)

    layers, names = header.get("layers"), ("interfaces", "notes")
    good = isinstance(header.get("case"), str) and isinstance(header.get("options"), dict) and isinstance(layers, list)
    good = good and all(texts(header.get(name, ())) for name in names) and isinstance(header.get("created", ""), str)
    good = good and all(isinstance(name, str) and len(X) >= 0 for name, X in header.get("points", ()))
    for layer in layers if good and layers else ():
        good = good and isinstance(layer["name"], str) and layer["kind"] in ("fluid", "solid")
        good = good and texts(layer["fields"]) and len(layer["fields"]) > 0
        shape = layer.get("shape", [1])
        good = good and isinstance(shape, list) and all(type(n) is int and 0 < n for n in shape) and len(shape) <= 3
    if not good:
        raise Damaged("its header does not tell case, options and layers")


def _covered(chunks: list[Frames]) -> int:
    """Number of frames from the first on that are there without a gap."""
    n = 0
    for chunk in chunks:
        if chunk.first == n:
            n += chunk.count
    return n


def _merge_grids(chunks: list[Frames]) -> tuple[Array, float]:
    """The grid that contains all of them, and its spacing; sets the chunks' places in it."""
    if not chunks:
        return np.empty(0), np.nan
    grids = {id(chunk.X): chunk.X for chunk in chunks}.values()
    longest = max(grids, key=len)
    h = float(longest[-1] - longest[0]) / (len(longest) - 1) if len(longest) > 1 else np.nan
    left = min(grid[0] for grid in grids)

    def place(grid: Array) -> slice:
        start = round((grid[0] - left) / h) if len(longest) > 1 else 0
        return slice(start, start + len(grid))

    merged = np.full(max(place(grid).stop for grid in grids), np.nan)
    for grid in sorted(grids, key=len):
        merged[place(grid)] = grid
    if any(np.max(np.abs(merged[place(grid)] - grid)) > 0.01 * h for grid in grids) or np.isnan(merged).any():
        raise Damaged("its grids do not fit together")
    for chunk in chunks:
        chunk.place = place(chunk.X)
    return merged, h


def _unknown(what: str, name: object, valid: Iterable[str]) -> str:
    return f"there is no {what} {name!r}; there are: {', '.join(map(str, valid)) or 'none'}"
