"""Notes on initial data that may not be meant, and on what the grid does not resolve at the end."""

import pytest
from helpers import solve, well

#: the piston with one thing changed
CASE = """
from dataclasses import replace
import numpy as np
from fsipetsc import Option
from fsipetsc.cases import piston

OPTIONS = (*piston.OPTIONS, Option("changed", str, "", "", "what is changed"))
DEFAULTS = piston.DEFAULTS

def build(opt):
    problem, T, p = piston.build(opt), piston.T0, piston.P0
    below, layer, above = problem.layers
    if opt["changed"] == "heated":
        return replace(problem, left=replace(problem.left, T=1.05 * T))
    if opt["changed"] == "jump":
        jump = lambda X: (np.where(X < 0.5, 2.0, 1.0) * p / 287.0 / T, 0.0 * X, T + 0.0 * X)
        below = replace(below, initial=jump)
    if opt["changed"] == "sign":
        layer = replace(layer, initial=lambda X: (0.0 * X, 0.0 * X + p, 0.0 * X + T, X))
    return replace(problem, layers=(below, layer, above))
"""
SIGN = "has a pressure of 1e+05 Pa where it meets 'layer', which pushes with -1e+05 Pa "
#: what is changed -> what the notes say, with … for what stands between
NOTES = {
    "nothing": [],
    "sign": [f"at t = 0 'driven' {SIGN}", f"at t = 0 'behind' {SIGN}"],
    "heated": ["at the end the temperature in 'driven' changes by … at X = 0 m: the layer there"],
    "jump": ["at the end the pressure in 'driven' changes by … one node to the next, at X = 0."],
}


@pytest.mark.parametrize("changed", NOTES)
def test_what_may_not_be_meant_is_said(changed, tmp_path):
    (tmp_path / "changed.py").write_text(CASE)
    line = "changed.py", "-changed", changed, "-ts_max_steps", 1
    done = well(solve(*line, cwd=tmp_path, ranks=2))
    found = [line for line in done.stdout.splitlines() if line.startswith("note: ")]
    assert len(found) == len(NOTES[changed]), found
    for line, note in zip(found, NOTES[changed], strict=True):
        assert all(word in line for word in note.split("…")), line
