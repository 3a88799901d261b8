"""The linear theory: stability of couplings (Theorem 4.1), modes of a gas over an elastic layer."""

import pytest
from helpers import rows_of, solve, well

from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import Solid
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.studies.stability import Constant, measure

ORDERS = pytest.mark.parametrize("order", OPERATORS)
N = 16  # disturbed points of a layer, enough for all orders
#: of densities and stiffnesses
RATIOS = (1e-3, 1e2), (1e3, 1e-2), (1.0, 1.0)
INVISCID = {"mu": 0.0, "kappa": 0.0}


def constant(density=2.0, stiffness=3.0, eos="ideal", stretch=1.0, **gas):
    """Gas with p = 1.2, rho = 1.5; a solid of heat capacity alpha m0 = 2.5, its stress 0 or -p."""
    fluid = Fluid(**{"mu": 0.01, "kappa": 0.03, "gamma": 1.4, "R": 1.0, **gas})
    p, m0, kappa_e = 1.2, density * 1.5, 0.02 if fluid.kappa else 0.0
    gruneisen = p * stretch / (2.5 * 0.8) if eos == "ideal" else 0.0
    solid = Solid(stiffness * p, kappa_e, m0, 2.5 / m0, 0.0, gruneisen)
    return Constant(fluid, solid, 1.5, 0.8, stretch)


@ORDERS
@pytest.mark.parametrize("state", [{"stretch": 0.7}, {"eos": "elastic"}, INVISCID])
def test_theorem_4_1_holds_to_round_off(order, state):
    for coupling, narrow, ratios in (
        *(("energy", False, RATIOS[0]), ("energy", True, RATIOS[1])),
        ("conservative", False, RATIOS[order % 4 // 2]),
    ):
        result = measure(constant(*ratios, **state), order, N, 1 / N, coupling, narrow)
        assert result.estimate and result.stable and result.step_kept
        assert result.energy < 1e-11 and result.step_ratio < 4.0


@ORDERS
def test_projection_and_traditional(order):
    """The one has no growing mode, though energy may grow; the other fails for light solids."""
    for density, stiffness in RATIOS:
        state = constant(density, stiffness, "elastic")
        result = measure(state, order, 2 * N, 0.5 / N, "projection")
        assert result.energy > 1e-4 and result.stable and result.step_kept
    light, heavy = (
        measure(constant(density, 1.0), order, N, 1 / N, "traditional") for density in (1e-3, 1e3)
    )
    assert light.energy > 1.0 and light.step_ratio < 0.4 * heavy.step_ratio


def test_energy_holds_everywhere_on_any_ranks(tmp_path):
    words = "-stability_points 16 -density_ratios 1e-3,1 -stiffness_ratios 0.01,100".split()
    for ranks in (1, 2):
        well(solve("stability", *words, "-fsi_output", ranks, cwd=tmp_path, ranks=ranks))
    rows = rows_of(tmp_path / "1.csv")
    assert len(rows) == 4 * 4 and rows == rows_of(tmp_path / "2.csv")
    assert all(row[n] == "True" for row in rows for n in ("estimate", "stable", "step_kept"))
