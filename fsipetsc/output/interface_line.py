"""An interface in two dimensions as a line: where it is, how it moves, what acts on it."""

from typing import Any, Literal

import numpy as np

from fsipetsc.checks import Array


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

    def __init__(
        self, name: str, solid: int, layer: Any, axis: int, side: int, kappa_e: float
    ) -> None:
        """Of a face of a block of a solid (fsipetsc.output.reader.Layer) with a conductivity."""

        def rows(values: Array) -> Array:
            """(3, …, n) of the face and the next two rows within; (2, …, n) of one cell."""
            values = np.moveaxis(values, -1 - axis, 0)
            return values[::-1][:3] if side else values[:3]

        self.name, self.solid = name, solid
        X, Y = (rows(layer.places[..., k])[0] for k in range(2))
        length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(X), np.diff(Y)))])
        flat = bool(np.ptp(Y) <= 1e-12 * length[-1] and X[-1] > X[0])
        self.X, self.Y = length + X[0] * flat, Y
        fields = {field: rows(layer[field]) for field in layer.fields}
        of_face = {field: values[0] for field, values in fields.items()}
        self.x, self.y, self.u, self.v, self.T = (of_face[field] for field in ("x", "y", *"uvT"))
        # with d_along along the face, into the solid is to its left (1) or to its right (-1)
        left = 1.0 if (axis == 0) == (side == 1) else -1.0

        def derivatives(f: Array) -> tuple[Array, Array]:
            """Along the face, and to its left per row."""
            inwards = f[1] - f[0]
            if len(f) > 2:  # else the block has one cell
                inwards -= 0.5 * (f[2] - 2.0 * f[1] + f[0])
            return _along(f[0], length), left * inwards

        (x_s, x_r), (y_s, y_r), (T_s, T_r) = (derivatives(fields[f]) for f in "xyT")
        size = left * np.hypot(x_s, y_s)
        self.n_x, self.n_y = n_x, n_y = y_s / size, -x_s / size
        self.t_x = of_face["s_xx"] * n_x + of_face["s_xy"] * n_y
        self.t_y = of_face["s_xy"] * n_x + of_face["s_yy"] * n_y
        self.pressure = -(self.t_x * n_x + self.t_y * n_y)
        J: Array = x_s * y_r - x_r * y_s
        self.heat = kappa_e * ((y_r * T_s - y_s * T_r) * n_x + (x_s * T_r - x_r * T_s) * n_y) / J
        X_s, Y_s, up = _along(X, length), _along(Y, length), self.y - Y
        self.displacement = up if flat else left * (X_s * up - Y_s * (self.x - X))


def _along(values: Array, length: Array) -> Array:
    """Derivative along a line."""
    order: Literal[1, 2] = 2 if len(length) > 2 else 1
    derivative: Array = np.gradient(values, length, axis=-1, edge_order=order)
    return derivative
