"""Notes on initial data that may not be meant, and on what the grid does not resolve at the end."""

from types import SimpleNamespace

import numpy as np
import pytest
from helpers import solve, well
from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.blockrun.notes import MOST, steepest, weak_hinges
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Outflow, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.cases import load_case
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.operators import OPERATORS
from fsipetsc.options import defaults

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


def test_a_hinge_that_does_not_hold():
    case = load_case("panel")
    for order, ends, count in ((8, "hinged", 1), (6, "hinged", 0), (8, "clamped", 0)):
        problem = case.build({**defaults(case), "panel_ends": ends, "fsi_order": order})
        state = SimpleNamespace(problem=problem, op=OPERATORS[order])
        assert len(weak_hinges(state)) == count


@pytest.mark.parametrize("side", [0, 1])
def test_gas_that_flows_in_through_an_outflow_is_told(side):
    """Nothing is said where it flows out or rests, nor where the state is no number."""
    for speed, told in ((0.5, 0), (0.0, 0), (-0.5, 1), (float("nan"), 0)):
        u = speed * (2 * side - 1)
        gas = Fluid(0.0, 0.0, 1.4, 1.0)
        block = Block("gas", gas, rectangle(0.0, 1.0), (10,), lambda X: (1.0, 0.0 * X, 1.0))
        faces = {("gas", 0, side): Outflow(1.0), ("gas", 0, 1 - side): Slip()}
        with BlockState(MPI.COMM_SELF, BlockProblem((block,), faces), 2) as state:
            state.check_data()
            state.y.owned(0)[:, 2] = u * state.y.owned(0)[:, 1]
            state.scheme.fill_halos(state.y)
            said = state.notes("failed")
        assert len(said) == told
        for words in said:
            assert f"flows in through the Outflow of 'gas' at X = {side} m" in words


def test_a_burst_in_water_needs_no_capturing():
    """The note at the end looks at p + p_inf. A burst of 1e6 Pa is nothing there, one of 2e8 is."""
    patch, water = SimpleNamespace(ghosted=(3, 1, 1)), stiffened_gas(4.4, 1000.0, 6e8)
    part = SimpleNamespace(
        owned=np.arange(3), block=SimpleNamespace(dimension=1), part=SimpleNamespace(patch=patch)
    )
    for burst, noted in ((1e6, False), (2e8, True)):
        p = np.array([1e5, 1e5, burst])
        K = water.bulk_modulus(1000.0, water.temperature_of(1000.0, p))
        assert (steepest(part, p, K).max() > MOST[0]) == noted
