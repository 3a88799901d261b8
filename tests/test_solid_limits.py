"""Solids beyond their law: imaginary waves, what is said of them and of failures."""

from helpers import message, solve


def test_a_rod_that_is_crushed(tmp_path):
    """By a shock of ten times its modulus: it fails, not the gas, which has NaN afterwards."""
    line = "shock -shock_problem strong -shock_mach 7 -fsi_order 2 -fsi_h 0.1 -fsi_quiet"
    said = message(solve(*line.split(), cwd=tmp_path, ranks=2), 3, "error: J = -")
    assert " in layer 'rod' at x = 1.1" in said and "(X = 1), t = 0.02" in said
    assert "nan" not in said


CASE = """
import numpy as np
from fsipetsc.blocks.conditions import Clamped
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = ()
DEFAULTS = {"fsi_h": 0.1, "fsi_order": 2, "ts_max_time": 0.3, "fsi_output_dt": 0.05}


def build(opt):
    bar = ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, law="svk")
    pressed = Layer("bar", bar, (0.0, 2.0), lambda X: (-1.5 * np.tanh(4.0 * (X - 1.0)), 1.0, X))
    both = {"lower": Clamped(), "upper": Clamped()}
    return layers(pressed, along=(), h=opt["fsi_h"], order=opt["fsi_order"], units="none", **both)
"""


def test_one_note_says_that_waves_are_imaginary_and_the_failure_names_them(tmp_path):
    (tmp_path / "pressed.py").write_text(CASE)
    done = [solve("pressed.py", cwd=tmp_path, ranks=ranks) for ranks in (1, 2)]
    for one in done:
        notes = [line for line in one.stdout.splitlines() if line.startswith("note: ")]
        assert len(notes) == 1 and notes[0].startswith("note: waves have become imaginary in 'bar'")
        assert ", t = 0.1, where the stretch along them is 0.4" in notes[0]
    first, second = (message(one, 3, "error: J = -", "waves have become imaginary") for one in done)
    assert first.split("; what")[0] == second.split("; what")[0] and "fsi_cfl" not in first
