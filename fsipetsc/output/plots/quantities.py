"""What can be drawn of a layer, and how it follows from the stored fields."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from fsipetsc.output.reader import BlockLayer, Layer

Array = np.ndarray
Values = Callable[[Mapping[str, Array]], Array]


@dataclass(frozen=True)
class Quantity:
    """Name of the file, title, label and SI unit, and how it follows from the fields of a frame, or of all, and from X.

    fluid, solid: fields -> values, or None where the quantity makes no sense. fields also has "X".
    """

    name: str
    title: str
    label: str
    unit: str
    fluid: Values | None
    solid: Values | None
    colormap: str = "viridis"  # light where the value is that at rest; RdBu_r where values of both signs occur

    def of(self, kind: str) -> Values | None:
        return self.fluid if kind == "fluid" else self.solid

    def values(self, layer: Layer | BlockLayer, frame: int | None = None) -> Array | None:
        """(n,) of a frame or (nframes, n) of all, (ny, nx) for n in two dimensions; None for the other kind of layer."""
        value = self.of(layer.kind)
        if value is None:
            return None
        return value(ChainMap({"X": layer.X}, layer if frame is None else layer.frame(frame)))


def field(name: str) -> Values:
    """The field as it is stored."""
    return lambda fields: fields[name]


def _load(fields: Mapping[str, Array]) -> Array:
    """What a solid and a gas have in common at an interface: p − σ."""
    return fields["p"] - fields["sigma"]


def _strain(fields: Mapping[str, Array]) -> Array:
    """x_X − 1, by differences of second order."""
    return np.gradient(fields["x"], fields["X"], axis=-1, edge_order=2) - 1.0


PROFILES = (
    Quantity("u", "velocity", "velocity u", "m/s", field("u"), field("u")),
    Quantity("T", "temperature", "temperature T", "K", field("T"), field("T"), "YlOrRd"),
    Quantity("p", "pressure", "pressure p;  p − σ in the solid", "Pa", field("p"), _load, "YlGnBu"),
    Quantity("rho", "density of the fluid", "density ρ", "kg/m³", field("rho"), None),
    Quantity("sigma", "stress in the solid", "stress σ", "Pa", None, field("sigma")),
    Quantity("strain", "strain of the solid", "strain ∂x/∂X − 1", "", None, _strain),
)
SPACE_TIME = PROFILES[:3]
