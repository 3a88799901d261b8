"""A step of blocks that fails is made anew in shorter ones."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("petsc4py")

from test_stretched import Case, column

from fsipetsc.blockrun.block_state import PARTS
from fsipetsc.boundaries import Wall
from fsipetsc.scheme.plan import BAD, RATE


@pytest.mark.parametrize("dt", [0.2, 0.5, 50.0])
def test_a_failed_step_is_made_in_parts(dt):
    """As if they had been made one by one, with the data in time found by the rate of the good
    state; one that cannot be made stays bad.
    """
    walls = Wall(lambda t: 0.02 * np.sin(3.0 * t)), Wall(1.0)
    problem = column(*walls, speed=lambda X: 0.5 * np.sin(2 * np.pi * X))
    with Case(problem, fsi_order=2, fsi_h=1 / 20).state() as state:
        state.set_initial()
        state.finish()
        start, rate = state.y.array.copy(), state.results[RATE]
        forgotten, forget = [], state.scheme.forget
        state.scheme.forget = lambda: forgotten.append(forget())  # no NaN may stay in its memory
        state._advance(0.0, dt)
        found, tried = state.y.owned(0).copy(), PARTS[: state.retries + 1]
        assert state.evaluations == 4 * sum(tried) and len(forgotten) == state.retries
        if dt > 1.0:
            assert tried == PARTS and state.results[BAD] == 1.0
            return
        assert (len(tried) == 1) == (dt < 0.3) and state.results[BAD] == 0.0
        state.scheme.forget()
        state.y.array[:], state.results[RATE] = start, rate
        for part in range(tried[-1]):
            state.scheme.step(dt * part / tried[-1], dt / tried[-1], state.y, state._stage)
        assert np.array_equal(state.y.owned(0), found)
