"""Opens the result of a run, finished or not. Needs numpy and h5py only."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.checks import Array, counted
from fsipetsc.errors import FileError
from fsipetsc.output import file_layout as layout
from fsipetsc.output.quantities import unit_of
from fsipetsc.scheme.observables import SERIES


class Run(AbstractContextManager["Run"]):
    """A result, as `open_run` and `run` return it.

    Fields are read from the file when they are asked for, and then kept: FileError if another run
    has replaced it. No file stays open, so as a context manager it does nothing.

    Attributes:
        case: name of the case.
        options: name -> value of every option in force.
        header: what was known at the start: versions, ranks, created …
        summary: steps, rhs_evaluations, wall_time [s] …; versions and ranks, also before the end.
        errors: layer kind -> name -> error at the end, in the norm of `-fsi_norm`; empty where no
            exact solution is known.
        complete: whether the run came to its end; if not, `summary["status"]` may say why.
        time: (nframes,) times of the saved frames [s].
        nframes: how many frames are saved.
        layers: the layers from left to right, or the blocks in the order of the case.
        blocks: name -> the same layers.
        dimension: 1, 2 or 3.
        interfaces: names of the interfaces, from left to right.
        points: (name of the block, (X, …) [m]) of each node that `-fsi_probes` records.
        faces: columns of the series `energy_face` and `heat_face`: faces of blocks that no other
            one meets, and "through no face".
        series: name -> (nsteps,) or (nsteps, m), a row for each time step: `t`, `dt`,
            `x_interface` …; `python -m fsipetsc info` lists them.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        whole = Path(os.path.abspath(path))
        if whole.suffix == ".parts":  # of a run that goes on or was killed
            whole = whole.with_suffix(".h5")
        self.path = str(whole)
        found = layout.pieces(layout.beside(whole, ".parts"))  # before it is asked for the whole
        found = [whole] if whole.exists() or not found else found
        self._files: list[tuple[Path, Any, int]] = []  # their stamps, how many frames they have
        nodes, times, series = list[Array](), list[Array](), dict[str, list[Array]]()
        for piece in found:
            with layout.opened(piece, layout.RESULT) as (file, about):
                layers = about["header"]["layers"]
                times.append(layout.numbers(file["time"]))
                self._files.append((piece, layout.stamp_of(file), len(times[-1])))
                if "series" in file:
                    group, steps = file["series"], len(file["series/t"])
                    # a list: HDF5, asked for names, crashes where a byte of many names has changed
                    for name in map(bytes.decode, group.attrs[layout.NAMES]):
                        series.setdefault(name, []).append(layout.numbers(group[name], steps))
                for k, of in enumerate(layers if "layer0/X" in file and not nodes else ()):
                    nodes.append(layout.numbers(file[f"layer{k}/X"], math.prod(of["shape"])))
        with layout.damage(self.path):
            self.time = np.concatenate(times)
            self.nframes = len(self.time)
            self.series = {name: np.concatenate(values) for name, values in series.items()}
            self.header: dict[str, Any] = (header := about["header"])
            self.case: str = header["case"]
            self.options: dict[str, Any] = header["options"]
            self.interfaces: tuple[str, ...] = tuple(header.get("interfaces", ()))
            self.faces: tuple[str, ...] = tuple(header.get("faces", ()))
            self.points = tuple((name, tuple(X)) for name, X in header.get("points", ()))
            end = about.get("summary", {})
            self.complete = bool(end) and end.get("status", "done") == "done"
            self.summary: dict[str, Any] = end | {k: header[k] for k in ("ranks", "versions")}
            self.errors: dict[str, dict[str, float]] = about.get("errors", {})
            self.dimension = int(header.get("dimension", 1))
            unknown = [np.full((*of["shape"], len(of["shape"])), np.nan) for of in layers]
            every = enumerate(zip(layers, nodes or unknown))  # without frames grids are not known
            self.layers = tuple(Layer(self, k, *of) for k, of in every)
            self.blocks: dict[str, Layer] = {layer.name: layer for layer in self.layers}
            #: what columns of series may be of -> the names of these
            self.columns: dict[str, list[str]] = {
                "interface": [*self.interfaces],
                "gas": [layer.name for layer in self.layers if layer.kind == "fluid"],
                "layer": [*self.blocks],
                "face": [*self.faces],
                "point": [f"{name} at {', '.join(f'{x:g}' for x in X)}" for name, X in self.points],
            }

    def _need_frames(self) -> None:
        """FileError if no frame is saved, as of a run that was killed at its start."""
        if not self.nframes:
            raise FileError(f"{self.path}: no frame is saved in it")

    def at(self, t: float) -> int:
        """Return the number of the frame saved nearest to time t [s]. FileError: there is none."""
        self._need_frames()
        return int(np.argmin(np.abs(self.time - t)))

    def interface(self, k: int | str) -> InterfaceLine:
        """Return the line of an interface in two dimensions, by its number or name. KeyError."""
        names = self.interfaces if self.dimension == 2 else ()
        if k not in (*names, *range(-len(names), len(names))):
            raise KeyError(f"there is no interface {k!r} with a line; there are: {names}")
        number = names.index(k) if isinstance(k, str) else k
        return InterfaceLine(self, names[number], *self.header["interface_faces"][number])

    def to_xarray(self) -> Any:
        """Return all frames and series as an xarray Dataset, with dimensions, coordinates, units.

        Fields are "LAYER.FIELD" of the dimensions time (Z_LAYER, Y_LAYER,) X_LAYER, with _ for a
        blank in LAYER, positions are coordinates, series "series.NAME" of the dimension step.
        """
        import xarray

        def about(name: str) -> dict[str, str]:
            return {"units": unit} if (unit := unit_of(name, self)) else {}

        variables: dict[str, Any] = {}
        coordinates: dict[str, Any] = {"time": ("time", self.time, about("t"))}
        for layer in self.layers:
            name, axes = "_".join(layer.name.split()), "XYZ"[: len(layer.shape)]
            dimensions = [f"{axis}_{name}" for axis in axes[::-1]]
            for axis in axes:
                X, of_axis = getattr(layer, axis), f"{axis}_{name}"
                key, along = (of_axis, of_axis) if X.ndim == 1 else (f"{name}.{axis}", dimensions)
                coordinates[key] = along, X, about("x")
            for field in layer.fields:
                where = coordinates if field in "xyz" else variables
                where[f"{name}.{field}"] = ["time", *dimensions], layer[field], about(field)
        for series, values in self.series.items():
            of = [SERIES[series].of] * (values.ndim - 1)
            coordinates |= {column: (column, self.columns[column]) for column in of}
            variables[f"series.{series}"] = ["step", *of], values, about(series)
        if "t" in self.series:
            coordinates["t"] = "step", self.series["t"], about("t")
        options = {f"-{name}": str(of) for name, of in self.options.items() if of is not None}
        attributes = {"case": self.case, "complete": int(self.complete), **options}
        return xarray.Dataset(variables, coordinates, attributes)

    def close(self, *_: object) -> None:
        """Do nothing: files are open only while something is read."""

    __exit__ = close

    def __repr__(self) -> str:
        span = f", t = {self.time[0]:g} … {self.time[-1]:g}" if self.nframes else ""
        kinds = ", ".join(f"{layer.name} ({layer.size})" for layer in self.layers)
        about = f"{counted(self.nframes, 'frame')}{span}; {kinds}"
        return f"<Run {self.case!r}: {about}{', unfinished' * (not self.complete)}>"


class Layer(Mapping[str, Array]):
    """A layer or block of a result in d dimensions: a mapping from names of fields to arrays.

    `layer[name]` has the shape (nframes, n_{d-1}, …, n_0); axis 0 is the last one. Units are SI.
    Points in reserve, of the paper's method, are NaN. KeyError for a field that there is not;
    FileError where the file is damaged.

    Attributes:
        name: name of the layer.
        kind: "fluid" or "solid".
        fields: names: of a gas rho, u, v, w, T, p, J (volume of the grid over that at rest), x, y,
            z; of a solid u, v, w, T, stresses, x, y, z; of layers u, sigma, T, x, p.
        shape: (n_{d-1}, …, n_0).
        X: places in the reference map [m], of this shape; Y, Z: likewise. Where X depends on axis
            0 alone, Y on axis 1 and Z on axis 2, they are (n_0,), (n_1,), (n_2,).
        places: (…, d) the same places.
        periodic: whether axis 0, 1 … is periodic.
        x: (nframes, …) positions [m]; y, z: likewise.
    """

    def __init__(self, run: Run, number: int, entry: Mapping[str, Any], nodes: Array) -> None:
        self.name: str = entry["name"]
        self.kind: str = entry["kind"]
        self.fields = tuple(dict.fromkeys([*entry["fields"], "x"]))
        self._run, self._number, self._kept = run, number, dict[str, Array]()
        d = len(entry["shape"])
        self.shape: tuple[int, ...] = tuple(entry["shape"])
        self.places: Array = nodes.reshape(*self.shape, d)
        self.periodic: tuple[bool, ...] = tuple(entry.get("periodic", [False] * d)[::-1])
        known = [*np.moveaxis(self.places, -1, 0)]
        rows = [X.swapaxes(-1 - k, -1).reshape(-1, X.shape[-1 - k]) for k, X in enumerate(known)]
        # whether each depends on its own axis alone
        if all(np.ptp(of, axis=0).max() <= 1e-12 * np.ptp(of) for of in rows):
            known = [of[0] for of in rows]
        known += [np.zeros(1)] * (3 - d)
        self.X, self.Y, self.Z = known

    x = property(lambda self: self["x"])
    y = property(lambda self: self["y"])
    z = property(lambda self: self["z"])

    @property
    def size(self) -> str:
        """Return the size of its grid in words, as "65 by 33 points"."""
        return f"{' by '.join(map(str, self.shape[::-1]))} points"

    def frame(self, number: int) -> dict[str, Array]:
        """Return all fields of a frame, name -> array of `shape`, without reading the others;
        negative numbers count from the last frame. IndexError.
        """
        self._run._need_frames()
        first = range(self._run.nframes)[number]
        rows = self.read(self.fields, first, first + 1)
        return {name: row[0] for name, row in zip(self.fields, rows)}

    def __getitem__(self, name: str) -> Array:
        if name not in self.fields:
            raise KeyError(f"{self.name!r} has no field {name!r}; it has: {self.fields}")
        if name not in self._kept:
            (self._kept[name],) = self.read([name], 0, self._run.nframes)
        return self._kept[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.fields)

    def __len__(self) -> int:
        return len(self.fields)

    __eq__, __hash__ = object.__eq__, object.__hash__  # Mapping's would compare all values

    def read(self, names: Sequence[str], first: int, end: int) -> list[Array]:
        """Return these fields in the frames from first to end, of one file after the other."""
        width, parts = len(self.fields), [[np.empty((0, *self.shape))] * len(names)]
        with layout.damage(self._run.path):
            for path, stamp, count in self._run._files:
                a, b = max(first, 0), min(end, count)  # of this file
                first, end = first - count, end - count
                if a < b:
                    with layout.open_h5(path) as file:
                        if layout.stamp_of(file) != stamp:
                            raise FileNotFoundError
                        group = file[f"layer{self._number}"]
                        if "frames" in group:
                            table = group["frames"][:, a * width : b * width]
                            table = table.reshape(-1, b - a, width)
                            rows = [table[..., self.fields.index(name)].T for name in names]
                        else:
                            rows = [group[name][a:b] for name in names]
                    parts.append([values.reshape(b - a, *self.shape) for values in rows])
        return [of[-1] if len(of) < 3 else np.concatenate(of) for of in zip(*parts)]

    def __repr__(self) -> str:
        return f"<{self.kind} {self.name!r}: {self.size}; {', '.join(self.fields)}>"


class InterfaceLine:
    """The face of the solid at an interface in two dimensions, as `Run.interface` returns it.

    Attributes:
        name: name of the interface.
        solid: number of the block that is the solid.
        s: (n,) arc length along the face in the reference map, from its first node [m].
        X: (n,) places in the reference map [m]; Y: likewise.
        x: (nframes, n) positions of the solid [m]; y: likewise.
        u: (nframes, n) velocity of the solid along x [m/s]; v: along y.
        T: (nframes, n) temperature of the solid [K].
        displacement: (nframes, n) y - Y [m]; of a face that is not flat along X, the displacement
            along the normal of the reference into the solid.
    """

    def __init__(self, run: Run, name: str, solid: int, axis: int, side: int) -> None:
        self.name, self.solid, layer = name, solid, run.layers[solid]
        self.X, self.Y = X, Y = layer.places.take(-side, -2 - axis).T
        self.x, self.y, self.u, self.v, self.T = (layer[k].take(-side, -1 - axis) for k in "xyuvT")
        self.s = s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(X), np.diff(Y)))])
        self.displacement = self.y - Y
        if np.ptp(Y) > 1e-12 * s[-1]:
            # along the face, into the solid is to the left (1) or to the right (-1)
            left = 1.0 if (axis == 0) == (side == 1) else -1.0
            X_s, Y_s = np.gradient([X, Y], s, axis=1, edge_order=2 if len(s) > 2 else 1)
            self.displacement = left * (X_s * (self.y - Y) - Y_s * (self.x - X))


def open_run(path: str | os.PathLike[str]) -> Run:
    """Open the result of a run, finished or not. It needs numpy and h5py only.

    Args:
        path: NAME.h5; also of a run that goes on or was killed, whose pieces are in NAME.parts.

    Raises:
        FileError: there is no such file, it is no result of fsipetsc, or it is damaged.
    """
    with suppress(FileError):
        return Run(path)
    return Run(path)  # its pieces may have become one file meanwhile
