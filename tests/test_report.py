"""What a run says of itself: how it ended, and of steps that are too long."""

from __future__ import annotations

import pytest
from helpers import solve

import fsipetsc

pytest.importorskip("petsc4py")


@pytest.fixture(scope="module")
def where(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


def box(where, *words):
    return solve("box", "-fsi_h", 0.1, "-fsi_order", 2, "-fsi_output", "r.h5", *words, cwd=where)


def test_an_end_by_the_number_of_steps_is_not_said_to_be_the_end(where):
    done = box(where, "-ts_max_steps", 1)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(where / "r.h5") as result:
        t, summary, complete = result.series["t"][-1], result.summary, result.complete
    words = f"ended by -ts_max_steps at t = {t:g}, before -ts_max_time 2"
    assert f"\n{words}: 1 step in " in done.stdout and "done at" not in done.stdout
    assert (summary["status"], summary["message"], complete) == ("done", words, True), "as the user wished"
    assert words in solve("info", "r.h5", cwd=where).stdout


ENDS = {("-ts_max_time", 0): "0 steps", ("-ts_max_time", 1e-6, "-ts_max_steps", 1): "1 step"}


@pytest.mark.parametrize(("words", "steps"), ENDS.items())
def test_the_end_is_the_end(words, steps, where):
    done = box(where, *words)
    assert f"done at t = {words[1]:g}: {steps} in " in done.stdout
    with fsipetsc.open_run(where / "r.h5") as result:
        assert result.summary["message"] == ""


def test_steps_far_beyond_their_bound_are_noted(where):
    """Those that were asked for: with -ts_dt or with -fsi_cfl; not the default ones."""
    noted = {}
    for words in ((), ("-ts_dt", 1e-4), ("-ts_dt", 1.0), ("-fsi_cfl", 4)):
        done = box(where, "-ts_max_steps", 1, *words)
        noted[words] = [line for line in done.stdout.splitlines() if line.startswith("note: ")]
    with fsipetsc.open_run(where / "r.h5") as result:
        bound = result.series["dt"][0]
    assert noted.pop(("-fsi_cfl", 4))[0].startswith("note: -fsi_cfl 4 is 4 times the bound on the step at t = 0, ")
    assert noted.pop(("-ts_dt", 1.0))[0].startswith("note: -ts_dt 1 is ")
    assert list(noted.values()) == [[], []] and bound > 0


def test_a_run_that_fails_by_its_steps_says_so(where):
    done = box(where, "-ts_dt", 4, "-fsi_output_dt", 8)
    assert done.returncode == 3
    assert "; -ts_dt 4 is " in done.stderr and " times the bound on the step at t = 0" in done.stderr


BAR = """
import numpy as np
from fsipetsc.boundaries import clamped
from fsipetsc.materials.line_solid import Solid
from fsipetsc.problem import Problem, SolidLayer

OPTIONS, DEFAULTS = (), {"fsi_h": 0.1, "fsi_order": 2, "ts_max_time": 0.1}


def build(opt):
    def exact(X, t):  # a wave that stands, so weak that it is linear
        s, c = np.sin(np.pi * X), np.cos(np.pi * X)
        u, sigma = 1e-6 * s * np.cos(np.pi * t), 1e-6 * c * np.sin(np.pi * t)
        return u, sigma, 300.0, X + 1e-6 / np.pi * s * np.sin(np.pi * t)

    bar = Solid(K=1.0, kappa_e=0.0, m0=1.0, alpha=1e9)
    layer = SolidLayer("bar", bar, (0.0, 1.0), lambda X: exact(X, 0.0), exact=exact)
    return Problem((layer,), left=clamped(), right=clamped())
"""


def test_nothing_is_said_of_what_a_problem_has_not(where):
    """One solid: no interfaces, no errors in a gas, no orders of it."""
    (where / "bar.py").write_text(BAR)
    done = solve("bar.py", cwd=where)
    assert (done.returncode, done.stderr) == (0, "")
    assert "\n11 points\n" in done.stdout and "interfaces" not in done.stdout and "fluid" not in done.stdout
    with fsipetsc.open_run(where / "bar.h5") as result:
        assert set(result.errors) == {"solid"} and 0 < result.errors["solid"]["combined"] < 1e-7
    done = solve("convergence", "bar.py", "-fsi_orders", 2, "-fsi_hs", "0.1,0.05", cwd=where)
    assert (done.returncode, done.stderr) == (0, "")
    assert "nan" not in done.stdout and "\nfluid" not in done.stdout
    order = float(done.stdout.split("\nsolid    all")[1].split("\n")[0].split()[-1])
    assert order == pytest.approx(2.05, abs=0.1)
