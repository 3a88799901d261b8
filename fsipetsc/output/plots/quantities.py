"""What can be drawn of gases and solids, and how it follows from the stored fields."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.output.reader import Run

Array = np.ndarray


class Part(NamedTuple):
    """A quantity of a gas or a solid: label, fields that it needs, values from these and X."""

    label: str
    needs: tuple[str, ...]
    values: Callable[[Mapping[str, Array]], Array]


class Quantity(NamedTuple):
    """A name, a unit, and what it is in gases and in solids, if anything."""

    name: str
    unit: str
    fluid: Part | None
    solid: Part | None

    def of(self, kind: str) -> Part | None:
        return self.fluid if kind == "fluid" else self.solid

    @property
    def title(self) -> str:
        """What is shown of gases, then of solids if that is something else."""
        return "; ".join(dict.fromkeys(part.label for part in (self.fluid, self.solid) if part))


def _field(label: str, name: str) -> Part:
    return Part(label, (name,), lambda fields: fields[name])


def _common(name: str, label: str, unit: str) -> Quantity:
    """A field that gas and solid have in common."""
    return Quantity(name, unit, _field(label, name), _field(label, name))


def _strain(fields: Mapping[str, Array]) -> Array:
    """x_X − 1, by differences of second order."""
    return np.gradient(fields["x"], fields["X"], axis=-1, edge_order=2) - 1.0


_P, _LOAD = _field("pressure p", "p"), lambda fields: fields["p"] - fields["sigma"]
_RHO = Quantity("rho", "kg/m³", _field("density ρ", "rho"), None)
_T = _common("T", "temperature T", "K")
ON_A_LINE = (
    _common("u", "velocity u", "m/s"),
    _T,
    Quantity("p", "Pa", _P, Part("p − σ in solids", ("p", "sigma"), _LOAD)),
    _RHO,
    Quantity("sigma", "Pa", None, _field("stress σ", "sigma")),
    Quantity("sigma_theta", "Pa", None, _field("hoop stress σ_θ", "sigma_theta")),
    Quantity("strain", "", None, Part("strain ∂x/∂X − 1", ("x",), _strain)),
)
IN_SPACE = (
    Quantity("p", "Pa", _P, _field("stress σ_xx in solids", "s_xx")),
    _RHO,
    *(_common(name, f"velocity {name}", "m/s") for name in "uvw"),
    _T,
    *(
        Quantity(f"s_{xy}", "Pa", None, _field(f"stress σ_{xy}", f"s_{xy}"))
        for xy in ("xx", "yy", "zz", "xy", "yz", "xz")
    ),
)


def there(run: Run) -> list[Quantity]:
    """What can be drawn of this run."""
    stored = {layer.kind: {*layer.fields} for layer in run.layers}
    found = []
    for quantity in ON_A_LINE if run.dimension == 1 else IN_SPACE:
        parts = {}
        for kind in ("fluid", "solid"):
            part = quantity.of(kind)
            parts[kind] = part if part and {*part.needs} <= stored.get(kind, set()) else None
        if any(parts.values()):
            found.append(quantity._replace(**parts))
    return found


def chosen(run: Run, names: Sequence[str]) -> list[Quantity]:
    """Those of these names, or what a page shows where there are none. InputError."""
    known = {quantity.name: quantity for quantity in there(run)}
    for name in names:
        if name not in known:
            raise InputError(f"-fields {name}: expected some of {', '.join(known)}")
    usual = ("u", "T", "p") if run.dimension == 1 else ("p",)
    return [known[name] for name in names or usual if name in known]
