"""Notes on initial data that may not be meant: a wall away from its block, a pressure that jumps at
an interface.
"""

from __future__ import annotations

import pytest
from helpers import solve

pytest.importorskip("petsc4py")

pytestmark = pytest.mark.mpi

#: the piston, with one thing changed
CASE = """
from dataclasses import replace

from fsipetsc import Option, Wall
from fsipetsc.cases import piston

NAME, DEFAULTS = "changed", piston.DEFAULTS
OPTIONS = (*piston.OPTIONS, Option("changed", str, "", "", "what is changed"))


def build(opt):
    problem = piston.build(opt)
    below, layer, above = problem.layers
    if opt["changed"] == "wall":
        return replace(problem, left=Wall(lambda t: 0.1 + 0.0 * t, velocity=lambda t: 0.0 * t))
    if opt["changed"] == "sign":
        return replace(problem, layers=(below, replace(layer, initial=pulled), above))
    return problem


def pulled(X):
    return 0.0 * X, 0.0 * X + piston.P0, 0.0 * X + piston.T0, X
"""
WALL = [
    "note: a wall of 'driven' is 0.1 m from the end of its block at t = 0: "
    "the grid of the gas is stretched to it"
]
SIGN = [
    f"note: at t = 0 '{gas}' has a pressure of 1e+05 Pa where it meets 'layer', "
    "which pushes with -1e+05 Pa (means of the interface): waves start there"
    for gas in ("driven", "behind")
]


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize(("changed", "notes"), [("nothing", []), ("wall", WALL), ("sign", SIGN)])
def test_what_may_not_be_meant_is_said(changed, notes, ranks, tmp_path):
    (tmp_path / "changed.py").write_text(CASE)
    words = "changed.py", "-changed", changed, "-fsi_coupling", "conservative", "-ts_max_steps", 1
    done = solve(*words, cwd=tmp_path, ranks=ranks)
    assert (done.returncode, done.stderr) == (0, "")
    assert [line for line in done.stdout.splitlines() if line.startswith("note: ")] == notes
