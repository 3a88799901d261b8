"""Labels and units of what is stored and recorded; what can be drawn."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.scheme.observables import GAIN, INTEGRAL, SERIES

Run = Any  # fsipetsc.output.reader.Run, which imports this module
#: fields -> their label, "" where they are not drawn, and unit; *: their name or axes
_TABLE = {
    "u v w": ("velocity *", "m s-1"),
    "T": ("temperature T", "K"),
    "p": ("pressure p", "Pa"),
    "rho": ("density ρ", "kg m-3"),
    "schlieren": ("schlieren, √|∇ρ|", "kg½ m-2"),
    "sigma": ("stress σ", "Pa"),
    "sigma_theta": ("hoop stress σ_θ", "Pa"),
    "strain": ("strain ∂x/∂X − 1", ""),
    "s_xx s_yy s_zz s_xy s_yz s_xz": ("stress σ_*", "Pa"),
    "J": ("", "1"),
    "x y z": ("", "m"),
}
#: field -> (label, unit)
FIELDS = {
    name: (label.replace("*", name.removeprefix("s_")), unit)
    for names, (label, unit) in _TABLE.items()
    for name in names.split()
}
#: fields of blocks whose mean is drawn beside the pressure
_NORMAL = "s_xx", "s_yy", "s_zz", "sigma_theta"


def unit_of(name: str, run: Run | None = None) -> str:
    """Return the unit of a field or series, as "kg m-3"; "" where it is not known. Where the run is
    given, integrals are per area in one dimension, and so on; "1" of a run without units.
    """
    one = SERIES.get(name)
    unit = one.unit if one else FIELDS.get(name, ("", ""))[1]
    if run is not None and not is_si(run):
        return unit and "1"
    if run is not None and one and one.kind in (INTEGRAL, GAIN):
        # around an axis integrals are per length, around a centre per nothing
        unit += {1: " m-2", 2: " m-1", 3: ""}[run.dimension + int(run.header.get("symmetry", 0))]
    return unit


def is_si(run: Run) -> bool:
    """False if the case is dimensionless."""
    return bool(run.header.get("units", "SI") == "SI")


def labelled(run: Run, label: str, unit: str) -> str:
    """Return a label with its unit, where there is one: "kg m-3" as [kg m⁻³], on one line."""
    unit = unit.translate(str.maketrans("-123 ", "⁻¹²³\u00a0"))
    return f"{label}  [{unit}]" if unit not in ("", "¹") and is_si(run) else label


def there(run: Run) -> dict[str, dict[str, str]]:
    """Return what can be drawn of this run: name -> kind of layer -> label."""
    line = run.dimension == 1
    made = {("solid", "p"), ("solid", "strain") if line else ("fluid", "schlieren")}
    has = made | {(layer.kind, name) for layer in run.layers for name in layer.fields}
    kinds = sorted({layer.kind for layer in run.layers})
    labels = {
        name: {kind: label for kind in kinds if label and (kind, name) in has}
        for name, (label, _) in FIELDS.items()
    }
    if "solid" in (p := labels["p"]):
        p["solid"] = f"{'p − σ' if line else 'mean stress'} in solids"
    return {name: of for name, of in labels.items() if of}


def chosen(run: Run, names: Sequence[str]) -> list[str]:
    """Return these names of what can be drawn; if there are none, those of a page. InputError."""
    known = there(run)
    if missing := [name for name in names if name not in known]:
        raise InputError(f"-fields {missing[0]}: expected some of {', '.join(known)}")
    usual = ("u", "T", "p") if run.dimension == 1 else ("p",)
    return [name for name in names or usual if name in known]


def values_of(name: str, layer: Any, fields: Mapping[str, Array]) -> Array:
    """Return what is drawn of a layer, from the fields of a frame; beside the pressure of gases
    stands what a solid pushes with, in one dimension, or the mean of its normal stresses.
    """
    if name == "p" and layer.kind == "solid":
        if "sigma" in fields:
            return fields["p"] - fields["sigma"]
        return np.mean([fields[name] for name in _NORMAL if name in fields], axis=0)
    if name == "schlieren":  # by differences of second order on a curved grid
        places = [fields[x] for x in "xyz" if x in fields]
        along = [np.stack(np.gradient(v, edge_order=2), -1) for v in (*places, fields["rho"])]
        gradient = np.linalg.solve(np.stack(along[:-1], axis=-1), along[-1][..., None])
        return np.sqrt(np.linalg.norm(gradient[..., 0], axis=-1))
    if name == "strain":  # likewise
        return np.gradient(fields["x"], layer.X, edge_order=2) - 1.0
    return fields[name]
