"""Open edges in two dimensions: a uniform flow stays, waves leave."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import computed

CHANNEL = """
import numpy as np
from fsipetsc.boundaries.plane import Open, Outflow, Slip
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem

OPTIONS = (Option("mach", float, 0.0, "", "of the flow"), Option("size", float, 1e-3, "", "of the pulse"))
DEFAULTS = {"fsi_h": 1 / 24, "ts_max_time": 2.0, "fsi_output_dt": 0.5}


def build(opt):
    gas, M = Fluid(0.0, 0.0, 1.4, 1 / 1.4), opt["mach"]

    def pulse(X, Y):
        p = (1 + opt["size"] * np.exp(-((X - 0.5) ** 2 + (Y - 0.5) ** 2) / 0.12**2)) / 1.4
        rho = (1.4 * p) ** (1 / 1.4)
        return rho, M, 0.0, p / rho * 1.4

    out = Open(1.0, M, 0.0, 1.0)
    fast = M > 1
    layer = PlaneFluidLayer("gas", gas, (0.0, 1.0), pulse, left=out, right=Outflow() if fast else out)
    return PlaneProblem((layer,), (0.0, 1.0), Slip() if fast else out, out, units="none")
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "channel.py").write_text(CHANNEL)
    return tmp_path


@pytest.mark.parametrize("order", [4, 8])
def test_a_uniform_supersonic_flow_stays(folder, order):
    """In at the left, out at the right, along a wall, an open edge above: 250 steps."""
    result = computed(folder, "uniform.h5", "channel.py", "-mach", 2, "-size", 0, "-fsi_order", order)
    layer = result.layers[0]
    assert len(result.series["t"]) > 200
    for name, value in (("rho", 1.0), ("u", 2.0), ("v", 0.0), ("T", 1.0)):
        assert np.abs(layer[name] - value).max() < 1e-13, name


@pytest.mark.parametrize(("mach", "most"), [(2, (0.013, 0.01)), (0, (0.04, 0.01))])
def test_a_pulse_leaves(folder, mach, most):
    """Of its pressure; what is left without dissipation are waves that the grid does not resolve."""
    result = computed(folder, "pulse.h5", "channel.py", "-mach", mach)
    left = np.abs(result.layers[0]["p"] - 1 / 1.4).max((1, 2))
    assert left[1] > 0.1 * left[0]  # it has become a ring, which meets the edges now
    assert (left[[2, 4]] < np.array(most) * left[0]).all(), left / left[0]
