"""Faults of case files: status 2 and one message that names the place and what was expected."""

import pytest
from helpers import message, solve

import fsipetsc

RIGHT = """
import numpy as np
from fsipetsc import Dirichlet, Fluid, FluidLayer, Option, Problem, Solid, SolidLayer, Wall, free
OPTIONS = (Option("own_speed", float, 0.0, "m/s", "a speed"),)
DEFAULTS = {"fsi_h": 0.1, "fsi_order": 2, "ts_max_time": 1.0, "ts_max_steps": 4, "ts_dt": 1e-5}
def build(opt):
    gas = Fluid(mu=0.1, kappa=0.1, gamma=1.4, R=287.0)
    rod = Solid(K=1e6, kappa_e=0.5, m0=10.0, alpha=500.0)
    def g_initial(X):
        u = 0
        return [np.full(X.shape, 1.2), u + 0 * X, np.full(X.shape, 300.0)]
    def s_initial(X):
        return [0 * X, np.full(X.shape, -103320.0), np.full(X.shape, 300.0), X]
    def g_forcing(X, t):
        force = 0
        return [0 * X, force, np.zeros(X.shape)]
    def s_exact(X, t):
        sigma = -103320.0 + 0 * X
        return 0 * X, sigma, 300.0 + 0 * X, X
    g_exact = lambda X, t: g_initial(X)
    air = FluidLayer("air", gas, (0.0, 1.0), g_initial, g_forcing, g_exact)
    solid = SolidLayer("rod", rod, (1.0, 2.0), s_initial, exact=s_exact)
    left = Dirichlet(0.0, lambda t: (1.2, 0.0, 300.0), 2)
    return Problem((air, solid), left, free(-103320.0), jumps=lambda k, t: (0.0,) * 4)
"""

_INITIAL = "initial of block 'air'"
#: text of RIGHT, what stands there instead, words of the message; LINE: the line of the text must
#: be named; faulty.h5: it shows when the run is under way
FAULTS = {
    "syntax": ("def build(opt):", "def build(opt:", ("case file faulty.py", "line 6")),
    "no return": ("return Problem(", "Problem(", ("LINE def build", "nothing", "Problem")),
    "a material": ("1.4, R", "1, R", ("LINE gas =", "gamma is 1", "above 1")),
    "not a number": ("u = 0", "u = np.sqrt(0.4-X)", (_INITIAL, "expected", "u = nan at X = 0.5")),
    "stress at the end": (
        "sigma =",
        "sigma = np.nan * X if t > 1.5e-5 else",
        ("LINE def s_exact", "exact of block 'rod'", "sigma = nan", "faulty.h5"),
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_one_message_that_says_where_and_what(name, tmp_path):
    old, new, words = FAULTS[name]
    assert RIGHT.count(old) == 1, name
    text = RIGHT.replace(old, new)
    (tmp_path / "faulty.py").write_text(text)
    said = message(solve("faulty.py", "-fsi_quiet", cwd=tmp_path), 2)
    for word in words:
        if word.startswith("LINE "):
            before, _ = text.split(word.removeprefix("LINE "))
            word = f", line {before.count(chr(10)) + 1}: "
        assert word in said
    assert "unexpected" not in said
    assert (tmp_path / "faulty.h5").exists() == ("faulty.h5" in words)
    if "faulty.h5" in words:
        with fsipetsc.open_run(tmp_path / "faulty.h5") as result:
            assert result.summary["status"] == "failed" and result.nframes >= 1
            assert len(result.series["t"]) == result.summary["steps"] >= 1


# files that cannot be loaded
