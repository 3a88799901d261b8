"""The command convergence: its table, its files, grids compared with each other, and refusals."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from helpers import message, solve

pytest.importorskip("petsc4py")

from fsipetsc.analysis.convergence_table import Study, order_of_differences

HS = (0.05, 0.025)


def load(path) -> Study:
    """A study from its table."""
    with path.open() as file:
        about, rows = next(file), list(csv.DictReader(file))
    orders, hs = (tuple(dict.fromkeys(float(row[name]) for row in rows)) for name in ("order", "h"))
    end = float(about.split("t = ")[1].split()[0].rstrip(","))
    study = Study("", end, tuple(map(int, orders)), hs, exact="errors" in about)
    for k, row in enumerate(rows):
        for column in (name for name in row if "/" in name and not name.startswith("order ")):
            group, name = column.split("/")
            study.put(*divmod(k, len(hs)), {group: {name: float(row[column] or "nan")}})
    return study


def compared(differences, hs=(0.4, 0.2, 0.1)) -> Study:
    """Grids compared with each other: of one layer and field."""
    study = Study("box", 1.0, (4,), hs, exact=False)
    for j, difference in enumerate(differences):
        study.put(0, j, {"gas": {"u": difference, "combined": difference}})
    return study


@pytest.mark.parametrize("hs", [(0.4, 0.2, 0.1), (2.0, 1.0, 2 / 3)])
@pytest.mark.parametrize("p", [-1.0, 0.0, 0.5, 7.0])
def test_orders_of_differences_of_any_grids(hs, p):
    """Of errors c h^p; log h for p = 0."""
    first, second = (a**p - b**p if p else np.log(a / b) for a, b in zip(hs, hs[1:]))
    assert order_of_differences(np.log(first / second), *hs) == pytest.approx(p, abs=1e-9)
    study = compared((abs(first), abs(second)), hs)
    np.testing.assert_allclose(study.rates("gas"), [[np.nan, p, np.nan]], atol=1e-9)


@pytest.mark.mpi
def test_grids_of_a_case_are_compared_with_each_other(tmp_path):
    """mms as if it had no exact solution: the orders are those of its errors, on two ranks."""
    (tmp_path / "bare.py").write_text(
        "from dataclasses import replace\nfrom fsipetsc.cases import load_case\n"
        "mms = load_case('mms')\nOPTIONS, DEFAULTS = mms.OPTIONS, mms.DEFAULTS\n"
        "def build(opt):\n    problem = mms.build(opt)\n"
        "    bare = tuple(replace(layer, exact=None) for layer in problem.layers)\n"
        "    return replace(problem, layers=bare)\n"
    )
    words = "bare.py -fsi_orders 4 -fsi_hs 0.1,0.05,0.025"
    done = solve("convergence", *words.split(), cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    study = load(tmp_path / "bare-convergence.csv")
    assert (study.exact, tuple(study.errors)) == (False, ("left", "solid", "right"))
    for group in ("left", "solid", "right"):
        assert 2.7 < study.rates(group)[0, 1] < 5.0, group
        assert "T" in study.errors[group] and np.isnan(study.errors[group]["T"][0, 2])
    left = {path.name for path in tmp_path.iterdir()} - {"__pycache__"}
    assert left == {"bare.py", "bare-convergence.csv", "bare-convergence.png"}


def test_blocks_are_compared_with_each_other(tmp_path):
    """A shock between a gas and a plate, in two dimensions, on three coarse grids, which do not
    resolve it."""
    words = "blast -fsi_hs 0.125,0.0625,0.03125 -ts_max_time 0.05"
    done = solve("convergence", *words.split(), cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    study = load(tmp_path / "blast-convergence.csv")
    for layer in study.errors:
        first, second = study.errors[layer]["combined"][0, :2]
        assert 1e-3 < second < 1.5 * first < 1.0, layer


@pytest.mark.mpi
def test_command(tmp_path):
    """Two ranks have the same errors: the sums of the squares are added up in another order."""
    args = "convergence mms -fsi_orders 2,6 -fsi_hs 0.025,0.05,0.05".split()
    done = solve(*args, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    study = load(tmp_path / "mms-convergence.csv")
    assert (study.orders, study.hs, study.t) == ((2, 6), HS, 0.45)
    assert np.all(study.rates("fluid")[:, 1] > (1.9, 4.3))
    assert np.all(study.rates("solid")[:, 1] > (1.8, 4.1))
    assert solve(*args, "-fsi_output", "two.csv", cwd=tmp_path, ranks=2).returncode == 0
    two = load(tmp_path / "two.csv")
    for kind, name in study.columns():
        found = two.errors[kind][name]
        np.testing.assert_allclose(study.errors[kind][name], found, rtol=2e-9)


def test_a_run_that_fails_is_one_line_of_the_table(tmp_path):
    line = "convergence mms -fsi_orders 4,8 -fsi_hs 0.05,0.025 -fsi_cfl 4"
    done = solve(*line.split(), cwd=tmp_path)
    assert done.returncode == 3 and "  failed: " in done.stdout
    assert done.stderr.count("\n") == 1 and "failed; order " in done.stderr
    assert (tmp_path / "mms-convergence.csv").read_text().count("\n") == 6


@pytest.mark.parametrize(
    ("words", "status", "reason"),
    [
        ("rod -fsi_hs 0.1,0.05", 2, "the case rod has no exact solution: its grids are compared"),
        ("mms -fsi_order 4", 2, "-fsi_orders"),
        ("mms -fsi_hs 0.03", 2, "order 2, h = 0.03: "),
        ("mms -fsi_output nowhere/x.csv -fsi_hs 0.05", 4, "nowhere: No such file or directory"),
    ],
)
def test_bad_input(tmp_path, words, status, reason):
    message(solve("convergence", *words.split(), cwd=tmp_path), status, reason)
    assert not list(tmp_path.iterdir())
