"""The command convergence: its table, its files, and how it refuses what it cannot study."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest
from helpers import solve

from fsipetsc.analysis import table1
from fsipetsc.analysis.convergence_table import NAMES, ConvergenceStudy, load
from fsipetsc.errors import FileError
from fsipetsc.output.plots.convergence import convergence_figures

pytest.importorskip("petsc4py")

HS = (0.05, 0.025)


class Made:
    """An outcome with errors h^rate."""

    points, steps, evaluations, wall_time = 100, 50, 200, 0.25

    def __init__(self, h: float, rate: float) -> None:
        self.errors = {kind: {name: h**rate for name in names} for kind, names in NAMES[1].items()}


def made(orders=(2, 4, 6, 8), rates=(2.0, 3.0, 4.0, 5.0), hs=HS, failures=()) -> ConvergenceStudy:
    study = ConvergenceStudy("mms", 0.45, orders, hs, 1, {"fsi_cfl": 0.8}, {"numpy": "1"}, dict(failures))
    for i, rate in enumerate(rates):
        for j, h in enumerate(hs):
            if (orders[i], h) not in study.failures:
                study.put(i, j, Made(h, rate))
    return study


def test_rates_of_powers():
    study = made(hs=(0.04, 0.03, 0.01))
    for kind, names in NAMES[1].items():
        for name in names:
            rates = study.rates(kind, name)
            assert np.isnan(rates[:, 0]).all()
            np.testing.assert_allclose(rates[:, 1:], np.array([[2, 3, 4, 5]]).T * [1, 1])
    np.testing.assert_allclose(study.cost, 50.0)


def test_files_hold_what_was_found(tmp_path):
    study = made(failures={(8, 0.05): "blown up"}.items())
    path = tmp_path / "s.h5"
    assert study.save(path) is None
    back = load(path)
    assert (back.orders, back.hs, back.failures, back.case) == (study.orders, study.hs, study.failures, "mms")
    np.testing.assert_array_equal(back.rates("solid", "x"), study.rates("solid", "x"))
    rows = list(csv.DictReader(io.StringIO(path.with_suffix(".csv").read_text())))
    assert [row["operator"] for row in rows] == ["2/1", "2/1", "4/2", "4/2", "6/3", "6/3", "8/4", "8/4"]
    assert float(rows[1]["rate_fluid_combined"]) == pytest.approx(2, abs=1e-4)
    assert rows[0]["rate_fluid_u"] == rows[6]["fluid_u"] == ""
    assert study.save(path) == tmp_path / "s.1.h5"
    assert (tmp_path / "s.1.csv").is_file()
    (tmp_path / "other.h5").write_bytes(b"no HDF5")
    with pytest.raises(FileError):
        load(tmp_path / "other.h5")


def test_two_dimensions_have_errors_of_their_own(tmp_path):
    """The table by the command, which lays out its own grids; v and y are in it. Errors are integrals of the operators."""
    words = ("plane_mms", "-fsi_orders", "4", "-fsi_hs", "0.125,0.0625", "-fsi_quiet")
    done = solve("convergence", *words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    study = load(tmp_path / "plane_mms-convergence.h5")
    assert study.dimension == 2 and tuple(study.errors["solid"]) == (*"uvTxy", "combined")
    for kind, known in (("fluid", 2.5e-4), ("solid", 3.1e-4)):
        assert study.errors[kind]["combined"][0, 1] < 1.1 * known
        assert study.rates(kind)[0, 1] > 3.7


@pytest.mark.filterwarnings("error")
def test_times_around_a_power_of_ten_can_be_drawn():
    """The axis of the cost reaches from one power to another, not from one to itself."""
    figure = pytest.importorskip("matplotlib.figure").Figure()
    from fsipetsc.output.plots.convergence import draw_cost

    study = made()
    study.wall_time[:] = np.linspace(0.0099, 0.0112, study.wall_time.size).reshape(study.wall_time.shape)
    draw_cost(figure, study)
    assert figure.axes[0].get_xlim() == pytest.approx((0.01, 0.1))


def test_table_1_says_where_ours_differ():
    text = table1.compare(made())
    assert "lower than in the paper: fluid 6/3 (4.0 for 4.7): closures of order 3" in text
    assert "lower than in the paper: solid 6/3 (4.0 for 4.1)" in text.splitlines()
    assert "fluid 8/4 (5.0 for 4.9)" in text.split("higher than in the paper: ")[1]


@pytest.mark.parametrize("rate", [-0.3, 0.5, 2.8, 3.7, 4.6])
def test_the_reason_is_given_where_the_exponent_supports_it(rate):
    assert "closures of order 3" not in table1.compare(made(rates=(2.0, 3.0, rate, 5.0)))


def test_command(tmp_path):
    args = ("convergence", "mms", "-fsi_orders", "2,6", "-fsi_hs", "0.025,0.05")
    done = solve(*args, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "Table 1 of the paper" in done.stdout
    study = load(tmp_path / "mms-convergence.h5")
    assert (study.orders, study.hs, study.time) == ((2, 6), HS, "t = 0.45")  # the case has no units
    assert np.all(study.rates("fluid")[:, 1] > (1.9, 4.3))
    assert np.all(study.rates("solid")[:, 1] > (1.8, 4.1))
    for name in ("mms-convergence.csv", "mms-convergence-error.png", "mms-convergence-cost.png"):
        assert (tmp_path / name).stat().st_size > 100
    assert "kept the earlier" in solve(*args, "-ts_max_steps", "2", cwd=tmp_path).stdout


def test_orders_and_grids_count_once_and_one_grid_shows_no_order(tmp_path):
    line = "convergence mms -fsi_orders 4,2,4 -fsi_hs 0.05,0.05,0.05000000001 -ts_max_steps 2 -fsi_output s.h5"
    done = solve(*line.split(), cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    study = load(tmp_path / "s.h5")
    assert (study.orders, np.round(study.hs, 9).tolist(), study.errors["fluid"]["rho"].shape) == ((4, 2), [0.05], (2, 1))
    assert done.stdout.count("\n0.05 ") == 2
    assert "one grid shows no order: -fsi_hs takes several" in done.stdout and "observed orders of all" not in done.stdout
    assert "runs have ended before t = 0.45, by -ts_max_steps: their errors are those of different times" in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"s.h5", "s.csv", "s-error.png", "s-cost.png"}


@pytest.mark.mpi
def test_ranks_find_the_same_errors(tmp_path):
    args = ("convergence", "pulse", "-fsi_orders", "4", "-fsi_hs", "0.1,0.05", "-fsi_output")
    one, two = (solve(*args, f"{n}.h5", cwd=tmp_path, ranks=n) for n in (1, 2))
    assert (one.returncode, two.returncode) == (0, 0)
    one, two = load(tmp_path / "1.h5"), load(tmp_path / "2.h5")
    assert (one.ranks, two.ranks) == (1, 2)
    for kind, name in one.columns():  # the sums of the squares are added up in another order
        np.testing.assert_allclose(one.errors[kind][name], two.errors[kind][name], rtol=1e-12)


def test_a_run_that_fails_is_one_line_of_the_table(tmp_path):
    line = "convergence mms -fsi_orders 4,8 -fsi_hs 0.05,0.025 -fsi_cfl 4"
    done = solve(*line.split(), cwd=tmp_path)
    assert done.returncode == 3
    assert "  failed: " in done.stdout
    assert done.stderr.count("\n") == 1 and "runs failed; order " in done.stderr
    assert load(tmp_path / "mms-convergence.h5").failures


@pytest.mark.parametrize(
    "arguments, reason",
    [
        (("rod",), "the case rod has no exact solution in layer 'below'"),
        (("mms", "-fsi_order", "4"), "-fsi_orders"),
        (("mms", "-fsi_hs", "0.03"), "order 2, h = 0.03: "),
        (("mms", "-fsi_output", "nowhere/x.h5", "-fsi_hs", "0.05"), "no directory nowhere"),
    ],
)
def test_bad_input(tmp_path, arguments, reason):
    done = solve("convergence", *arguments, cwd=tmp_path)
    assert done.returncode == (4 if "nowhere" in reason else 2)
    assert done.stderr.count("\n") == 1 and reason in done.stderr
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
    assert len(convergence_figures(study, tmp_path / "s.h5")) == 2
