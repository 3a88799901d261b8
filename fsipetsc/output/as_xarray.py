"""A result as an xarray Dataset, with dimensions, coordinates and units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fsipetsc.errors import InputError
from fsipetsc.output.reader import BlockLayer, Run

if TYPE_CHECKING:
    import xarray

#: name of a field or series -> (unit, long name)
FIELDS = {
    "rho": ("kg m-3", "density"),
    "u": ("m s-1", "velocity"),
    "v": ("m s-1", "velocity across"),
    "w": ("m s-1", "velocity along z"),
    "T": ("K", "temperature"),
    "p": ("Pa", "pressure"),
    "sigma": ("Pa", "stress"),
    "s_xx": ("Pa", "Cauchy stress xx"),
    "s_xy": ("Pa", "Cauchy stress xy"),
    "s_yy": ("Pa", "Cauchy stress yy"),
    **{f"s_{ij}": ("Pa", f"Cauchy stress {ij}") for ij in ("xz", "yz", "zz")},
    "x": ("m", "position"),
    "y": ("m", "position across"),
    "z": ("m", "position along z"),
    "J": ("1", "volume ratio of the grid"),
    "t": ("s", "time"),
    "dt": ("s", "time step"),
    "x_interface": ("m", "position of the interfaces"),
    "u_interface": ("m s-1", "velocity of the interfaces"),
    "sigma_interface": ("Pa", "stress at the interfaces"),
    "T_interface": ("K", "temperature at the interfaces"),
    "residual_u": ("m s-1", "what is left of the condition on the velocity"),
    "residual_stress": ("Pa", "what is left of the condition on the stress"),
    "residual_T": ("K", "what is left of the condition on the temperature"),
    "residual_flux": ("W m-2", "what is left of the condition on the heat flux"),
    "force": ("Pa", "force of the ends and of gravity"),
    "least_J": ("1", "least volume ratio of the grid"),
    "J_error": ("1", "largest departure of J from the volume ratio of the grid, relative"),
    **{f"{x}_point": ("m", f"position {x} of recorded nodes") for x in "xyz"},
    **{f"{u}_point": ("m s-1", f"velocity {u} of recorded nodes") for u in "uvw"},
    "T_point": ("K", "temperature of recorded nodes"),
    "p_point": ("Pa", "pressure of recorded nodes, of solids the mean of the stresses with the other sign"),
    **{f"t_{x}_point": ("Pa", f"traction along {x} on the solid at recorded nodes of interfaces") for x in "xyz"},
}
#: the same of integrals; in one dimension they are per area [m-2], in two per depth [m-1]
INTEGRALS = {
    "mass": ("kg", "mass of each gas"),
    "mass_in": ("kg", "mass of each gas that has come in"),
    "energy": ("J", "energy of all layers"),
    "energy_in": ("J", "energy that has come in"),
    "entropy": ("J K-1", "entropy"),
    "heating": ("W K-1", "heating of the solids by stress, over the temperature"),
    "momentum": ("N s", "momentum of all layers"),
    "momentum_x": ("N s", "momentum of all layers"),
    "momentum_y": ("N s", "momentum of all layers across"),
    "momentum_z": ("N s", "momentum of all layers along z"),
    "impulse": ("N s", "impulse of the ends and of gravity"),
    "impulse_x": ("N s", "impulse of the edges"),
    "impulse_y": ("N s", "impulse of the edges across"),
    "impulse_z": ("N s", "impulse of the edges along z"),
}


def to_xarray(run: Run) -> xarray.Dataset:
    """All frames and series of a result.

    Fields are variables "LAYER.FIELD" of the dimensions time and X_LAYER (in two dimensions time, Y_LAYER, X_LAYER), with
    the reference coordinates; the positions "LAYER.x" … are coordinates. Series are "series.NAME" of the
    dimension step, with the coordinate t, and interface, gas, layer or point, which have names. A name of a layer is written
    with _ in the place of blanks. Attributes: case, options, summary; of variables units and long_name.

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
        if isinstance(layer, BlockLayer):
            _add_block(layer, name, si, variables, coordinates)
            continue
        across = f"X_{name}"
        coordinates[across] = (across, layer.X, {**_attributes("x", si), "long_name": "reference coordinate X"})
        for field in layer.fields:
            where = coordinates if field == "x" else variables
            where[f"{name}.{field}"] = (("time", across), layer[field], {**_attributes(field, si), "layer": layer.name})
    names = _columns(run)
    for series in run.series:
        values = run.series[series]
        dimensions: tuple[str, ...] = ("step",)
        if values.ndim == 2:
            of = next((of for of in _COLUMNS.get(series, ()) if len(names[of]) == values.shape[1]), f"of_{series}")
            dimensions = ("step", of)
            if of in names:
                coordinates[of] = (of, names[of])
        variables[f"series.{series}"] = (dimensions, values, _attributes(series, si, run.dimension))
    if "t" in run.series:
        coordinates["t"] = ("step", run.series["t"], _attributes("t", si))
    if run.interfaces:
        coordinates["interface"] = ("interface", list(run.interfaces))
    about = {"case": run.case, "complete": int(run.complete)}
    about |= {f"-{name}": str(value) for name, value in run.options.items() if value is not None}
    return xarray.Dataset(variables, coordinates, about)


def _add_block(layer: BlockLayer, name: str, si: bool, variables: dict[str, Any], coordinates: dict[str, Any]) -> None:
    """Fields of a block: of the dimensions time, …, Y_NAME, X_NAME; of a curved one places are coordinates NAME.X …"""
    axes = "XYZ"[: len(layer.shape)]
    own = [f"{axis}_{name}" for axis in axes]
    dimensions = ("time", *own[::-1])
    for axis, dimension in zip(axes, own, strict=True):
        values = getattr(layer, axis)
        about = {**_attributes(axis.lower(), si), "long_name": f"reference coordinate {axis}"}
        if values.ndim == 1:
            coordinates[dimension] = (dimension, values, about)
        else:
            coordinates[f"{name}.{axis}"] = (dimensions[1:], values, about)
    for field in layer.fields:
        where = coordinates if field in "xyz" else variables
        where[f"{name}.{field}"] = (dimensions, layer[field], {**_attributes(field, si), "layer": layer.name})


#: what the columns of a series may be
_COLUMNS = {"mass": ("gas",), "mass_in": ("gas",), "least_J": ("layer",), "J_error": ("layer",)}
_COLUMNS |= {name: ("interface",) for name in FIELDS if name.endswith("_interface") or name.startswith("residual_")}
_COLUMNS |= {name: ("point",) for name in FIELDS if name.endswith("_point")}


def _columns(run: Run) -> dict[str, list[str]]:
    """What the columns of series stand for, by name."""
    return {
        "interface": list(run.interfaces),
        "gas": [layer.name for layer in run.layers if layer.kind == "fluid"],
        "layer": [layer.name for layer in run.layers],
        "point": [f"{name} at {', '.join(f'{x:g}' for x in X)}" for name, X in run.points],
    }


def _attributes(name: str, si: bool, dimension: int = 0) -> dict[str, str]:
    """Of a field or series; dimension: of the run, where it may be an integral."""
    unit, long_name = FIELDS.get(name, ("", ""))
    if name in INTEGRALS:
        unit, long_name = INTEGRALS[name]
        unit += " m-2" if dimension == 1 else " m-1"
    found = {"units": unit if si else "1", "long_name": long_name}
    return {key: value for key, value in found.items() if value}
