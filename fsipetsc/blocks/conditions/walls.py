"""Walls of a gas, to which it sticks or along which it slips.

Where a gas slips with the length l of Navier, its nodes get (0, t, t . w), t = mu/l (u - w) |n|
without its part along n, from a wall of velocity w.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from fsipetsc.blocks.conditions.condition import Datum, FaceNode, Function, OfGas
from fsipetsc.blocks.maps import place_text
from fsipetsc.checks import POSITIVE
from fsipetsc.equations.vectors import along, dot, scale, sub
from fsipetsc.errors import InputError


@dataclass(frozen=True)
class NoSlip(OfGas):
    """A wall that a gas sticks to: insulated, of a given temperature, or with a given heat flux.

    Data are numbers, or functions of the coordinates X of the face's nodes and of t [s].

    Args:
        T: temperature [K]; None: it is not given.
        heat_flux: heat flux into the gas [W/m2]; None: it is not given.
        x: `x(*X, t)` returns d positions [m] of a wall that moves; None: it is at rest.
        velocity: `velocity(*X, t)` returns d velocities [m/s], the derivative of x; None: it
            follows from x.
        slip_length: length [m] with which the gas slips along the wall: its velocity there is this
            length times its slope (Navier). So it may meet a wall, or a solid, that moves along
            this one. None: it sticks.
    """

    T: Datum = None
    heat_flux: Datum = None
    x: Function | None = None
    velocity: Function | None = None
    slip_length: Datum = None
    ranges = OfGas.ranges | {"slip_length": POSITIVE}
    at_faces = MappingProxyType({**OfGas.at_faces, "width": ("slip_length",)})
    part = "wall"
    holds = True

    @property
    def acts(self) -> bool:
        """Whether the gas slips."""
        return self.slip_length is not None

    def check_on_grid(self, data: Mapping[str, Any], X: Any, spacing: Any, t: float) -> None:
        """A slip length is no shorter than a cell."""
        if self.slip_length is None:
            return
        length = data["width"]
        short = np.flatnonzero(~(length >= spacing))
        if short.size:
            n, where = short[0], f"slip_length of NoSlip at t = {t:.6g}"
            wanted = f"expected the distance {spacing[n]:.4g} of the nodes beside the wall, or more"
            raise InputError(f"{where} is {length[n]:.4g} at {place_text(X[n])}: {wanted}")

    @staticmethod
    def traction(gas, w, face: FaceNode):
        """The force t on the gas; see above."""
        past = sub(gas.velocity(w), face.wall)
        past = along(past, -dot(past, face.n) / (face.size * face.size), face.n)
        return scale(-gas.mu * gas.transport.viscosity(w[2]) * face.size / face.width, past)


@dataclass(frozen=True)
class Slip(OfGas):
    """A wall along which a gas slips without heat, or a plane of symmetry.

    Args:
        x: `x(*X, t)` returns d positions [m] of a wall that moves; None: it is at rest.
        velocity: `velocity(*X, t)` returns d velocities [m/s], the derivative of x; None: it
            follows from x.
        name: faces of one name are one wall, also around an edge; without names, those that go on
            smoothly are one.
    """

    x: Function | None = None
    velocity: Function | None = None
    name: str = ""
    part = "slip"
    holds = True
