"""Time stepping: saved times, PETSc's methods with their orders, and the fused one."""

import numpy as np
import pytest
from helpers import REPOSITORY, compute, computed


def test_steps_hit_saved_times_without_a_tiny_one(tmp_path):
    words = "box -fsi_h 0.1 -fsi_order 2 -fsi_output_times 0.025,0.040000000001 -ts_max_time 0.05"
    for more in ((), ("-ts_type", "rk")):
        run = computed(tmp_path, "box.h5", *words.split(), "-ts_dt", 0.01, *more)
        steps = [0.01, 0.0075, 0.0075, 0.0075, 0.0075, 0.01]
        assert run.series["dt"] == pytest.approx(steps, rel=1e-9)
        assert list(run.time) == [0.0, 0.025, 0.040000000001, 0.05]


def difference(run, reference) -> float:
    """The largest in the last frame, of fields that vary, over the departure from their mean."""
    layers = zip(run.layers, reference.layers, strict=True)
    pairs = [(a[name][-1], b[name][-1]) for a, b in layers for name in a.fields]
    varying = [(a, b) for a, b in pairs if np.nanmax(b) > np.nanmin(b)]
    assert all(np.array_equal(np.isfinite(a), np.isfinite(b)) for a, b in pairs)
    return max(np.nanmax(np.abs(a - b)) / np.nanmax(np.abs(b - np.nanmean(b))) for a, b in varying)


PAPER = "-fsi_coupling projection"
#: -ts_type and -ts_rk_type -> order
METHODS = {"euler": 1, "ssp": 2, "rk -ts_rk_type 3bs": 3, "rk -ts_rk_type 4": 4}
METHODS |= {"rk -ts_rk_type 5dp": 5}


def test_every_method_has_its_order(tmp_path):
    """On a fixed grid against a far finer step; high orders come down to the round-off floor."""
    case = f"{PAPER} -fsi_h 0.1 -ts_max_time 0.004 -fsi_output_dt 1 -ts_type"
    runs = {"reference": ("rod", f"{case} rk -ts_rk_type 5dp -ts_dt 6.25e-6")}
    for method, order in METHODS.items():
        for part in (1, 2):
            dt = 1e-4 / part / (8 if order == 1 else 1)
            runs[f"{order} {part}"] = "rod", f"{case} {method} -ts_dt {dt}"
    found = compute(1, tmp_path, runs)
    for order in METHODS.values():
        both = (found[f"{order} {part}"] for part in (1, 2))
        coarse, fine = (difference(run, found["reference"]) for run in both)
        assert np.log2(coarse / fine) > order - 0.2 if order <= 4 else coarse < 3e-6, order


SHORT = "-ts_max_steps 12"
#: the paper's method, where boundaries cross cells, with forcing and without; blocks with faces of
#: all kinds, periodic, around an axis and a centre, turned, with forces and dissipation
CASES = {
    # at an open end beside a viscous gas at rest round-off decides what the gradients see of u
    "rod": f"{PAPER} -fluid_mu 0 -fsi_h 0.05 -ts_max_time 0.05 -fsi_output_dt 0.05",
    "mms": "-fsi_h 0.05 -fsi_order 6 -ts_max_time 0.2 -fsi_output_dt 0.1",
    f"{REPOSITORY}/runs/piston.py": "-fsi_order 2 -ts_max_time 0.02 -fsi_output_dt 0.01",
    "box": "-fsi_h 0.05 -ts_max_time 0.1",
    "blast": f"-fsi_h 0.125 {SHORT} -fsi_dissipation 1 -fsi_shock 1",
    "box_mms": f"-box_dimension 3 -fsi_h 0.125 {SHORT}",
    "disk": f"-fsi_h 0.1 {SHORT}",
    "step": f"-fsi_h 0.04 {SHORT}",
    "nozzle": f"-fsi_h 0.1 {SHORT}",
    "ring": f"-fsi_h 0.1 {SHORT}",
    "shell": f"-shell_kappa 2 -fsi_h 0.05 {SHORT}",
    f"{REPOSITORY}/runs/gravity.py": f"-fsi_h 500 -gravity_wave 10 {SHORT}",
    f"{REPOSITORY}/tests/timed.py": "-timed_kind ends -ts_max_time 0.05",
}


@pytest.mark.parametrize("case", CASES)
def test_the_fused_method_is_petscs_up_to_round_off(case, tmp_path):
    """The one adds up stages in its sweeps, the other makes the rates of all nodes."""
    words = case, *CASES[case].split(), "-ts_type"
    fused, petsc = (computed(tmp_path, f"{kind}.h5", *words, kind) for kind in ("fused", "rk"))
    for run in (fused, petsc):
        assert run.summary["rhs_evaluations"] == 4 * run.summary["steps"]
    assert fused.time == pytest.approx(petsc.time, rel=1e-13)
    fastest = max(np.nanmax(np.abs(layer["u"])) for layer in petsc.layers)
    for one, other in zip(fused.layers, petsc.layers, strict=True):
        for field in one.fields:
            assert np.array_equal(np.isfinite(one[field]), np.isfinite(other[field]))
            scale = fastest if field in "uv" else np.nanmax(np.abs(other[field]))
            assert np.nanmax(np.abs(one[field] - other[field])) <= 1e-11 * scale, (one.name, field)
