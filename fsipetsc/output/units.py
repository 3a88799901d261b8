"""Units of what is stored and recorded, and labels of fields."""

from typing import Any, Protocol

from fsipetsc.scheme.observables import GAIN, INTEGRAL, SERIES

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


class Described(Protocol):
    """A run, or what knows as much of its units."""

    header: dict[str, Any]
    dimension: int


def unit_of(name: str, run: Described | None = None) -> str:
    """Of a field or series, as in "kg m-3"; "" where it is not known, "1" of a run without units.

    Those of integrals are per area in one dimension, and so on, where the run is given.
    """
    one = SERIES.get(name)
    unit = one.unit if one else FIELDS.get(name, ("", ""))[1]
    if run is not None and not is_si(run):
        return unit and "1"
    if run is not None and one and one.kind in (INTEGRAL, GAIN):
        # around an axis integrals are per length, around a centre per nothing
        space = run.dimension + int(run.header.get("symmetry", 0))
        unit += {1: " m-2", 2: " m-1", 3: ""}[space]
    return unit


def is_si(run: Described) -> bool:
    """False if the case is dimensionless."""
    return bool(run.header.get("units", "SI") == "SI")


def written(unit: str) -> str:
    """A unit as labels have it: "kg m-3" as kg m⁻³."""
    return "" if unit == "1" else unit.translate(str.maketrans("-123", "⁻¹²³"))
