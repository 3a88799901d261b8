"""A step of blocks that fails is made anew in shorter ones."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fsipetsc.blockrun.block_state import PARTS, BlockState
from fsipetsc.scheme.plan import BAD, RATE
from fsipetsc.scheme.runge_kutta import STAGES


class Run:
    """What BlockState._advance asks for; steps longer than ``longest`` leave a bad state."""

    def __init__(self, longest):
        self.y, self._before = SimpleNamespace(array=np.ones(3)), np.zeros(3)
        self.scheme, self.results = SimpleNamespace(step=self.step, forget=self.forget), np.ones(6)
        self._stage, self.forgotten, self.told = None, 0, set()
        self.evaluations, self.retries, self.longest, self.made = 0, 0, longest, []

    def step(self, t, dt, y, stage):
        self.made.append((t, dt))
        self.told.add(self.results[RATE])
        y.array += dt if dt <= self.longest else np.nan

    def forget(self):
        self.forgotten += 1

    def _guarded(self, action):
        action()

    def _monitor(self):
        self.results[BAD] = float(np.isnan(self.y.array).any())
        self.results[RATE] = np.inf if self.results[BAD] else 2.0


@pytest.mark.parametrize(("longest", "parts"), [(1.0, 1), (0.5, 2), (0.06, 16)])
def test_a_failed_step_is_made_in_parts(longest, parts):
    run = Run(longest)
    BlockState._advance(run, 2.0, 0.8)
    tried = PARTS[: PARTS.index(parts) + 1]
    assert run.evaluations == STAGES * sum(tried)
    assert run.retries == len(tried) - 1
    last = run.made[-tried[-1] :]
    np.testing.assert_allclose([t for t, _ in last], 2.0 + 0.8 * np.arange(tried[-1]) / tried[-1])
    assert {dt for _, dt in last} == {0.8 / tried[-1]}
    np.testing.assert_allclose(run.y.array, 1.8)
    assert run._t == 2.8 and run.results[BAD] == 0.0
    assert run.told == {1.0}, "data in time are found with the rate of the good state"
    assert run.forgotten == run.retries and run.results[RATE] == 2.0


def test_a_step_that_cannot_be_made_stays_bad():
    run = Run(1e-3)
    BlockState._advance(run, 0.0, 1.0)
    assert run.results[BAD] == 1.0 and run.retries == len(PARTS) - 1
    assert np.isnan(run.y.array).all()
