"""An interface in two dimensions as a line: where it is, how it moves, what acts on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fsipetsc.checks import Array


@dataclass(frozen=True)
class InterfaceLine:
    """The face of the solid at an interface; all but X and Y are (nframes, n).

    name, solid   of the interface; number of the block that is the solid
    X             (n,) [m] length along the face in the reference map; X where that is a straight
                  line along X
    Y             (n,) [m] reference height
    x, y          [m] position
    u, v, T       [m/s], [K] velocity and temperature of the solid
    n_x, n_y      unit normal out of the solid, by differences of second order along the line
    t_x, t_y      [Pa] traction on the solid, s n, with the stress s that is saved
    pressure      [Pa] -t.n, what pushes the solid
    heat          [W/m2] heat flux into the solid, kappa_e n.grad T, by such differences within it
    displacement  [m] y - Y; of a face that is not flat along X, along the normal of the reference
                  into the solid
    """

    name: str
    solid: int
    X: Array
    Y: Array
    x: Array
    y: Array
    u: Array
    v: Array
    T: Array
    n_x: Array
    n_y: Array
    t_x: Array
    t_y: Array
    heat: Array
    displacement: Array

    @property
    def pressure(self) -> Array:
        pressure: Array = -(self.t_x * self.n_x + self.t_y * self.n_y)
        return pressure


def along_face(
    name: str, number: int, layer: Any, axis: int, side: int, kappa_e: float
) -> InterfaceLine:
    """The line of a face of a block of a solid.

    layer: fsipetsc.output.reader.BlockLayer, number: its number. kappa_e: its conductivity.
    """

    def rows(values: Array) -> Array:
        """(3, …, n) of the face and the next two rows within."""
        values = np.moveaxis(values, -1 - axis, 0)
        return values[::-1][:3] if side else values[:3]

    X, Y = (rows(layer.places[..., k])[0] for k in range(2))
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(X), np.diff(Y)))])
    flat = bool(np.ptp(Y) <= 1e-12 * length[-1] and X[-1] > X[0])
    fields = {field: rows(layer[field]) for field in layer.fields}
    x, y = fields["x"][0], fields["y"][0]
    # with d_along along the face, into the solid is to its left (1) or to its right (-1)
    left = 1.0 if (axis == 0) == (side == 1) else -1.0

    def derivatives(f: Array) -> tuple[Array, Array]:
        """Along the face, and to its left per row."""
        return _along(f[0], length), left * (2.0 * f[1] - 0.5 * f[2] - 1.5 * f[0])

    (x_s, x_r), (y_s, y_r), (T_s, T_r) = (derivatives(fields[f]) for f in ("x", "y", "T"))
    size = left * np.hypot(x_s, y_s)
    n_x, n_y = y_s / size, -x_s / size
    t_x = fields["s_xx"][0] * n_x + fields["s_xy"][0] * n_y
    t_y = fields["s_xy"][0] * n_x + fields["s_yy"][0] * n_y
    J: Array = x_s * y_r - x_r * y_s
    heat = kappa_e * ((y_r * T_s - y_s * T_r) * n_x + (x_s * T_r - x_r * T_s) * n_y) / J
    X_s, Y_s = _along(X, length), _along(Y, length)
    into = y - Y if flat else left * (X_s * (y - Y) - Y_s * (x - X))
    motion = {quantity: fields[quantity][0] for quantity in ("x", "y", "u", "v", "T")}
    return InterfaceLine(
        name,
        number,
        length + X[0] if flat else length,
        Y,
        **motion,
        n_x=n_x,
        n_y=n_y,
        t_x=t_x,
        t_y=t_y,
        heat=heat,
        displacement=into,
    )


def _along(values: Array, length: Array) -> Array:
    """Derivative along a line."""
    order: Literal[1, 2] = 2 if len(length) > 2 else 1
    derivative: Array = np.gradient(values, length, axis=-1, edge_order=order)
    return derivative
