"""Notes on initial data that may not be meant, and on what the grid does not resolve at the end."""

import pytest
from helpers import solve, well

#: the piston or the blast, with one thing changed
CASE = """
from dataclasses import replace
import numpy as np
from fsipetsc import Option, Wall
from fsipetsc.cases import BASE as base

OPTIONS = (*base.OPTIONS, Option("changed", str, "", "", "what is changed"))
DEFAULTS = base.DEFAULTS

def build(opt):
    problem = base.build(opt)
    if opt["changed"] == "along":  # a gas that flows along the lower wall
        flow = lambda X, Y: (1.0 + 0.0 * X, 0.5 + 0.0 * X, 0.0 * X, 1.0 + 0.0 * X)
        gas, plate = problem.blocks
        return replace(problem, blocks=(replace(gas, initial=flow), plate))
    T, p = base.T0, base.P0
    below, layer, above = problem.layers
    if opt["changed"] == "wall":
        return replace(problem, left=Wall(lambda t: 0.1 + 0.0 * t, velocity=lambda t: 0.0 * t))
    if opt["changed"] == "fixed":
        return replace(problem, left=Wall(0.1))
    if opt["changed"] == "heated":
        return replace(problem, left=replace(problem.left, T=1.05 * T))
    if opt["changed"] == "hot":
        return replace(problem, right=Wall(2.2, T=1.05 * T))
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
    "wall": ["a wall of 'driven' is 0.1 m from the end of its block at t = 0: the grid of the gas"],
    "fixed": ["layer 'driven' ends at X = 0, its Wall is at x = 0.1: the gas is stretched to it"],
    "sign": [f"at t = 0 'driven' {SIGN}", f"at t = 0 'behind' {SIGN}"],
    "hot": ["at the end the temperature in 'behind' changes by … at X = 2.2 m: the layer there"],
    "heated": ["at the end the temperature in 'driven' changes by … at X = 0 m: the layer there"],
    "jump": ["at the end the pressure in 'driven' changes by … one node to the next, at X = 0."],
    "along": ["at the end the velocity along a wall in 'gas' changes by … the layer there is not"],
}


@pytest.mark.parametrize("changed", NOTES)
def test_what_may_not_be_meant_is_said(changed, tmp_path):
    notes, blast = NOTES[changed], changed == "along"
    (tmp_path / "changed.py").write_text(CASE.replace("BASE", "blast" if blast else "piston"))
    more = ("-fsi_h", 0.125, "-fsi_order", 2) if blast else ()
    line = "changed.py", "-changed", changed, "-ts_max_steps", 1, *more
    done = well(solve(*line, cwd=tmp_path, ranks=2))
    found = [line for line in done.stdout.splitlines() if line.startswith("note: ")]
    found = found[-1:] if blast else found  # others are of the gas that meets the side
    assert len(found) == len(notes), found
    for line, note in zip(found, notes, strict=True):
        assert all(word in line for word in note.split("…")), line
