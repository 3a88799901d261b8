"""Runs from Python, what differs between two results, and results as xarray Datasets."""

import pytest
from helpers import computed, mpirun, solve, well

from fsipetsc import compare, open_run

PROGRAM = """
import os, signal, sys
import numpy as np
import pytest
import fsipetsc
from fsipetsc import ComputationError, FileError, Fluid, FluidLayer, InputError, Problem, Wall

gas = Fluid(0.01, 0.02, 1.4, 1.0)
state = lambda X: (1 + 0 * X, 0 * X, 1 + 0.01 * np.cos(np.pi * X))
layer = FluidLayer("gas", gas, (0.0, 1.0), state)
problem = Problem((layer,), left=Wall(0.0), right=Wall(1.0), units="none")
wrong = FluidLayer("gas", gas, (0.0, 1.0), lambda X: 1 / 0)
def forcing(X, t):
    if t > 0:
        signal.raise_signal(signal.SIGTERM)
    return 0 * X, 0 * X, 0 * X
stopped = FluidLayer("gas", gas, (0.0, 1.0), state, forcing)
words = list(sys.argv)

first = fsipetsc.run("rod", h=0.1, max_steps=5, output="rod.h5")
assert first.case == "rod" and first.options["fsi_h"] == 0.1 and len(first.series["t"]) == 5
assert "OMPI_MCA_mpi_yield_when_idle" not in os.environ  # Open MPI knows if ranks have cores
times = [0.03, 0.0300003, 0.1]
own = fsipetsc.run(problem, h=0.05, max_time=0.1, output="own.h5", output_times=np.array(times))
assert list(own.time) == [0.0, *times] and set(times) <= {*own.series["t"]} and own.complete
for case, options, said in (
    (problem, {"h": 0.05, "max_tim": 1.0}, "did you mean"),
    (3, {}, "a Problem"),
    ("rod", {"check": True}, "the command line has -fsi_check"),
    (Problem((wrong,), Wall(0.0), Wall(1.0)), {"h": 0.05, "max_time": 1}, "ZeroDivisionError"),
):
    with pytest.raises(InputError, match=said):
        fsipetsc.run(case, **options)
with pytest.raises(ComputationError, match="t = "):
    fsipetsc.run("rod", h=0.1, cfl=100.0, output="bad.h5")
with pytest.raises(KeyboardInterrupt, match="stopped by SIGTERM at t = ") as caught:
    fsipetsc.run(Problem((stopped,), Wall(0.0), Wall(1.0)), h=0.05, max_time=1)
assert not isinstance(caught.value, Exception)  # what catches errors does not go on
saved = {"checkpoint": "half.ck.h5", "checkpoint_steps": 3}
half = fsipetsc.run("rod", h=0.1, max_steps=3, output="half.h5", **saved)
on = fsipetsc.run("rod", restart="half.ck.h5", max_steps=5)
assert on.path == half.path and len(half.series["t"]) == 3
with pytest.raises(FileError, match="has changed since it was opened; open it again"):
    half.layers[0]["T"]  # of another run
assert np.array_equal(on.series["t"], first.series["t"])
assert sys.argv == words
"""


def test_runs_from_python(tmp_path):
    """A case by name, a Problem, faults as exceptions; nothing is printed; two ranks."""
    done = mpirun(2, "-c", PROGRAM, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", ""), done.stderr


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    for name, T0 in (("a", 300.0), ("same", 300.0), ("other", 301.0)):
        computed(folder, f"{name}.h5", *"rod -fsi_h 0.1 -ts_max_steps 4 -rod_T0".split(), T0)
    return folder


def test_what_differs(results):
    found = compare(open_run(results / "a.h5"), results / "same.h5")
    assert found.equal and not found.options and len(found.differences) > 15
    done = solve("diff", results / "a.h5", results / "same.h5")
    assert done.stdout.endswith("are equal, bit for bit\n")
    found = compare(results / "a.h5", results / "other.h5")
    assert not found.equal and found.options == {"rod_T0": (300.0, 301.0)}
    largest = {one.name: one.largest for one in found.differences}
    assert largest["below: T"] == pytest.approx(1.0, rel=0.1)
    done = well(solve("diff", results / "a.h5", results / "other.h5"))
    for word in ("option -rod_T0: 300.0 and 301.0", "below: T", "ulp"):
        assert word in done.stdout


def test_two_grids_are_compared_at_common_nodes(tmp_path):
    """Places at t = 0 are those of the nodes; one axis of the blocks is periodic."""
    for k in (1, 2):
        computed(tmp_path, f"{k}.h5", "wave", "-fsi_h", 1 / 8 / k, "-ts_max_steps", 1)
    found = compare(tmp_path / "1.h5", tmp_path / "2.h5")
    assert any("72 common nodes" in note for note in found.notes), found.notes
    places = [one for one in found.differences if one.name.endswith((": x", ": y"))]
    assert places and all(one.largest < 1e-14 < one.scale for one in places)
