"""Two space dimensions, as a user meets them: orders, ranks, what is conserved, what the result holds."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import mpirun, run

import fsipetsc

#: gas | plate | gas, of which every kind of edge is one: closed but for the heat, and at rest but for a bump
BOX = """
from fsipetsc.boundaries.plane import Clamped, NoSlip, Slip
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer
import numpy as np

OPTIONS = ()
DEFAULTS = {"fsi_h": 1 / 16, "ts_max_time": 0.2, "fsi_output_dt": 0.1}
gas = Fluid(0.002, 0.003, 1.4, 1.0)
plate = PlaneSolid(10.0, 20.0, 0.01, 5.0, 1.0, p_ref=1.0)


def bump(X, Y):
    return 1 + 0.3 * np.exp(-40 * ((X - 0.4) ** 2 + (Y - 0.6) ** 2)), 0 * X, 0 * X, 1 + 0 * X


def rest(X, Y):
    return 0 * X, 0 * X, 1 + 0 * X, X, Y


def build(opt):
    return PlaneProblem(
        layers=(
            PlaneFluidLayer("below", gas, (0, 1), bump, left=Slip(), right=NoSlip()),
            PlaneSolidLayer("plate", plate, (1, 1.5), rest, left=Clamped(), right=Clamped()),
            PlaneFluidLayer("above", gas, (1.5, 2.5), lambda X, Y: (1 + 0 * X, 0, 0, 1), left=Slip(), right=Slip()),
        ),
        X=(0, 1),
        lower=NoSlip(),
        upper=Slip(),
        units="none",
    )
"""


def computed(folder, name, *words, ranks=1):
    """The result of a run, opened."""
    arguments = ("-m", "fsipetsc", *words, "-fsi_output", name, "-fsi_quiet")
    done = run(*arguments, cwd=folder) if ranks == 1 else mpirun(ranks, *arguments, cwd=folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return fsipetsc.open_run(folder / name)


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """Results of the box on 1, 2, 3, 6 ranks."""
    folder = tmp_path_factory.mktemp("box")
    (folder / "box2d.py").write_text(BOX)
    return {n: computed(folder, f"{n}.h5", "box2d.py", ranks=n) for n in (1, 2, 3, 6)}


@pytest.mark.parametrize("n", [2, 3, 6])
def test_ranks_make_no_difference(box, n):
    one, several = box[1], box[n]
    assert np.array_equal(one.series["t"], several.series["t"]) and len(one.series["t"]) > 10
    for a, b in zip(one.layers, several.layers, strict=True):
        for name in a.fields:
            assert np.array_equal(a[name], b[name]), (a.name, name)


def test_a_closed_box_keeps_mass_and_energy(box):
    result = box[1]
    mass, energy = result.series["mass"], result.series["energy"]
    assert np.abs(mass / mass[0] - 1).max() < 2e-15
    assert np.abs(energy / energy[0] - 1).max() < 1e-9  # that of the Runge-Kutta method within the solid
    moved = result.layers[1]["y"][-1] - result.layers[1].Y[:, None]
    assert np.abs(moved).max() > 1e-4  # or it would be no test


def test_the_result_tells_its_shape(box):
    assert box[3].dimension == 2
    below, plate, _ = box[3].layers
    assert below["rho"].shape == (3, 17, 17) and plate["s_xy"].shape == (3, 9, 17)
    assert below.X.shape == (17,) and below.Y[-1] == 1.0 and plate.Y[0] == 1.0
    # what lies on the interface belongs to both
    assert np.allclose(below["y"][:, -1], plate["y"][:, 0], rtol=0, atol=1e-14)
    assert np.allclose(below["u"][:, -1], plate["u"][:, 0], rtol=0, atol=1e-15)
    assert below.frame(-1)["x"].shape == (17, 17)


def test_orders(tmp_path):
    """The manufactured solution, from 16 to 32 columns: a moving interface that bends, both layers non-linear."""
    for order, (gas, solid) in {2: (1.9, 1.9), 4: (3.5, 3.4), 6: (4.6, 4.3)}.items():
        errors = []
        for n in (16, 32):
            result = computed(tmp_path, f"{order}-{n}.h5", "plane_mms", "-fsi_order", order, "-fsi_h", 1 / n, "-fsi_cfl", 0.5)
            errors.append([result.errors[kind]["combined"] for kind in ("fluid", "solid")])
        found = np.log2(np.divide(*errors))
        assert found[0] > gas and found[1] > solid, (order, errors, found)
