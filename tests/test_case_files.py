"""Faults of case files: status 2 and one message that names file and line, or layer and field, and
what was expected.
"""

from __future__ import annotations

import pytest
from helpers import message, solve

import fsipetsc

pytest.importorskip("petsc4py")

RIGHT = """
import sys
import numpy as np; from numba import njit
from fsipetsc.boundaries import Dirichlet, Open, Wall, absorbing, clamped, free
from fsipetsc.options import Option
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.problem import FluidLayer, Problem, SolidLayer
OPTIONS = (Option("own_speed", float, 0.0, "m/s", "a speed"),)
DEFAULTS = {"fsi_h": 0.1, "fsi_order": 2, "ts_max_time": 1.0, "ts_max_steps": 4, "ts_dt": 1e-5}
def build(opt):
    gas = Fluid(mu=0.1, kappa=0.1, gamma=1.4, R=287.0)
    rod = Solid(K=1e6, kappa_e=0.5, m0=10.0, alpha=500.0)
    def g_initial(X):
        return [np.full(X.shape, 1.2), 0 * X, np.full(X.shape, 300.0)]
    def s_initial(X):
        return [0 * X, np.full(X.shape, -103320.0), np.full(X.shape, 300.0), X]
    def g_exact(X, t):
        return g_initial(X)
    def s_exact(X, t):
        return s_initial(X)
    def g_forcing(X, t):
        return [0 * X, 0.0, np.zeros(X.shape)]
    def s_forcing(X, t):
        return 0 * X, 0 * X, 0 * X, 0 * X
    def values(t):
        return 1.2, 0.0, 300.0
    def jumps(k, t):
        return 0.0, 0.0, 0.0, 0.0
    return Problem(
        layers=(
            FluidLayer("air", gas, (0.0, 1.0), g_initial, g_forcing, g_exact),
            SolidLayer("rod", rod, (1.0, 2.0), s_initial, s_forcing, s_exact),
        ),
        left=Dirichlet(0.0, values, 2),
        right=free(-103320.0),
        jumps=jumps,
        notes=("a note",),
    )
"""

_GAS = "mu=0.1, kappa=0.1, gamma=1.4, R=287.0"
_G = "return [np.full(X.shape, 1.2), 0 * X, np.full(X.shape, 300.0)]"
_S = "return [0 * X, np.full(X.shape, -103320.0), np.full(X.shape, 300.0), X]"
_F = "return [0 * X, 0.0, np.zeros(X.shape)]"
_E = "return g_initial(X)"
_INITIAL = ("initial of layer 'air'", "expected")
_LATER = "if t > 1.5e-5: "

#: name -> (text of RIGHT, what stands there instead, words of the message); LINE: the line of the
#: text must be named
FAULTS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    # build
    "no return": ("return Problem(", "Problem(", ("LINE def build", "nothing", "Problem")),
    "unknown key": (
        "gas = Fluid",
        "opt['own_sped']; gas = Fluid",
        ("LINE gas =", "opt['own_sped']", "did you mean -own_speed?"),
    ),
    # materials
    "gamma of one": (_GAS, _GAS.replace("1.4", "1"), ("LINE gas =", "gamma is 1", "above 1")),
    # the problem
    "wall beyond the interface": (
        "Dirichlet(0.0, values, 2)",
        "Wall(1.5)",
        ("LINE FluidLayer(", "'air'", "x = 1.5"),
    ),
    # what the functions return
    "nan": (
        _G,
        "return 1.2 + 0 * X, np.where(X > 0.44, np.nan, 0), 300 + 0 * X",
        (*_INITIAL, "u = nan at X = 0.5"),
    ),
    "x falls": (_S, _S.replace(", X]", ", 3 - X]"), ("initial of layer 'rod'", "x does not rise")),
    "initial raises": (_G, "return 1 / 0", ("LINE return 1 / 0", "ZeroDivisionError")),
    # compiled functions
    "compiled: no such attribute": (
        "def g_initial(X):",
        "@njit\n    def g_initial(X):\n        return X.missing\n    def unused(X):",
        (
            "LINE return X.missing",
            *_INITIAL[:1],
            "numba cannot compile it: Unknown attribute 'missing'",
        ),
    ),
    # what happens later
    "forcing fails later": (
        _F,
        f"{_LATER}return 1 / 0\n        {_F}",
        ("LINE if t > ", "at t = ", "ZeroDivisionError", "faulty.h5"),
    ),
    "exact fails at the end": (
        _E,
        f"{_LATER}return 7\n        {_E}",
        ("LINE def g_exact", "exact of block 'air'", "faulty.h5"),
    ),
}
#: faults of FAULTS that show only when the run is under way: its result is kept
LATER = [name for name in FAULTS if "faulty.h5" in FAULTS[name][2]]


def faulty(name: str) -> tuple[str, list[str]]:
    """(text of the case file, words of its message) of a fault."""
    old, new, words = FAULTS[name]
    assert RIGHT.count(old) == 1, f"{name}: {old!r} stands {RIGHT.count(old)} times in the case"
    text = RIGHT.replace(old, new)
    lines = text.splitlines()

    def place(word: str) -> str:
        (number,) = [i for i, line in enumerate(lines, 1) if word.removeprefix("LINE ") in line]
        return f", line {number}: "

    return text, [place(word) if word.startswith("LINE ") else word for word in words]


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """What is said about each of the case files; each ends with 2."""
    texts = {}
    for name in FAULTS:
        folder = tmp_path_factory.mktemp("case")
        (folder / "faulty.py").write_text(faulty(name)[0])
        texts[name] = folder, message(solve("faulty.py", "-fsi_quiet", cwd=folder), 2)
    return texts


def test_the_case_that_the_faulty_ones_are_made_of_is_right(tmp_path):
    (tmp_path / "right.py").write_text(RIGHT)
    done = solve("right.py", "-fsi_quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_one_message_that_says_where_and_what(name, said):
    """A result is left only by what was computed."""
    folder, text = said[name]
    for word in faulty(name)[1]:
        assert word in text
    assert "unexpected" not in text
    assert (folder / "faulty.h5").exists() == (name in LATER)
    if name in LATER:
        with fsipetsc.open_run(folder / "faulty.h5") as result:
            assert result.summary["status"] == "failed"
            assert len(result.series["t"]) == result.summary["steps"] >= 1
            assert result.nframes >= 1
