"""The line of a face of a curved block: normals out of it, tractions and heat of a known state."""

from __future__ import annotations

import numpy as np
import pytest

from fsipetsc.output.interface_line import along_face

STRESS = np.array([[2.0, 0.3], [0.3, -1.0]])
#: temperature 3 x + 2 y, conductivity
GRADIENT, KAPPA = (3.0, 2.0), 2.0


class Block(dict):
    """A sheared block, deformed: its fields in one frame."""

    def __init__(self, n=1):
        xi, eta = np.meshgrid(np.linspace(0, 1, 20 * n + 1), np.linspace(0, 1, 16 * n + 1))
        self.X, self.Y = xi + 0.2 * eta * (1 + xi), 1.5 * eta + 0.1 * np.sin(2 * xi)
        self.places = np.stack([self.X, self.Y], axis=-1)
        x, y = self.X + 0.1 * self.Y**2, self.Y + 0.05 * self.X * self.Y
        T = GRADIENT[0] * x + GRADIENT[1] * y
        stresses = {"s_xx": STRESS[0, 0], "s_xy": STRESS[0, 1], "s_yy": STRESS[1, 1]}
        found = {"x": x, "y": y, "u": 0 * x, "v": 0 * x, "T": T}
        found |= {name: np.full_like(x, value) for name, value in stresses.items()}
        super().__init__({name: values[None] for name, values in found.items()})
        self.fields = tuple(self)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [0, 1])
def test_normal_traction_and_heat_on_all_faces(axis, side):
    block = Block()
    line = along_face("gas | body", 1, block, axis, side, KAPPA)
    along = block["x"][0, -1 if side else 0] if axis == 1 else block["x"][0, :, -1 if side else 0]
    assert np.array_equal(line.x[0], along)
    outward = (line.x - block["x"].mean()) * line.n_x + (line.y - block["y"].mean()) * line.n_y
    assert outward.min() > 0.0
    assert np.allclose(np.hypot(line.n_x, line.n_y), 1.0, atol=1e-14)
    steps = np.diff(line.x[0]), np.diff(line.y[0])
    middle = 0.5 * (line.n_x[0, 1:] + line.n_x[0, :-1]), 0.5 * (line.n_y[0, 1:] + line.n_y[0, :-1])
    across = steps[0] * middle[0] + steps[1] * middle[1]
    assert np.abs(across).max() < 2e-2 * np.hypot(*steps).max(), "normal to the line"
    assert np.allclose(line.t_x, STRESS[0, 0] * line.n_x + STRESS[0, 1] * line.n_y, atol=1e-14)
    assert np.allclose(line.t_y, STRESS[1, 0] * line.n_x + STRESS[1, 1] * line.n_y, atol=1e-14)
    heat = KAPPA * (GRADIENT[0] * line.n_x + GRADIENT[1] * line.n_y)
    assert np.allclose(line.heat, heat, atol=1e-11)
    # displacement along the normal of the reference map, of which the test has the derivatives
    xi, eta = np.linspace(0, 1, 21), np.linspace(0, 1, 17)
    if axis == 0:
        tangent = 0.2 * (1 + side) + 0.0 * eta, 1.5 + 0.0 * eta
    else:
        tangent = 1 + 0.2 * side + 0.0 * xi, 0.2 * np.cos(2 * xi)
    into = (1.0 if (axis == 0) == (side == 0) else -1.0) / np.hypot(*tangent)
    X, Y = (values[-side, :] if axis == 1 else values[:, -side] for values in (block.X, block.Y))
    expected = into * ((line.x - X) * tangent[1] - (line.y - Y) * tangent[0])
    assert np.abs(line.displacement - expected).max() < 5e-3 * np.abs(expected).max()
