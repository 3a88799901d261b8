"""An interface of a run in two dimensions as a line: where it is, how it moves, what acts on it; from the frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class InterfaceLine:
    """The edge row of the solid at an interface; all but X are (nframes, nx).

    name, solid   of the interface; number of the layer that is the solid
    X             (nx,) [m] reference coordinate, of the solid's points
    x, y          [m] position
    u, v, T       [m/s], [K] velocity and temperature of the solid
    n_x, n_y      unit normal out of the solid, by differences of second order along the line
    t_x, t_y      [Pa] traction that acts on the solid, s n, per length of the line as it is, with the stress s that is saved
    pressure      [Pa] -t.n, what pushes the solid
    displacement  [m] y less that of the reference, Y
    """

    name: str
    solid: int
    X: Array
    Y: float
    x: Array
    y: Array
    u: Array
    v: Array
    T: Array
    n_x: Array
    n_y: Array
    t_x: Array
    t_y: Array

    @property
    def pressure(self) -> Array:
        return -(self.t_x * self.n_x + self.t_y * self.n_y)

    @property
    def displacement(self) -> Array:
        return self.y - self.Y


def along_edge(name: str, number: int, fields: dict[str, Array], X: Array, Y: float, upper: bool) -> InterfaceLine:
    """The line of a solid's edge row; fields: name -> (nframes, nx). upper: the gas lies above."""
    x, y = fields["x"], fields["y"]
    order = min(2, len(X) - 1)
    x_X, y_X = (np.gradient(values, X, axis=-1, edge_order=order) for values in (x, y))
    length = np.hypot(x_X, y_X) * (1.0 if upper else -1.0)
    n_x, n_y = -y_X / length, x_X / length
    t_x = fields["s_xx"] * n_x + fields["s_xy"] * n_y
    t_y = fields["s_xy"] * n_x + fields["s_yy"] * n_y
    return InterfaceLine(name, number, X, Y, x, y, *(fields[name] for name in ("u", "v", "T")), n_x, n_y, t_x, t_y)
