"""Runs with dissipation, at shocks and everywhere, and with two-point fluxes: what they keep."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, compute, computed

import fsipetsc
from fsipetsc.operators import OPERATORS

pytest.importorskip("petsc4py")
pytestmark = pytest.mark.mpi

BOTH = "-fsi_dissipation 1 -fsi_shock 1"
_SHARED = f"{BOTH} -fsi_partition balanced -ts_max_time 0.1 -fsi_output_dt 0.1"
#: what test_ranks runs on several ranks, too
SHARED = {
    "sod 4": ("shock", f"{_SHARED} -fsi_order 4 -fsi_h 0.02"),
    "strong 4": ("shock", f"{_SHARED} -shock_problem strong -fsi_order 4 -fsi_h 0.02"),
}
BOX = "box", f"{BOTH} -fsi_h 0.0125 -ts_max_time 0.5 -fsi_output_dt 0.01"
#: order -> least order of the errors of the manufactured solution with dissipation of half the
#: order, in fluid and solid, between the grids below: 2 q - 1 inside, q at the ends
LEAST = {2: (0.9, 0.65), 4: (2.2, 2.6), 6: (4.0, 3.9), 8: (4.9, 4.4)}
SPACINGS = (0.025, 0.0125)
#: numba compiles dissipation anew for each order
ORDERS = [q if q == 4 else pytest.param(q, marks=pytest.mark.long) for q in LEAST]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """name -> result."""
    files = compute(1, tmp_path_factory.mktemp("dissipation"), {**SHARED, "box": BOX})
    return {name: fsipetsc.open_run(path) for name, path in files.items()}


@pytest.mark.parametrize("order", ORDERS)
def test_orders(order, tmp_path):
    """Where the strength at shocks is as good as none, what is left is the other term."""
    words = f"-box_dimension 1 -fsi_dissipation 1 -fsi_shock 1e-300 -fsi_order {order}"
    runs = {f"{h}": ("box_mms", f"{words} -fsi_h {h}") for h in SPACINGS}
    files = compute(1, tmp_path, runs)
    coarse, fine = (fsipetsc.open_run(files[f"{h}"]).errors for h in SPACINGS)
    for kind, least in zip(("fluid", "solid"), LEAST[order], strict=True):
        assert np.log2(coarse[kind]["combined"] / fine[kind]["combined"]) > least


def entropy_of_solid(layer, time) -> np.ndarray:
    """(frames,) of the box's: m0 alpha ln T, less what its stress supplies, sigma u_X / T."""
    n, h, (m0, alpha) = len(layer.X), layer.X[1] - layer.X[0], (2.0, 1.0)
    op, weights = OPERATORS[4], np.full(n, h)
    weights[: op.rows], weights[n - op.rows :] = h * np.array(op.norm), h * np.array(op.norm[::-1])
    T, sigma, slopes = layer["T"][:], layer["sigma"][:], layer["u"][:] @ op.matrix(n).T / h
    heating = (sigma * slopes / T) @ weights
    supplied = np.r_[0.0, np.cumsum(0.5 * (heating[1:] + heating[:-1]) * np.diff(time))]
    return m0 * alpha * np.log(T) @ weights - supplied


def test_mass_and_energy_stay_and_entropy_grows(runs):
    """By 1.7e-5 or more from frame to frame in the box: of gas and solid, as the gas, which the
    series has, gives heat to the solid and loses 2.7e-5 in all.
    """
    for run in runs.values():
        assert np.abs(run.series["mass"] / run.series["mass"][0] - 1).max() < 1e-13
    run = runs["box"]
    series = run.series
    assert np.abs(series["energy"] / series["energy"][0] - 1).max() < 1e-12
    of_gas = np.interp(run.time[1:], series["t"], series["entropy"])
    growth = np.diff(of_gas + entropy_of_solid(run.layers[1], run.time)[1:])
    assert growth.min() > 1e-5


@pytest.mark.parametrize(
    ("kind", "options"),
    [("g", "-fsi_convection entropy"), pytest.param("s", BOTH, marks=pytest.mark.long)],
)
def test_a_layer_alone_runs_and_keeps_mass_and_energy(kind, options, tmp_path):
    words = f"{options} -layers {kind} -fsi_h 0.025 -ts_max_time 0.3".split()
    result = computed(tmp_path, "alone.h5", REPOSITORY / "tests" / "layers.py", *words)
    assert result.complete
    for name in ("mass", "energy"):
        values = result.series.get(name)
        if values is not None and values.size:
            assert np.abs(values / values[0] - 1).max() < 1e-8, name
