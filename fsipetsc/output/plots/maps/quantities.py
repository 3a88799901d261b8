"""What can be drawn of a block in two dimensions: of gas and solid something different, each with a scale of its own."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from fsipetsc.output.plots.quantities import Quantity, Values, field

Array = np.ndarray
#: color maps of solids that differ from those of gases (RdBu_r): of values of both signs
OF_SOLIDS = "PuOr_r"


class Pair(NamedTuple):
    """What a map shows of gases and of solids; its name is that of the file."""

    name: str
    title: str
    gas: Quantity
    solid: Quantity

    def of(self, kind: str) -> Quantity:
        return self.gas if kind == "fluid" else self.solid

    def title_of(self, kinds: Collection[str]) -> str:
        """Without what there is not: the title says first what is shown of gases, then of solids, if that is something else."""
        parts = self.title.split("; ")
        return self.title if len(kinds) > 1 else parts[0 if "fluid" in kinds else -1]


def _shear(fields: Mapping[str, Array]) -> Array:
    """Of all directions in the plane, the largest."""
    return np.hypot(0.5 * (fields["s_xx"] - fields["s_yy"]), fields["s_xy"])


def _of_gas(name: str, label: str, unit: str, values: Values, colormap: str) -> Quantity:
    return Quantity(name, name, label, unit, values, None, colormap)


def _of_solid(name: str, label: str, unit: str, values: Values, colormap: str) -> Quantity:
    return Quantity(name, name, label, unit, None, values, colormap)


STRESSES = tuple(
    _of_solid(f"s_{xy}", f"solid: stress $σ_{{{xy}}}$", "Pa", field(f"s_{xy}"), "Oranges") for xy in ("xx", "xy", "yy")
)  # in tension above 0
MAPS = (
    Pair("p", "pressure; stress in solids", _of_gas("p", "gas: pressure p", "Pa", field("p"), "YlGnBu"), STRESSES[0]),
    Pair(
        *("rho", "density; shear stress in solids"),
        _of_gas("rho", "gas: density ρ", "kg/m³", field("rho"), "YlGnBu"),
        _of_solid("shear", "solid: largest shear stress", "Pa", _shear, "Oranges"),
    ),
    Pair(
        *("v", "velocity along y"),
        _of_gas("v", "gas: velocity v", "m/s", field("v"), "YlGnBu"),
        _of_solid("v", "solid: velocity v", "m/s", field("v"), "Oranges"),
    ),
    Pair(
        *("T", "temperature"),
        _of_gas("T", "gas: temperature T", "K", field("T"), "YlGnBu"),
        _of_solid("T", "solid: temperature T", "K", field("T"), "Oranges"),
    ),
)
#: fields that a page may be asked for, beside MAPS
ALL = (
    *MAPS,
    Pair(
        *("u", "velocity along x"),
        _of_gas("u", "gas: velocity u", "m/s", field("u"), "YlGnBu"),
        _of_solid("u", "solid: velocity u", "m/s", field("u"), "Oranges"),
    ),
    *(
        Pair(f"s_{xy}", f"pressure; stress σ_{xy}", MAPS[0].gas, stress)
        for xy, stress in zip(("xx", "xy", "yy"), STRESSES, strict=True)
    ),
)
