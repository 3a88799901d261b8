"""Time stepping: the clock, saved times, every method of PETSc's with its order, and step-size
control.
"""

from __future__ import annotations

import numpy as np
import pytest
from conftest import FUSED, METHODS, STEPS, fixed

pytest.importorskip("petsc4py")

from fsipetsc.errors import InputError
from fsipetsc.stepping.output_times import saved_times

# the clock


def test_saved_times():
    assert saved_times(1.0, 0.25, None) == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert saved_times(1.0, 0.4, None) == [0.0, 0.4, 0.8, 1.0]
    assert saved_times(1.0, None, (0.3, 0.7)) == [0.3, 0.7, 1.0]
    assert saved_times(1.0, 0.5, (0.3, 1.0)) == [0.0, 0.3, 0.5, 1.0]
    assert saved_times(0.0, 0.5, None) == [0.0]
    assert saved_times(0.3, 0.1, None)[-1] == 0.3
    assert len(saved_times(3.0, 0.02, None)) == 151, "3.0 / 0.02 is not 150 in floating point"
    assert saved_times(1.0, 0.1, (0.30000000000000004,)).count(0.30000000000000004) == 1


def test_times_beyond_the_end_are_refused():
    with pytest.raises(InputError, match=r"-fsi_output_times: 1.5, 5 s .* -ts_max_time 1 s"):
        saved_times(1.0, 0.5, (0.3, 1.5, 5.0))


# runs


def final(run) -> list[np.ndarray]:
    """The unknowns in the last frame, where they are active."""
    names = {"fluid": ("rho", "u", "T"), "solid": ("u", "sigma", "T", "x")}
    last = [layer[name][-1] for layer in run.layers for name in names[layer.kind]]
    return [values[np.isfinite(values)] for values in last]


def difference(run, reference) -> float:
    """Largest difference of an unknown, relative to the largest departure from its mean."""
    pairs = zip(final(run), final(reference), strict=True)
    return max(np.abs(a - b).max() / np.abs(b - b.mean()).max() for a, b in pairs)


@pytest.mark.parametrize("method", METHODS, ids=lambda m: " ".join(m).strip())
def test_every_method_has_its_order(computed, method):
    """On a fixed grid against a far finer step; methods of high order come down to the order of
    the round-off floor.
    """
    coarse, fine = (computed("methods", fixed(method, dt)) for dt in STEPS)
    reference = computed("methods", "reference")
    errors = difference(coarse, reference), difference(fine, reference)
    order = METHODS[method]
    if order <= 4:
        assert np.log2(errors[0] / errors[1]) > order - 0.2
    else:
        assert errors[0] < 3e-6


@pytest.mark.parametrize("name", FUSED)
def test_the_fused_method_is_petscs_up_to_round_off(computed, name):
    """Hundreds of steps in which boundaries cross cells, with forcing and without."""
    fused, petsc = computed("fused", f"{name}_fused"), computed("fused", f"{name}_rk")
    for run in (fused, petsc):
        assert run.summary["rhs_evaluations"] == 4 * run.summary["steps"]
    assert np.array_equal(fused.time, petsc.time)
    for one, other in zip(fused.layers, petsc.layers, strict=True):
        for field in one.fields:
            assert np.array_equal(np.isfinite(one[field]), np.isfinite(other[field]))
            scale = np.nanmax(np.abs(other[field]))
            assert np.nanmax(np.abs(one[field] - other[field])) <= 1e-11 * scale, (one.name, field)


def test_saved_times_are_exact(computed):
    """Equal as floats, in frames and series; no step is shorter than half of the rule's."""
    run = computed("times", "listed")
    listed = [0.0, 0.0011, 0.00234567, 0.005, 0.0071, 0.0071003, 0.01]
    assert run.time.tolist() == listed
    assert set(listed[1:]) <= set(run.series["t"].tolist())
    dt, t = run.series["dt"], run.series["t"]
    ordinary = ~np.isin(t, [0.0071003])
    assert dt[ordinary].min() >= 0.499 * np.median(dt)
    assert dt.max() <= np.median(dt) * 1.01
