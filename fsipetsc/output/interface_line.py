"""An interface in two dimensions as a line: where it is, how it moves, what acts on it; from the frames."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fsipetsc.checks import Array


@dataclass(frozen=True)
class InterfaceLine:
    """The face of the solid at an interface; all but X and Y are (nframes, n).

    name, solid   of the interface; number of the block that is the solid
    X             (n,) [m] length along the face in the reference map; X where that is a straight line along X
    Y             (n,) [m] reference height
    x, y          [m] position
    u, v, T       [m/s], [K] velocity and temperature of the solid
    n_x, n_y      unit normal out of the solid, by differences of second order along the line
    t_x, t_y      [Pa] traction that acts on the solid, s n, per length of the line as it is, with the stress s that is saved
    pressure      [Pa] -t.n, what pushes the solid
    heat          [W/m2] heat flux into the solid, kappa_e n.grad T, per length of the line as it is, by such differences within
                  the solid; NaN in results of earlier versions
    displacement  [m] y - Y; of a face that is not flat along X, along the normal of the reference into the solid
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
        pressure: Array = -(self.t_x * self.n_x + self.t_y * self.n_y)  # of no known type to mypy with some versions of numpy
        return pressure


def along_face(name: str, number: int, layer: Any, axis: int, side: int, kappa_e: float) -> InterfaceLine:
    """The line of a face of a block of a solid; layer: fsipetsc.output.reader.BlockLayer, number: its number."""

    def rows(values: Array) -> Array:
        """(3, …, n), of the face and the next ones within."""
        count = values.shape[-1 - axis]
        chosen = [count - 1 - i if side else i for i in range(3)]
        return np.moveaxis(np.take(values, chosen, axis=-1 - axis), -1 - axis, 0)

    full = np.broadcast_arrays(*_whole(layer.X, layer.Y))
    X, Y = (rows(values)[0] for values in full)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(X), np.diff(Y)))])
    flat = np.ptp(Y) <= 1e-12 * length[-1] and X[-1] > X[0]
    fields = {field: rows(layer[field]) for field in layer.fields}
    # along the face and upwards are right-handed directions: upwards axis 1 goes up, and axis 0 down
    inward = 1.0 if (axis == 0) == (side == 1) else -1.0
    along = length + X[0] if flat else length
    line = along_edge(name, number, fields, along, inward * np.arange(3.0), kappa_e)
    if flat:
        return replace(line, Y=Y, displacement=line.y - Y)
    X_s, Y_s = (np.gradient(values, length, edge_order=2) for values in (X, Y))
    into = -inward * (Y_s * (line.x - X) - X_s * (line.y - Y))
    return replace(line, Y=Y, displacement=into)


def _whole(X: Array, Y: Array) -> tuple[Array, Array]:
    """Coordinates of a block as arrays of (n_1, n_0), or such that can be broadcast to these."""
    return (X, Y[:, None]) if X.ndim == 1 else (X, Y)


def along_edge(name: str, number: int, fields: dict[str, Array], X: Array, Y: Array, kappa_e: float) -> InterfaceLine:
    """The line of a solid's edge row; fields: name -> (3, nframes, nx), of this row and the next ones within the solid, and Y
    (3,) of these. kappa_e: conductivity of the solid.
    """
    order: Literal[1, 2] = 2 if len(X) > 2 else 1
    x, y, T = (fields[quantity] for quantity in ("x", "y", "T"))
    (x_X, x_Y), (y_X, y_Y), (T_X, T_Y) = (
        (np.gradient(f[0], X, axis=-1, edge_order=order), (4.0 * f[1] - f[2] - 3.0 * f[0]) / (Y[2] - Y[0])) for f in (x, y, T)
    )
    length = np.hypot(x_X, y_X) * (1.0 if Y[0] > Y[1] else -1.0)
    n_x, n_y = -y_X / length, x_X / length
    edge = {quantity: values[0] for quantity, values in fields.items()}
    t_x = edge["s_xx"] * n_x + edge["s_xy"] * n_y
    t_y = edge["s_xy"] * n_x + edge["s_yy"] * n_y
    J = x_X * y_Y - x_Y * y_X
    T_x, T_y = (y_Y * T_X - y_X * T_Y) / J, (x_X * T_Y - x_Y * T_X) / J
    motion = {quantity: edge[quantity] for quantity in ("x", "y", "u", "v", "T")}
    traction = {"n_x": n_x, "n_y": n_y, "t_x": t_x, "t_y": t_y, "heat": kappa_e * (T_x * n_x + T_y * n_y)}
    return InterfaceLine(name, number, X, Y[0] + 0.0 * X, **motion, **traction, displacement=0.0 * x[0])
