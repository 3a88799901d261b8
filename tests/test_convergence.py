"""The command convergence: its table, its files, grids compared with each other, and how it refuses what it cannot study."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from helpers import message, solve

pytest.importorskip("petsc4py")

from fsipetsc.analysis import table1
from fsipetsc.analysis.convergence_table import ConvergenceStudy, order_of_differences
from fsipetsc.analysis.grid_differences import unresolved
from fsipetsc.output.plots.studies import convergence_figures

HS = (0.05, 0.025)
NAMES = {"fluid": ("rho", "u", "T", "combined"), "solid": ("u", "sigma", "T", "x", "combined")}
COST = {"points": 100, "steps": 50, "evaluations": 200, "wall_time": 0.25}


def load(path) -> ConvergenceStudy:
    """A study from its table; of failures no more than that there is no time."""
    with path.open() as file:
        about = next(file)
        rows = list(csv.DictReader(file))
    assert about.startswith("# ") and " at t = " in about
    orders, hs = (tuple(dict.fromkeys(kind(row[name]) for row in rows)) for name, kind in (("order", int), ("h", float)))
    study = ConvergenceStudy("", float(about.split("t = ")[1].split()[0].rstrip(",")), orders, hs, exact="errors" in about)
    for k, row in enumerate(rows):
        for column in (name for name in row if "/" in name and not name.startswith("order ")):
            group, name = column.split("/")
            study.put(*divmod(k, len(hs)), {}, {group: {name: float(row[column] or "nan")}})
    return study


def made(orders=(2, 4, 6, 8), rates=(2.0, 3.0, 4.0, 5.0), hs=HS, failures=()) -> ConvergenceStudy:
    """With errors h^rate."""
    study = ConvergenceStudy("mms", 0.45, orders, hs, failures=dict(failures))
    for i, rate in enumerate(rates):
        for j, h in enumerate(hs):
            if (orders[i], h) not in study.failures:
                study.put(i, j, COST, {kind: {name: h**rate for name in names} for kind, names in NAMES.items()})
    return study


def compared(differences, hs=(0.4, 0.2, 0.1), order=4) -> ConvergenceStudy:
    """Grids compared with each other: of one layer and field."""
    study = ConvergenceStudy("box", 1.0, (order,), hs, exact=False)
    for j, difference in enumerate(differences):
        study.put(0, j, COST, {"gas": {"u": difference, "combined": difference}})
    return study


def test_rates_of_powers():
    study = made(hs=(0.04, 0.03, 0.01))
    for kind, name in study.columns():
        rates = study.rates(kind, name)
        assert np.isnan(rates[:, 0]).all()
        np.testing.assert_allclose(rates[:, 1:], np.array([[2, 3, 4, 5]]).T * [1, 1])
    np.testing.assert_allclose(study.cost, 50.0)


@pytest.mark.parametrize("hs", [(0.4, 0.2, 0.1), (0.3, 0.2, 0.1), (2.0, 1.0, 2 / 3)])
@pytest.mark.parametrize("p", [-1.0, 0.0, 0.5, 2.0, 7.0])
def test_orders_of_differences_of_any_grids(hs, p):
    """Of errors c h^p; log h for p = 0."""
    first, second = (a**p - b**p if p else np.log(a / b) for a, b in zip(hs, hs[1:]))
    assert order_of_differences(np.log(first / second), *hs) == pytest.approx(p, abs=1e-9)
    study = compared((abs(first), abs(second)), hs)
    np.testing.assert_allclose(study.rates("gas"), [[np.nan, p, np.nan]], atol=1e-9)


def test_layers_that_are_not_resolved_are_told():
    """4/2 has order 3 for smooth solutions."""
    assert unresolved(compared((8e-3, 1e-3)), 0) == []
    assert unresolved(compared((8e-4, 8e-4)), 0) == []
    (much,) = unresolved(compared((0.8, 0.2)), 0)
    assert "layer 'gas' is not resolved: in u the two finest grids differ by 20 % of its range" in much
    (slow,) = unresolved(compared((8e-3, 4e-3)), 0)
    assert "its grids come together of order 1.0, u last, where 4/2 has 3" in slow


def test_files_hold_what_was_found(tmp_path):
    study = made(failures={(8, 0.05): "blown up"}.items())
    path = tmp_path / "s.csv"
    study.save(path)
    back = load(path)
    assert (back.orders, back.hs, back.t) == (study.orders, study.hs, study.t)
    np.testing.assert_allclose(back.rates("solid", "x"), study.rates("solid", "x"), rtol=1e-7)
    with path.open() as file:
        next(file)
        rows = list(csv.DictReader(file))
    assert [row["operator"] for row in rows] == ["2/1", "2/1", "4/2", "4/2", "6/3", "6/3", "8/4", "8/4"]
    assert float(rows[1]["order fluid/combined"]) == pytest.approx(2, abs=1e-4)
    assert rows[0]["order fluid/u"] == rows[6]["fluid/u"] == ""


def test_two_dimensions_have_errors_of_their_own(tmp_path):
    """The table by the command, which lays out its own grids; v and y are in it. Errors are integrals of the operators."""
    words = ("plane_mms", "-fsi_orders", "4", "-fsi_hs", "0.125,0.0625", "-fsi_quiet")
    done = solve("convergence", *words, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    study = load(tmp_path / "plane_mms-convergence.csv")
    assert tuple(study.errors["solid"]) == (*"uvTxy", "combined")
    for kind, known in (("fluid", 2.5e-4), ("solid", 3.1e-4)):
        assert study.errors[kind]["combined"][0, 1] < 1.1 * known
        assert study.rates(kind)[0, 1] > 3.7


@pytest.mark.mpi
def test_grids_of_a_case_are_compared_with_each_other(tmp_path):
    """mms as if it had no exact solution: the orders are those of its errors. The ranks share each run."""
    case = tmp_path / "bare.py"
    case.write_text(
        "from dataclasses import replace\nfrom fsipetsc.cases import load_case\n"
        "mms = load_case('mms')\nSUMMARY, OPTIONS, DEFAULTS = 'mms', mms.OPTIONS, mms.DEFAULTS\n"
        "def build(opt):\n    problem = mms.build(opt)\n"
        "    return replace(problem, layers=tuple(replace(layer, exact=None) for layer in problem.layers))\n"
    )
    words = ("-fsi_orders", "4", "-fsi_hs", "0.1,0.05,0.025")
    done = solve("convergence", "bare.py", *words, cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    study = load(tmp_path / "bare-convergence.csv")
    assert (study.exact, tuple(study.errors)) == (False, ("left", "solid", "right", "series"))
    for group in ("left", "solid", "right"):
        assert 2.7 < study.rates(group)[0, 1] < 5.0, group
        assert "T" in study.errors[group] and np.isnan(study.errors[group]["T"][0, 2])
    assert study.rates("series", "u_interface")[0, 1] > 2.5
    names = {"bare.py", "bare-convergence.csv", "bare-convergence-error.png", "bare-convergence-cost.png"}
    assert {path.name for path in tmp_path.iterdir()} - {"__pycache__"} == names


def test_what_blocks_do_not_resolve_is_said(tmp_path):
    """A shock between a gas and a plate, in two dimensions, on three coarse grids; an axis that the option h leaves alone."""
    words = "blast -fsi_hs 0.125,0.0625,0.03125 -ts_max_time 0.05"
    done = solve("convergence", *words.split(), cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "is not resolved: " in done.stdout


def test_table_1_says_where_ours_differ():
    text = table1.compare(made())
    assert "lower than in the paper: fluid 6/3 (4.0 for 4.7): closures of order 3" in text
    assert "lower than in the paper: solid 6/3 (4.0 for 4.1)" in text.splitlines()
    assert "fluid 8/4 (5.0 for 4.9)" in text.split("higher than in the paper: ")[1]


@pytest.mark.parametrize("rate", [-0.3, 0.5, 2.8, 3.7, 4.6])
def test_the_reason_is_given_where_the_exponent_supports_it(rate):
    assert "closures of order 3" not in table1.compare(made(rates=(2.0, 3.0, rate, 5.0)))


@pytest.mark.mpi
def test_command(tmp_path):
    """Two ranks have the same errors: the sums of the squares are added up in another order."""
    args = ("convergence", "mms", "-fsi_orders", "2,6", "-fsi_hs", "0.025,0.05")
    done = solve(*args, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "Table 1 of the paper" in done.stdout
    study = load(tmp_path / "mms-convergence.csv")
    assert (study.orders, study.hs, study.t) == ((2, 6), HS, 0.45)
    assert np.all(study.rates("fluid")[:, 1] > (1.9, 4.3))
    assert np.all(study.rates("solid")[:, 1] > (1.8, 4.1))
    for name in ("mms-convergence-error.png", "mms-convergence-cost.png"):
        assert (tmp_path / name).stat().st_size > 100
    assert solve(*args, "-fsi_output", "two.csv", cwd=tmp_path, ranks=2).returncode == 0
    two = load(tmp_path / "two.csv")
    for kind, name in study.columns():
        np.testing.assert_allclose(study.errors[kind][name], two.errors[kind][name], rtol=2e-9)


def test_orders_and_grids_count_once_and_one_grid_shows_no_order(tmp_path):
    line = "convergence mms -fsi_orders 4,2,4 -fsi_hs 0.05,0.05,0.05000000001 -ts_max_steps 2 -fsi_output s"
    done = solve(*line.split(), cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    study = load(tmp_path / "s.csv")
    assert (study.orders, np.round(study.hs, 9).tolist(), study.errors["fluid"]["rho"].shape) == ((4, 2), [0.05], (2, 1))
    assert done.stdout.count("h = 0.05 ") == 2
    assert "one grid shows no order: -fsi_hs takes several" in done.stdout and "observed orders of all" not in done.stdout
    assert "runs have ended before t = 0.45, by -ts_max_steps: their errors are those of different times" in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"s.csv", "s-error.png", "s-cost.png"}


def test_a_run_that_fails_is_one_line_of_the_table(tmp_path):
    line = "convergence mms -fsi_orders 4,8 -fsi_hs 0.05,0.025 -fsi_cfl 4"
    done = solve(*line.split(), cwd=tmp_path)
    assert done.returncode == 3
    assert "  failed: " in done.stdout
    assert done.stderr.count("\n") == 1 and "runs failed; order " in done.stderr
    assert (tmp_path / "mms-convergence.csv").read_text().count("\n") == 6


@pytest.mark.parametrize(
    "words, reason",
    [
        ("rod -fsi_hs 0.1,0.05", "the case rod has no exact solution: its grids are compared with each other"),
        ("mms -fsi_order 4", "-fsi_orders"),
        ("mms -fsi_hs 0.03", "order 2, h = 0.03: "),
        ("mms -fsi_output nowhere/x.csv -fsi_hs 0.05", "no directory nowhere"),
    ],
)
def test_bad_input(tmp_path, words, reason):
    message(solve("convergence", *words.split(), cwd=tmp_path), 4 if "nowhere" in reason else 2, reason)
    assert not list(tmp_path.iterdir())


def test_help_lists_the_options_of_study_and_case():
    text = solve("convergence", "mms", "-help").stdout
    assert "-fsi_orders" in text and "-mms_epsilon" in text


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("zero", ["one of the fluid", "all of the fluid", "all"])
def test_pictures_of_errors_that_are_0_and_of_runs_that_cost_much_the_same(zero, tmp_path):
    """Nothing to warn of: what has no place on a logarithmic axis is left out."""
    pytest.importorskip("matplotlib")
    study = made(orders=(2, 4), rates=(2.0, 3.0))
    study.wall_time[:] = 0.8, 1.2  # about a power of ten: their decade is from 1 to 1
    study.errors["fluid"]["combined"][0, 0] = 0.0
    for kind in {"all of the fluid": ("fluid",), "all": ("fluid", "solid")}.get(zero, ()):
        study.errors[kind]["combined"][:] = 0.0
    assert len(convergence_figures(study, tmp_path / "s.csv")) == 2
