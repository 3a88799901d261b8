"""A result as an xarray Dataset, with dimensions, coordinates and units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fsipetsc.errors import InputError
from fsipetsc.output.reader import PlaneLayer, Run

if TYPE_CHECKING:
    import xarray

#: name of a field or series -> (unit, long name)
FIELDS = {
    "rho": ("kg m-3", "density"),
    "u": ("m s-1", "velocity"),
    "v": ("m s-1", "velocity across"),
    "T": ("K", "temperature"),
    "p": ("Pa", "pressure"),
    "sigma": ("Pa", "stress"),
    "s_xx": ("Pa", "Cauchy stress xx"),
    "s_xy": ("Pa", "Cauchy stress xy"),
    "s_yy": ("Pa", "Cauchy stress yy"),
    "x": ("m", "position"),
    "y": ("m", "position across"),
    "J": ("1", "volume ratio of the grid"),
    "t": ("s", "time"),
    "dt": ("s", "time step"),
    "x_interface": ("m", "position of the interfaces"),
    "u_interface": ("m s-1", "velocity of the interfaces"),
    "sigma_interface": ("Pa", "stress at the interfaces"),
    "T_interface": ("K", "temperature at the interfaces"),
}


def to_xarray(run: Run) -> xarray.Dataset:
    """All frames and series of a result.

    Fields are variables "LAYER.FIELD" of the dimensions time and X_LAYER (in two dimensions time, Y_LAYER, X_LAYER), with
    the reference coordinates; series are "series.NAME" of the dimension step, with the coordinate t. A name of a layer is
    written with _ in the place of blanks. Attributes: case, options, summary; of variables units and long_name.

    Raises InputError without xarray, FileError where the result is damaged.
    """
    try:
        import xarray
    except ImportError as error:
        raise InputError("to_xarray: xarray is not installed (pip install xarray)") from error
    si = run.header.get("units", "SI") == "SI"
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", run.time, _attributes("t", si))}
    for layer in run.layers:
        name = "_".join(layer.name.split())
        across = f"X_{name}"
        coordinates[across] = (across, layer.X, {**_attributes("x", si), "long_name": "reference coordinate X"})
        dimensions: tuple[str, ...] = ("time", across)
        if isinstance(layer, PlaneLayer):
            up = f"Y_{name}"
            coordinates[up] = (up, layer.Y, {**_attributes("y", si), "long_name": "reference coordinate Y"})
            dimensions = ("time", up, across)
        for field in layer.fields:
            variables[f"{name}.{field}"] = (dimensions, layer[field], {**_attributes(field, si), "layer": layer.name})
    for series in run.series:
        values = run.series[series]
        dimensions = ("step",) if values.ndim == 1 else ("step", _columns(series, values.shape[1], run))
        variables[f"series.{series}"] = (dimensions, values, _attributes(series, si))
    if "t" in run.series:
        coordinates["t"] = ("step", run.series["t"], _attributes("t", si))
    if run.interfaces:
        coordinates["interface"] = ("interface", list(run.interfaces))
    about = {"case": run.case, "complete": int(run.complete)}
    about |= {f"-{name}": str(value) for name, value in run.options.items() if value is not None}
    return xarray.Dataset(variables, coordinates, about)


def _columns(series: str, count: int, run: Run) -> str:
    """Name of the second dimension of a series: what its columns are."""
    if series.endswith("_interface") and count == len(run.interfaces):
        return "interface"
    return f"of_{series}"


def _attributes(name: str, si: bool) -> dict[str, str]:
    unit, long_name = FIELDS.get(name, ("", ""))
    found = {"units": unit if si else "1", "long_name": long_name}
    return {key: value for key, value in found.items() if value}
