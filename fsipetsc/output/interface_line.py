"""An interface in two dimensions as a line: where it is, and how it moves."""

from typing import Any

import numpy as np

from fsipetsc.checks import Array


class InterfaceLine:
    """The face of the solid at an interface; all but X and Y are (nframes, n).

    name, solid    of the interface; number of the block that is the solid
    X              (n,) [m] length along the face in the reference map; X where that is a straight
                   line along X
    Y              (n,) [m] reference height
    x, y, u, v, T  position, velocity and temperature of the solid
    displacement   [m] y - Y; of a face that is not flat along X, along the normal of the reference
                   into the solid
    """

    def __init__(self, name: str, solid: int, layer: Any, axis: int, side: int) -> None:
        """Of a face of a block of a solid (fsipetsc.output.reader.Layer)."""

        def row(values: Array) -> Array:
            taken: Array = values.take(-side, axis=-1 - axis)
            return taken

        self.name, self.solid = name, solid
        X, Y = (row(layer.places[..., k]) for k in range(2))
        length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(X), np.diff(Y)))])
        flat = bool(np.ptp(Y) <= 1e-12 * length[-1] and X[-1] > X[0])
        self.X, self.Y = length + X[0] * flat, Y
        self.x, self.y, self.u, self.v, self.T = (row(layer[name]) for name in ("x", "y", *"uvT"))
        # along the face, into the solid is to the left (1) or to the right (-1)
        left = 1.0 if (axis == 0) == (side == 1) else -1.0
        order: Any = min(2, len(length) - 1)
        X_s, Y_s = (np.gradient(values, length, edge_order=order) for values in (X, Y))
        up = self.y - Y
        self.displacement = up if flat else left * (X_s * up - Y_s * (self.x - X))
