"""A result as an xarray Dataset, with dimensions, coordinates and units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fsipetsc.output.quantities import AT_INTERFACES, unit_of
from fsipetsc.output.reader import Layer, Run

if TYPE_CHECKING:
    import xarray


def to_xarray(run: Run) -> xarray.Dataset:
    """All frames and series of a result.

    Fields are variables "LAYER.FIELD" of the dimensions time and X_LAYER (in two dimensions time,
    Y_LAYER, X_LAYER), with the reference coordinates; the positions "LAYER.x" … are coordinates.
    Series are "series.NAME" of the dimension step, with the coordinate t, and interface, gas,
    layer, face or point, which have names. A name of a layer is written with _ in the place of
    blanks. Attributes: case, options; of variables units.

    Raises ImportError without xarray, FileError where the result is damaged.
    """
    import xarray

    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", run.time, _attributes(run, "t"))}
    for layer in run.layers:
        _add_layer(run, layer, variables, coordinates)
    columns = _columns(run)
    for name, values in run.series.items():
        dimensions: tuple[str, ...] = ("step",)
        if values.ndim == 2:
            of = _what_columns_are(name)
            of = of if len(columns.get(of, ())) == values.shape[1] else f"of_{name}"
            dimensions = ("step", of)
            if of in columns:
                coordinates[of] = (of, columns[of])
        variables[f"series.{name}"] = (dimensions, values, _attributes(run, name))
    if "t" in run.series:
        coordinates["t"] = ("step", run.series["t"], _attributes(run, "t"))
    if run.interfaces:
        coordinates["interface"] = ("interface", list(run.interfaces))
    about = {"case": run.case, "complete": int(run.complete)}
    options = {f"-{name}": str(value) for name, value in run.options.items() if value is not None}
    return xarray.Dataset(variables, coordinates, {**about, **options})


def _add_layer(
    run: Run, layer: Layer, variables: dict[str, Any], coordinates: dict[str, Any]
) -> None:
    """Fields and coordinates of a layer; the places of a curved block are coordinates NAME.X …"""
    name, axes = "_".join(layer.name.split()), "XYZ"[: len(layer.shape)]
    dimensions = ("time", *(f"{axis}_{name}" for axis in axes[::-1]))
    for axis in axes:
        values = getattr(layer, axis)
        about = {**_attributes(run, "x"), "long_name": f"reference coordinate {axis}"}
        if values.ndim == 1:
            coordinates[f"{axis}_{name}"] = (f"{axis}_{name}", values, about)
        else:
            coordinates[f"{name}.{axis}"] = (dimensions[1:], values, about)
    for field in layer.fields:
        about = {**_attributes(run, field), "layer": layer.name}
        where = coordinates if field in "xyz" else variables
        where[f"{name}.{field}"] = (dimensions, layer[field], about)


def _what_columns_are(series: str) -> str:
    """What the columns of a series stand for."""
    known = {"mass": "gas", "mass_in": "gas", "least_J": "layer", "J_error": "layer"}
    known |= {name: "interface" for name in AT_INTERFACES}
    return known.get(series, series.split("_")[-1])


def _columns(run: Run) -> dict[str, list[str]]:
    """The names of what columns of series may stand for."""
    return {
        "interface": list(run.interfaces),
        "gas": [layer.name for layer in run.layers if layer.kind == "fluid"],
        "layer": [layer.name for layer in run.layers],
        "face": list(run.faces),
        "point": [f"{name} at {', '.join(f'{x:g}' for x in X)}" for name, X in run.points],
    }


def _attributes(run: Run, name: str) -> dict[str, str]:
    """Of a field or series."""
    unit = unit_of(name, run)
    return {"units": unit} if unit else {}
