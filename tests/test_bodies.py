"""The cases of bodies in a flow, `step`, `fin` and `cylinder`: balances, ranks, and what holds a corner."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import computed

pytest.importorskip("petsc4py")

from fsipetsc.cases.fin import AHEAD
from fsipetsc.cases.riemann import behind_shock
from fsipetsc.materials.fluid import Fluid

RUNS = {
    "step": "step -fsi_h 0.04",
    "fin": "fin -fsi_h 0.005",
    "cylinder": "cylinder -fsi_h 0.1 -solid_density 1",
    "rigid": "cylinder -fsi_h 0.1 -cylinder_wall rigid",
}
#: that waves come to the bodies, and from them to blocks further on
STEPS = 30


@pytest.fixture(scope="module")
def bodies(tmp_path_factory):
    """bodies(name, ranks): the result of a few steps, which are held to balances of mass, momentum and energy."""
    folder, known = tmp_path_factory.mktemp("bodies"), {}

    def result(name, ranks=1):
        if (name, ranks) not in known:
            words = *RUNS[name].split(), "-ts_max_steps", STEPS, "-fsi_check", 1e-12
            known[name, ranks] = computed(folder, f"{name}{ranks}.h5", *words, ranks=ranks)
        return known[name, ranks]

    return result


@pytest.mark.mpi
@pytest.mark.parametrize("name", RUNS)
def test_ranks_make_no_difference_and_balances_close(bodies, name):
    one, two = bodies(name), bodies(name, 2)
    assert len(one.series["t"]) == STEPS
    for layer, other in zip(one.layers, two.layers, strict=True):
        for field in layer.fields:
            assert np.array_equal(layer[field], other[field]), (layer.name, field)


def test_gas_goes_around_the_edge_of_a_step(bodies):
    """Front and top are one wall there: no gas goes through the sum of both, as large as their cells, and it is not at rest."""
    before, _, over = bodies("step").layers
    u, v = (before[name][-1][-1, -1] for name in ("u", "v"))
    front, top = before.Y[-1] - before.Y[-2], over.X[1] - over.X[0]
    assert abs(u * front - v * top) < 1e-14 and u > 0.1
    corner = [before[name][-1][0, -1] for name in ("u", "v")]
    assert np.abs(corner).max() == 0.0  # where floor and front meet


def test_the_shock_of_the_fin_is_that_of_the_experiment():
    behind, _ = behind_shock(Fluid(0.0, 0.0, 1.4, 287.0), AHEAD, 1.21)
    assert np.allclose(behind, (1.63, 109.6, 155.7e3), rtol=2e-3, atol=0.0)


@pytest.mark.parametrize("name", ["cylinder", "rigid"])
def test_what_hits_a_cylinder_is_the_same_above_and_below(bodies, name):
    """Blocks above and below are turned against each other."""
    series = bodies(name).series
    assert np.abs(series["momentum_y"]).max() < 1e-12 * np.abs(series["momentum_x"]).max()
