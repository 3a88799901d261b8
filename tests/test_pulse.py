"""The sound pulse against linear acoustics: what is reflected, what goes through, what leaves."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import PULSE_STARTS, SOLIDS

from fsipetsc.cases import pulse

pytest.importorskip("petsc4py")

AMPLITUDE = 0.01
STARTS = pytest.mark.parametrize("start", PULSE_STARTS, ids=["from the fluid", "from the solid"])


def linear_problem(run):
    """(case's problem, its Acoustics) of a run."""
    problem = pulse.build(run.options)
    solid, gas = problem.layers
    return problem, pulse.acoustics(run.options, gas.material, solid.material)


@STARTS
@pytest.mark.parametrize("solid", SOLIDS)
def test_reflection_and_transmission(computed, start, solid):
    """From a solid as light as the gas to one 40,000 times as heavy, to a part in a thousand of
    what comes in."""
    run = computed("pulse", f"{solid}_{start}")
    problem, linear = linear_problem(run)
    for saved, layer, name, sign, at_rest in (
        (run.layers[0], problem.layers[0], "sigma", -1, -1e5),
        (run.layers[1], problem.layers[1], "p", 1, 1e5),
    ):
        first = (layer.kind == "fluid") == (linear.side > 0)
        shape, _, _ = linear.waves(saved.X, run.time[-1], first)
        active = np.isfinite(saved[name][-1])
        wave, shape = saved[name][-1][active] - at_rest, sign * shape[active]
        if np.abs(shape).max() < 1e-3 * AMPLITUDE:
            assert np.abs(wave).max() < 2e-3 * AMPLITUDE
        else:
            part = linear.reflection if first else linear.transmission
            assert abs(wave @ shape / (shape @ shape) - 1) * abs(part) < 1e-3


@STARTS
def test_waves_leave_through_the_ends(computed, start):
    """After both waves have left, what is reflected at the open and the absorbing end is small."""
    solid, gas = computed("pulse", f"out_{start}").layers
    assert np.abs(solid["sigma"][-1] + 1e5).max() < 0.01 * AMPLITUDE
    assert np.nanmax(np.abs(gas["p"][-1] - 1e5)) < 0.01 * AMPLITUDE
