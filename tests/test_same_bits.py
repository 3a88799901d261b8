"""Results are the same bit for bit on any number of ranks, whatever form the equations and whatever laws the materials have.

The runs of several files, all of them in one process for each rank: that is what they share, and starts are what costs.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers import compute

import fsipetsc

pytest.importorskip("petsc4py")

import test_dissipation_runs
import test_ranks

pytestmark = pytest.mark.mpi

SHARED = {
    f"{group} {name}": run
    for group, runs in {
        "coupling": test_ranks.EVERY,
        "dissipation": test_dissipation_runs.SHARED,
    }.items()
    for name, run in runs.items()
}


#: ranks -> the runs that are made on them: each on one rank and on two or three
ON = {1: list(SHARED), 2: list(SHARED)[::2], 3: list(SHARED)[1::2]}


@pytest.fixture(scope="module")
def results(more_kernels, tmp_path_factory):
    """(ranks, name) -> result."""
    found = {n: compute(n, tmp_path_factory.mktemp(f"shared{n}"), {name: SHARED[name] for name in ON[n]}) for n in ON}
    return {(n, name): fsipetsc.open_run(path) for n, files in found.items() for name, path in files.items()}


@pytest.mark.parametrize(("n", "name"), [(n, name) for n in (2, 3) for name in ON[n]])
def test_ranks_change_no_bit(results, n, name):
    one, more = results[1, name], results[n, name]
    assert more.summary["ranks"] == n
    if name.startswith("coupling "):
        test_ranks.assert_same(one, more)
    for a, b in zip(one.layers, more.layers, strict=True):
        assert all(np.array_equal(a[field], b[field], equal_nan=True) for field in a.fields)
    assert np.array_equal(one.series["t"], more.series["t"])
