"""The sound pulse against linear acoustics: what is reflected, what goes through, what leaves."""

import numpy as np
import pytest
from helpers import computed

from fsipetsc.cases import pulse

AMPLITUDE = 0.01
#: where the pulse starts, in the gas or in the solid -> time at which both waves are inside
INSIDE = {0.75: 0.0035, -0.75: 0.003}
STARTS = pytest.mark.parametrize("start", INSIDE, ids=["from the fluid", "from the solid"])
#: density and modulus; the wave speed is 500 m/s in all. The gas: 1.16 kg/m3, 347 m/s
SOLIDS = {"light": (1.0, 2.5e5), "middle": (4.0, 1e6), "heavy": (4e4, 1e10)}


def pulsed(folder, start, end, words=""):
    """The result of a run to this time."""
    line = f"pulse -pulse_amplitude {AMPLITUDE} -fsi_output_dt 1 -pulse_start {start} {words}"
    return computed(folder, "pulse.h5", *line.split(), "-ts_max_time", end)


def linear_problem(run):
    """(case's problem, its Acoustics) of a run."""
    problem = pulse.build(run.options)
    solid, gas = problem.layers
    return problem, pulse.acoustics(run.options, gas.material, solid.material)


@STARTS
@pytest.mark.parametrize("solid", SOLIDS)
def test_reflection_and_transmission(start, solid, tmp_path):
    """From a solid as light as the gas to one 40,000 times as heavy, to a part in a thousand of
    what comes in."""
    words = "-fsi_order 6 -solid_density {} -solid_modulus {}".format(*SOLIDS[solid])
    run = pulsed(tmp_path, start, INSIDE[start], words)
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
def test_waves_leave_through_the_ends(start, tmp_path):
    """After both waves have left, what is reflected at the open and the absorbing end is small."""
    solid, gas = pulsed(tmp_path, start, 0.01).layers
    assert np.abs(solid["sigma"][-1] + 1e5).max() < 0.01 * AMPLITUDE
    assert np.nanmax(np.abs(gas["p"][-1] - 1e5)) < 0.01 * AMPLITUDE
