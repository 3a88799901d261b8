"""Two space dimensions, as a user meets them: orders, ranks, what is conserved, what the result holds."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import computed, solve

from fsipetsc.stepping.plane.fused import WARM

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


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """Results of the box on 1, 2, 4 ranks, and on two that have parts of all layers."""
    folder = tmp_path_factory.mktemp("box")
    (folder / "box2d.py").write_text(BOX)
    words = "box2d.py", "-fsi_points", "0,0.3,1"
    results = {n: computed(folder, f"{n}.h5", *words, ranks=n) for n in (1, 2, 4)}
    return {**results, "2 even": computed(folder, "even.h5", *words, "-fsi_partition", "balanced", ranks=2)}


@pytest.mark.parametrize("n", [2, 4, "2 even"])
def test_ranks_make_no_difference(box, n):
    one, several = box[1], box[n]
    watched = [name for name in one.series if name.endswith("_point")]
    assert len(watched) == 8 and one.series["q_point"].shape[1] == 6 == len(one.points)  # three on each interface
    for name in ("t", "least_J", *watched):
        assert np.array_equal(one.series[name], several.series[name]), name
    assert np.ptp(one.series["t_y_point"], axis=0)[[1, 4]].min() > 1e-5 and len(one.series["t"]) > 10
    for a, b in zip(one.layers, several.layers, strict=True):
        for name in a.fields:
            assert np.array_equal(a[name], b[name]), (a.name, name)


def test_nor_do_they_with_dissipation(tmp_path):
    """Of half the order and of shocks, in gas and solid: differences reach over cuts in both directions. The last steps are
    made by programs.
    """
    words = "blast -fluid_mu 0 -fluid_kappa 0 -blast_height 4 -fsi_h 0.0625 -ts_max_time 0.7 -fsi_dissipation 1 -fsi_shock 1"
    runs = [computed(tmp_path, f"{n}.h5", *words.split(), ranks=n) for n in (1, 4)]
    bare = computed(tmp_path, "bare.h5", *words.split()[:-4])
    one, *others = runs
    assert np.abs(one.layers[0]["p"][-1] - bare.layers[0]["p"][-1]).max() > 1e-2  # or it would be no test
    for several in others:
        assert np.array_equal(one.series["t"], several.series["t"]) and len(one.series["t"]) > WARM + 10
        for a, b in zip(one.layers, several.layers, strict=True):
            for name in a.fields:
                assert np.array_equal(a[name], b[name]), (a.name, name)


def test_a_closed_box_keeps_mass_and_energy(box):
    result = box[1]
    mass, energy = result.series["mass"], result.series["energy"]
    assert np.abs(mass / mass[0] - 1).max() < 2e-15
    assert np.abs(energy / energy[0] - 1).max() < 2e-15
    moved = result.layers[1]["y"][-1] - result.layers[1].Y[:, None]
    assert np.abs(moved).max() > 1e-4  # or it would be no test


def test_a_drift_beyond_what_is_allowed_stops_the_run(box, tmp_path):
    (tmp_path / "box2d.py").write_text(BOX)
    done = solve("box2d.py", "-fsi_check", "1e-10", "-fsi_quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    done = solve("box2d.py", "-fsi_check", "1e-16", "-fsi_quiet", cwd=tmp_path)
    assert done.returncode == 3 and "has drifted by" in done.stderr and done.stderr.count("\n") == 1


#: the same problem in one dimension and, without variation in X, in two: without friction, whose gradients differ
ONE = """
import numpy as np
from fsipetsc.boundaries import Wall
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.solid import Solid
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

OPTIONS = ()
DEFAULTS = {"fsi_h": 0.05, "ts_max_time": 0.2, "fsi_output_dt": 0.1, "fsi_mapping": "stretched"}


def gas(X):
    return [1 + 0.1 * np.cos(np.pi * X), 0.1 * np.sin(np.pi * X), 1 + 0.05 * np.cos(np.pi * X)]


def solid(X):
    return [0.1 * np.sin(np.pi * X), -1.0 + 0 * X, 1 + 0 * X, X]


def build(opt):
    material, elastic = Fluid(0.0, 0.0, 1.4, 1.0), Solid(20.0, 0.0, 2.0, 1.5)
    layers = (
        FluidLayer("below", material, (0.0, 1.0), gas),
        SolidLayer("solid", elastic, (1.0, 2.0), solid),
        FluidLayer("above", material, (2.0, 3.0), gas),
    )
    return Problem(layers, left=Wall(0.0), right=Wall(3.0), units="none")
"""
TWO = """
from one import gas, solid
from fsipetsc.boundaries.plane import NoSlip
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer

OPTIONS = ()
DEFAULTS = {"fsi_h": 0.05, "ts_max_time": 0.2, "fsi_output_dt": 0.1}


def plane_gas(X, Y):
    rho, v, T = gas(Y)
    return [rho, 0 * X, v, T]


def plane_solid(X, Y):
    v, _, T, y = solid(Y)
    return [0 * X, v, T, X, y]


def build(opt):
    material, elastic = Fluid(0.0, 0.0, 1.4, 1.0), PlaneSolid(5.0, 10.0, 0.0, 2.0, 1.5, p_ref=1.0)
    layers = (
        PlaneFluidLayer("below", material, (0.0, 1.0), plane_gas),
        PlaneSolidLayer("solid", elastic, (1.0, 2.0), plane_solid),
        PlaneFluidLayer("above", material, (2.0, 3.0), plane_gas),
    )
    return PlaneProblem(layers, X=(0.0, 0.6), lower=NoSlip(), upper=NoSlip(), units="none")
"""


@pytest.mark.long
def test_without_variation_in_x_it_is_the_run_in_one_dimension(tmp_path):
    (tmp_path / "one.py").write_text(ONE)
    (tmp_path / "two.py").write_text(TWO)
    options = "-ts_type", "rk", "-ts_dt", 2.5e-4, "-fsi_convection", "divergence"
    # with small steps: the stress that one dimension integrates is that of two but for the error of the method
    one, two = (computed(tmp_path, f"{n}.h5", f"{n}.py", *options) for n in ("one", "two"))
    for a, b in zip(one.layers, two.layers, strict=True):
        common = {"u": "v", "T": "T", "x": "y", **({"rho": "rho", "p": "p"} if a.kind == "fluid" else {"sigma": "s_yy"})}
        for name, other in common.items():
            assert np.abs(a[name][-1] - b[other][-1].T).max() < 1e-11, (a.name, name)
        assert np.abs(a["u"][-1] - a["u"][0]).max() > 0.01  # or it would be no test
        assert np.abs(b["u"]).max() == 0.0


def test_the_result_tells_its_shape(box):
    assert box[4].dimension == 2
    below, plate, _ = box[4].layers
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


#: a boundary layer, in parts slower than sound, that flows out
LAYER = """
import numpy as np
from fsipetsc.boundaries.plane import Given, NoSlip, Open, Outflow
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem

OPTIONS = ()
DEFAULTS = {"fsi_h": 0.0625, "ts_max_time": 3.0, "fsi_output_dt": 0.5}


def flow(X, Y, t=0.0):
    u = 2.0 * np.tanh(8.0 * Y)
    T = 1.0 + 0.17 * (4.0 - u * u)
    return [1.0 / T, u, 0.0 * X, T]


def build(opt):
    gas = Fluid(0.005, 0.0243, 1.4, 1 / 1.4)
    layer = PlaneFluidLayer("gas", gas, (0.0, 1.0), flow, left=Given(flow), right=Outflow(1 / 1.4))
    return PlaneProblem((layer,), X=(0.0, 1.0), lower=NoSlip(), upper=Open(1.0, 2.0, 0.0, 1.0), units="none")
"""


def test_a_boundary_layer_flows_out(tmp_path):
    """Towards a steady flow that nowhere goes back; without a pressure beyond it does, from t = 1.5 on."""
    (tmp_path / "layer.py").write_text(LAYER)
    gas = computed(tmp_path, "layer.h5", "layer.py").layers[0]
    assert gas["u"].min() > -1e-12
    assert 0.69 < gas["p"].min() and gas["p"].max() < 1.05
    assert np.abs(gas["u"][-1] - gas["u"][-2]).max() < 0.02
