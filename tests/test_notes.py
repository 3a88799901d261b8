"""Notes on initial data that may not be meant, and on what the grid does not resolve at the end."""

from __future__ import annotations

import pytest
from helpers import solve

pytest.importorskip("petsc4py")

from fsipetsc.blockrun.notes import weak_hinges
from fsipetsc.cases import load_case
from fsipetsc.options import defaults

pytestmark = pytest.mark.mpi

#: the piston, with one thing changed
CASE = """
from dataclasses import replace

import numpy as np

from fsipetsc import Option, Wall
from fsipetsc.cases import piston

NAME, DEFAULTS = "changed", piston.DEFAULTS
OPTIONS = (*piston.OPTIONS, Option("changed", str, "", "", "what is changed"))


def build(opt):
    problem = piston.build(opt)
    below, layer, above = problem.layers
    if opt["changed"] == "wall":
        return replace(problem, left=Wall(lambda t: 0.1 + 0.0 * t, velocity=lambda t: 0.0 * t))
    if opt["changed"] == "hot":
        return replace(problem, right=Wall(2.2, T=1.05 * piston.T0))
    if opt["changed"] == "jump":
        return replace(problem, layers=(replace(below, initial=jump), layer, above))
    if opt["changed"] == "sign":
        return replace(problem, layers=(below, replace(layer, initial=pulled), above))
    return problem


def jump(X):
    p = np.where(X < 0.5, 2.0, 1.0) * piston.P0
    return p / 287.0 / piston.T0, 0.0 * X, piston.T0 + 0.0 * X


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


HOT = ["note: at the end the temperature in 'behind' changes by ", "at X = 2.2 m: the layer there"]
JUMP = [
    "note: at the end the pressure in 'driven' changes by ",
    "from one node to the next, at X = 0.",
]
#: a gas that flows along the lower wall of the blast from the begin
PLANE = """
from dataclasses import replace

from fsipetsc.cases import blast

NAME, DEFAULTS, OPTIONS = "along", {**blast.DEFAULTS, "fsi_h": 0.125}, blast.OPTIONS


def build(opt):
    problem = blast.build(opt)
    gas, plate = problem.blocks
    flow = lambda X, Y: (1.0 + 0.0 * X, 0.5 + 0.0 * X, 0.0 * X, 1.0 + 0.0 * X)
    return replace(problem, blocks=(replace(gas, initial=flow), plate))
"""


def notes_of(folder, text, *words):
    (folder / "changed.py").write_text(text)
    done = solve("changed.py", *words, "-ts_max_steps", 1, cwd=folder, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    return [line for line in done.stdout.splitlines() if line.startswith("note: ")]


@pytest.mark.parametrize(
    ("changed", "notes"),
    [("nothing", []), ("wall", WALL), ("sign", SIGN), ("hot", [HOT]), ("jump", [JUMP])],
)
def test_what_may_not_be_meant_is_said(changed, notes, tmp_path):
    found = notes_of(tmp_path, CASE, "-changed", changed)
    assert len(found) == len(notes), found
    for line, words in zip(found, notes, strict=True):
        assert line == words or all(word in line for word in words)


def test_a_layer_at_a_wall_that_one_cell_holds(tmp_path):
    note = notes_of(tmp_path, PLANE)[-1]  # others are of the gas that meets the side
    assert "the velocity along a wall in 'gas' changes by" in note
    assert note.endswith("the layer there is not resolved")


@pytest.mark.parametrize(
    ("order", "ends", "count"), [(8, "hinged", 1), (6, "hinged", 0), (8, "clamped", 0)]
)
def test_a_hinge_that_does_not_hold(order, ends, count):
    case = load_case("panel")
    problem = case.build({**defaults(case), "panel_ends": ends, "fsi_order": order})
    assert len(weak_hinges(problem, order)) == count
