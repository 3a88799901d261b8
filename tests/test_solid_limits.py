"""Solids beyond their law: imaginary waves, what is said of them and of failures."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import message, solve

from fsipetsc.blockrun.solid_limits import imaginary
from fsipetsc.materials.solid import ElasticSolid

MU, LAMBDA = 1.0, 2.0


def found_in(F, law="svk", T=1.0, **more):
    """The node that is told of a solid with these F, (n, d, d), or None."""
    F = np.asarray(F, float)
    n, d = F.shape[:2]
    rows, flat = np.arange(n), F.reshape(n, d * d).T
    part = SimpleNamespace(
        block=SimpleNamespace(dimension=d),
        equations=ElasticSolid(
            MU, more.pop("lambda_e", LAMBDA), 0.0, 1.0, 1.0, 0.3, law, **more
        ).equations(d),
        part=SimpleNamespace(k=0, numbers=rows),
        owned=rows,
        X=np.zeros((d, n)),
        F=flat,
        stressed=lambda q, some: (np.full(len(some), T),),
    )
    return next(imaginary(part, None), None)


def stretched(stretch, d=1):
    return [np.diag([stretch, *[1.0] * (d - 1)])]


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_st_venant_kirchhoff_ends_at_one_over_the_root_of_three(heat):
    """m0 c^2 = K (3 F^2 - 1)/2."""
    good, bad = (stretched(c / np.sqrt(3.0)) for c in (1.0001, 0.9999))
    assert found_in(good, heat=heat) is None
    found, K = found_in(bad, heat=heat), 2.0 * MU + LAMBDA
    assert found.values[0] == pytest.approx(0.9999 / np.sqrt(3.0))
    assert found.order == pytest.approx(K * (0.9999**2 - 1.0) / 2.0, rel=1e-3)


@pytest.mark.parametrize("d", [2, 3])
def test_waves_in_any_direction_are_looked_at(d):
    """Random strains of St. Venant-Kirchhoff, by the tangent of the formula."""
    rng, one, both = np.random.default_rng(3), np.eye(d), [0, 0]
    N = rng.standard_normal((4000, d))
    N /= np.linalg.norm(N, axis=1)[:, None]
    for size in np.linspace(0.1, 0.5, 60):
        F = one + size * rng.uniform(-1.0, 1.0, (d, d))
        E = 0.5 * (F.T @ F - one)
        S = LAMBDA * np.trace(E) * one + 2.0 * MU * E
        FN, B = N @ F.T, F @ F.T
        along = np.einsum("ma,ab,mb->m", N, S, N)
        A = along[:, None, None] * one + (LAMBDA + MU) * FN[:, :, None] * FN[:, None, :] + MU * B
        least = np.linalg.eigvalsh(A)[:, 0].min()
        if np.linalg.det(F) > 0.0 and abs(least) > 0.03:
            both[int(least < 0.0)] += 1
            assert (found_in([F]) is not None) == (least < 0.0), (F, least)
            assert (found_in([np.linalg.qr(N[:d])[0] @ F]) is None) == (least > 0.0), "turned"
    assert min(both) > 5


def test_a_rod_that_is_crushed(tmp_path):
    """By a shock of ten times its modulus: it fails, not the gas, which has NaN afterwards."""
    line = "shock -shock_problem strong -shock_mach 7 -fsi_order 2 -fsi_h 0.1 -fsi_quiet"
    said = message(solve(*line.split(), cwd=tmp_path, ranks=2), 3, "error: J = -")
    assert " in layer 'rod' at x = 1.1" in said and "(X = 1), t = 0.07" in said
    assert "the solid is crushed in 'rod' at X = 1 (node 0): its stretch is 0.0" in said
    stretch, push = map(float, re.search(r"stretch is (\S+) under .* of (\S+) K", said).groups())
    assert push == pytest.approx(-np.log(stretch), rel=0.02), "the law's stress is K ln x_X"
    assert "nan" not in said and "-fsi_" not in said


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
