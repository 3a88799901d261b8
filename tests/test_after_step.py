"""What follows a step of blocks: flags, the bound on the next step, the plan of a batch."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")

from fsipetsc.scheme.after_step import note_extremes, note_gained
from fsipetsc.scheme.batch import LONGEST, MADE, TIME, plan_next
from fsipetsc.scheme.block_monitor import MONITORED
from fsipetsc.scheme.plan import (
    BAD,
    BATCH,
    EXHAUSTED,
    FLAGS,
    LIMITS,
    RATE,
    STOP,
    TOO_SHORT,
)
from fsipetsc.scheme.time_step import next_step


def noted(rows, stop=0.0):
    """(rates, results, latest) of the extremes of some blocks."""
    rows = np.array(rows)
    rates, results = np.zeros((len(rows), 2)), np.zeros(FLAGS + LIMITS)
    latest = np.zeros(2 * len(rows) + 3)
    assert rows.shape[1] == MONITORED
    note_extremes(np.concatenate([[stop], rows.ravel()]), rates, results, latest)
    return rates, results, latest


def test_the_bound_is_the_4_norm_of_the_largest_rates():
    rows = [[0.0, 3.0, 1.0, -0.5, 0.1], [0.0, 2.0, 4.0, -0.25, 0.2]]
    rates, results, latest = noted(rows, stop=0.5)
    assert np.array_equal(rates, [[3.0, 1.0], [2.0, 4.0]])
    assert results[RATE] == pytest.approx((3.0**4 + 4.0**4) ** 0.25, rel=1e-15)
    assert (results[BAD], results[STOP]) == (0.0, 0.5)
    assert latest.tolist() == [0.5, 0.25, 0.1, 0.2, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("k", [0, 1])
@pytest.mark.parametrize("column", [1, 2])
def test_what_is_no_number_stays_one(k, column):
    rows = np.ones((2, MONITORED))
    rows[:, 0] = 0.0
    rows[k, column] = np.nan
    assert np.isnan(noted(rows)[1][RATE])
    rows[1 - k, 0] = 1.0
    assert noted(rows)[1][BAD] == 1.0


def planned(target, allowed, *, rate=10.0, courant=0.8, fixed=0.0, end=None, flag=STOP):
    """Times and steps of a batch from t = 0 in the journal, and the batch itself."""
    batch, results = np.zeros(BATCH), np.zeros(FLAGS + LIMITS)
    journal, latest = np.zeros((32, 4)), np.array([7.0, 8.0])
    results[RATE] = rate
    dt = fixed or courant / rate
    batch[:] = 0.0, dt, dt, target, courant, fixed, allowed, 0.0, 0.0, 3.0
    for step in range(40):
        if step == end:
            results[flag] = 1.0
        if not plan_next(batch, results, journal, latest):
            break
    made = int(batch[MADE])
    assert (journal[:3] == 0.0).all() and (journal[3 + made :] == 0.0).all()
    assert (journal[3 : 3 + made, 2:] == latest).all()
    assert not plan_next(batch, results, journal, latest), "it has ended"
    return journal[3 : 3 + made, :2], batch


def test_a_batch_hits_its_target_without_a_tiny_step():
    rows, batch = planned(0.5, 20)
    assert rows[-1, 0] == 0.5 and batch[TIME] == 0.5
    assert np.allclose(rows[:, 1], [0.08] * 5 + [0.05] * 2), "the rest in two equal steps"
    assert np.allclose(np.cumsum(rows[:, 1]), rows[:, 0], rtol=1e-15)
    assert np.allclose(planned(0.22, 20)[0][:, 1], [0.08, 0.07, 0.07])
    assert next_step(0.0, 0.1, 0.1 * (1.0 - 1e-12)) == (0.1, 0.1), "round-off costs no step"
    assert batch[LONGEST] == rows[:, 1].max()


@pytest.mark.parametrize("flag", [EXHAUSTED, TOO_SHORT, BAD, STOP])
def test_a_batch_ends_with_the_step_after_which_a_flag_is_set(flag):
    assert len(planned(5.0, 20, end=2, flag=flag)[0]) == 3


def test_a_batch_has_as_many_steps_as_are_allowed_and_ends_without_a_bound():
    assert len(planned(5.0, 4)[0]) == 4
    rows, _ = planned(0.5, 20, fixed=0.1)
    np.testing.assert_allclose(rows[:, 1], [0.1] * 5)
    for rate in (np.inf, np.nan, 0.0):
        assert len(planned(5.0, 20, fixed=0.1, rate=rate)[0]) == 1


def test_energy_that_was_there_is_remembered_in_auxiliary_unknowns():
    """Work 2, then 1; the energies that the monitor leaves are 10 and 10.5: 0.5 is lost. Beside it
    a sum that nothing was there of before.
    """
    auxiliary, latest = np.array([2.0, 3.0]), np.array([7.0, -10.0, 0.0])
    note_gained(latest, auxiliary)
    assert latest[::2].tolist() == [7.0, 3.0] and auxiliary.tolist() == [10.0, 0.0]
    auxiliary += 1.0, 4.0
    latest[:] = 7.0, -10.5, 0.0
    note_gained(latest, auxiliary)
    assert latest.tolist() == [7.0, 0.5, 4.0]
