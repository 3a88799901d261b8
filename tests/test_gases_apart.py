"""Gases of different laws with solids between them (gases.py): each has its own temperature."""

import gases
import numpy as np
import pytest
from helpers import computed, on_ranks
from mpi4py import MPI

from fsipetsc.blockrun.block_solution import BlockForm
from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.blocks.conditions import Given
from fsipetsc.parallel.block_layout import BlockVector

LONG = pytest.mark.long


@pytest.mark.parametrize("conduct", ["yes", "no"])
def test_what_is_at_rest_stays(conduct, tmp_path):
    words = "-gases_conduct", conduct, "-ts_max_time", "1"
    run = computed(tmp_path, "rest.h5", gases.__file__, *words)
    for layer in run.layers:
        last = layer.frame(-1)
        np.testing.assert_allclose(last["T"], 1.5, rtol=1e-9)
        assert np.abs(last["u"]).max() < 1e-9


def test_a_steady_flow_of_heat_stays(tmp_path):
    """Through all layers, from a wall of T = 1 to one of T = 2."""
    errors = []
    for cells in (12, 24):
        words = "-gases_T", "1,2", "-fsi_order", "6", "-fsi_h", f"{1 / cells}"
        run = computed(tmp_path, f"{cells}.h5", gases.__file__, *words)
        frames = [layer.frame(-1) for layer in run.layers]
        x, T = (np.concatenate([frame[name] for frame in frames]) for name in ("x", "T"))
        errors.append(np.abs(T - gases.profile(x, (1.0, 2.0))).max())
    assert errors[1] < min(1e-6, errors[0] / 8)


@LONG
def test_the_number_of_ranks_does_not_matter(tmp_path):
    on_ranks(tmp_path, f"{gases.__file__} -gases_T 1,2", 1, 2)


@pytest.mark.parametrize(
    ("d", "symmetry"),
    [pytest.param(1, 0, marks=LONG), pytest.param(2, 0, marks=LONG), (2, 1), (3, 0)],
)
def test_conditions_keep_a_state_of_rest(d, symmetry):
    """Walls with T, gas and solid with one temperature, and a gas of which all is given."""
    T, along = 1.5, ((0.0, 1.0), (0.0, 1.0))[: d - 1]
    own = gases.materials()[-1].gas_law
    upper = Given(lambda *at: (own.density(gases.P, T), *[0.0] * d, T))
    more = {"along": along, "cells": (8, 8)[: d - 1], "h": 0.125, "low": 0.5, "symmetry": symmetry}
    problem = gases.stack(d, (T, T), upper=upper, **more)
    form = BlockForm("entropy", -1.0, 0.0)
    with BlockState(MPI.COMM_SELF, problem, 4, form) as state:
        scheme, first = state.scheme, BlockVector(state.layout)
        scheme.initial(0.0, state.y)
        first.array[:] = state.y.array
        scheme.complete(0.0, state.y)
        for k in state.layout.parts:
            before, after = first.owned(k), state.y.owned(k)
            np.testing.assert_allclose(after, before, rtol=1e-13, atol=1e-13)
