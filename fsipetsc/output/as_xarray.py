"""A result as an xarray Dataset, with dimensions, coordinates and units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fsipetsc.output.file_layout import columns_kind, columns_of
from fsipetsc.output.units import unit_of

if TYPE_CHECKING:
    import xarray


def to_xarray(run: Any) -> xarray.Dataset:
    """The dataset that `Run.to_xarray` describes, of a Run. The reference coordinates of a curved
    block are "LAYER.X" …; the positions "LAYER.x" … are coordinates, too. A series with several
    columns has the dimension interface, gas, layer, face or point, which has names.

    Raises ImportError without xarray, FileError where the result is damaged.
    """
    import xarray

    def about(name: str, **more: str) -> dict[str, str]:
        unit = unit_of(name, run)
        return {"units": unit, **more} if unit else more

    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", run.time, about("t"))}
    if run.interfaces:
        coordinates["interface"] = "interface", list(run.interfaces)
    for layer in run.layers:
        name, axes = "_".join(layer.name.split()), "XYZ"[: len(layer.shape)]
        dimensions = [f"{axis}_{name}" for axis in axes[::-1]]
        for axis in axes:
            X, of_axis = getattr(layer, axis), f"{axis}_{name}"
            long_name = about("x", long_name=f"reference coordinate {axis}")
            if X.ndim == 1:
                coordinates[of_axis] = of_axis, X, long_name
            else:
                coordinates[f"{name}.{axis}"] = dimensions, X, long_name
        for field in layer.fields:
            where = coordinates if field in "xyz" else variables
            values = layer[field]
            where[f"{name}.{field}"] = ["time", *dimensions], values, about(field, layer=layer.name)
    names = columns_of(run.header)
    for series, values in run.series.items():
        dimensions = ["step"]
        if values.ndim == 2:
            of = columns_kind(series)
            coordinates[of] = of, names[of]
            dimensions.append(of)
        variables[f"series.{series}"] = dimensions, values, about(series)
    if "t" in run.series:
        coordinates["t"] = "step", run.series["t"], about("t")
    options = {f"-{name}": str(value) for name, value in run.options.items() if value is not None}
    attributes = {"case": run.case, "complete": int(run.complete), **options}
    return xarray.Dataset(variables, coordinates, attributes)
