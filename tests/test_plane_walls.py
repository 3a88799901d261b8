"""Edges of two dimensions that move as the case says: pistons, walls that bend, data on them."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, computed, solve

from fsipetsc.boundaries.plane import Clamped, Given, NoSlip, Slip
from fsipetsc.errors import InputError
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer

EDGES = REPOSITORY / "tests" / "moving_edges.py"
WAVES = "-wall", "waves", "-ts_max_time", 0.5, "-fsi_output_dt", 0.25


def test_a_piston(tmp_path):
    """Errors fall with the order of the closures, whatever stands at the wall."""
    for wall, most in (("NoSlip", 7.5e-5), ("Slip", 3.1e-5), ("Given", 5.2e-5)):
        errors = []
        for h in (0.05, 0.025):
            result = computed(tmp_path, f"{wall}{h}.h5", EDGES, "-wall", wall, "-fsi_h", h)
            errors.append(result.errors["fluid"]["combined"])
            layer = result.layers[0]
            assert np.abs(layer.y[-1, 0] + 0.9**4 / 4).max() < 1e-15 and np.abs(layer["u"]).max() < 1e-13
            if wall == "NoSlip":
                assert np.abs(layer["v"][-1, 0] + 0.9**3).max() < 1e-9  # found by differences of x
        assert errors[1] < most and np.log2(errors[0] / errors[1]) > 2.6, (wall, errors)


def test_a_velocity_that_is_known(tmp_path):
    one, two = (computed(tmp_path, f"{known}.h5", EDGES, "-known", known) for known in (0, 1))
    assert np.abs(one.layers[0]["v"][-1] - two.layers[0]["v"][-1]).max() < 1e-8
    assert np.abs(two.layers[0]["v"][-1, 0] + 0.9**3).max() < 1e-15


def test_a_floor_that_waves(tmp_path):
    """No gas is lost; it goes with the floor, has its temperature, and the bits do not depend on ranks."""
    one, three = (computed(tmp_path, f"{n}.h5", EDGES, *WAVES, ranks=n) for n in (1, 3))
    layer, mass = one.layers[0], one.series["mass"][:, 0]
    assert np.abs(mass / mass[0] - 1).max() < 1e-14
    assert np.allclose(layer.y[:, 0], 0.1 * np.sin(np.pi * layer.X) ** 2 * np.sin(2 * one.time)[:, None], rtol=0, atol=1e-15)
    assert np.allclose(layer["T"][-1, 0], 1.0) and np.ptp(layer["T"][-1]) > 0.01
    for name in layer.fields:
        assert np.array_equal(layer[name], three.layers[0][name]), name


def test_gas_that_moves_at_first_sticks_to_walls_without_heat(tmp_path):
    """Not that its motion there becomes heat at once; nor beside a wall, where the wall's motion is what it gets."""
    text = EDGES.read_text().replace("(1.0, 0.0, 0.0, 1.0)", "(1.0, 0.5, 0.3, 1.0)").replace("T=1.0, x=floor", "x=floor")
    (tmp_path / "wind.py").write_text(text)
    (tmp_path / "receding.py").write_text((REPOSITORY / "tests" / "receding.py").read_text())
    for ranks in (1, 3):
        layer = computed(tmp_path, f"{ranks}.h5", "wind.py", *WAVES, "-ts_max_steps", 1, ranks=ranks).layers[0]
        assert np.abs(layer["T"][0] - 1.0).max() < 1e-14 and np.abs(layer["u"][0, -1]).max() == 0.0
        assert np.allclose(layer["v"][0, 0], 0.2 * np.sin(np.pi * layer.X) ** 2, rtol=0, atol=1e-12)


def test_what_cannot_be(tmp_path):
    def still(X, t):
        return X, 0.0

    gas = Fluid(0.0, 0.0, 1.4, 1.0)
    with pytest.raises(InputError, match="velocity is given, and x is not"):
        Slip(velocity=still)
    with pytest.raises(InputError, match=r"NoSlip: x is 3 \(int\)|NoSlip: x is 3"):
        NoSlip(x=3)
    with pytest.raises(InputError, match=r"left moves: expected that of the lower or upper edge"):
        PlaneFluidLayer("gas", gas, (0.0, 1.0), lambda X, Y: (1, 0, 0, 1), left=Slip(x=still), right=Slip())
    with pytest.raises(InputError, match="beside moves"):
        PlaneFluidLayer("gas", gas, (0.0, 1.0), lambda X, Y: (1, 0, 0, 1), beside=Slip(x=still))
    solid = PlaneSolidLayer("solid", PlaneSolid(1.0, 1.0, 0.0, 1.0, 1.0), (0.0, 1.0), lambda X, Y: (0, 0, 1, X, Y))
    with pytest.raises(InputError, match="upper: Given of a solid has x among its values"):
        PlaneProblem((solid,), (0.0, 1.0), Clamped(), Given(lambda X, Y, t: (0, 0, 1, X, Y), x=still))
    (tmp_path / "waves.py").write_text(EDGES.read_text().replace("return X, 0.1", "return 0.1"))
    (tmp_path / "receding.py").write_text((REPOSITORY / "tests" / "receding.py").read_text())
    done = solve("waves.py", *WAVES, cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr.count("fsipetsc: error: ")) == (2, 1) and not list(tmp_path.glob("*.h5"))
    assert "x of an edge of layer 'gas' at t = 0" in done.stderr and "waves.py, line 31" in done.stderr


def test_a_temperature_beside_a_panel_may_depend_on_time():
    """It is asked for in each step then."""
    wall, material = NoSlip(T=lambda X, Y, t: 1 + t), Fluid(0.01, 0.01, 1.4, 1.0)
    gas = PlaneFluidLayer("gas", material, (0.0, 1.0), lambda X, Y: (1, 0, 0, 1), Slip(), Slip(), wall)
    solid = PlaneSolid(1.0, 1.0, 0.0, 1.0, 1.0)
    panel = PlaneSolidLayer("panel", solid, (-0.1, 0.0), lambda X, Y: (0, 0, 1, X, Y), (0.2, 0.8), Clamped(), Clamped(), 8)
    assert not PlaneProblem((panel, gas), (0.0, 1.0), Clamped(), Slip()).steady_data
