"""The command `verify`: its table, its references, and entries as a user runs them."""

from __future__ import annotations

import csv
import importlib
from math import inf

import numpy as np
import pytest
from helpers import REPOSITORY, message, mpirun, program, solve

from fsipetsc.cases import superseismic as case
from fsipetsc.verify import ENTRIES
from fsipetsc.verify.entry import Bound, Compared, Row, problem, reference
from fsipetsc.verify.viscous_tube import main_vortex, triple_point


def test_orders_and_verdicts():
    row = Row("a", "u", 4, (0.1, 0.05, 0.025), (16e-4, 2e-4, 1e-5), Bound(4.0, 2e-5))
    assert row.observed == pytest.approx((3.0, np.log2(20.0)))
    assert row.verdict == "holds"
    short = row._replace(bound=Bound(4.5, 1e-6))
    assert short.verdict == "order 4.32 < 4.5; error 1.00e-05 > 1.00e-06"
    lost = row._replace(found=(1.0, 1.0, np.nan))
    assert lost.verdict.startswith("order nan < 4; error nan")
    of_grids = row._replace(bound=Bound(at={0.05: 1e-4, 0.025: 1e-4}))
    assert of_grids.verdict == "error 2.00e-04 > 1.00e-04"
    alone = Row("a", "u", 4, (0.1,), (1e-5,), Bound(error=inf))
    assert alone.observed == () and alone.verdict == "no bound"
    assert alone._replace(bound=Bound(error=1e-4)).verdict == "holds"
    assert alone._replace(bound=Bound(1.0)).verdict == "order unknown < 1"
    compared = Row("a", "T", 4, (0.1, 0.05), (Compared(1.2, 2.0), Compared(1.9, 2.0, 0.5)), Bound())
    assert compared.errors == pytest.approx((0.4, 0.2))


@pytest.mark.parametrize(
    ("name", "source", "function"),
    [
        ("riemann_problems", "riemann_problems", "columns"),
        ("superseismic", "superseismic", "columns"),
        ("beam", "beams", "columns"),
        ("panel_flutter", "beams", "flutter_columns"),
        ("normal_modes", "modes", "columns"),
        ("heat", "heat", "columns"),
        ("large_deformation", "large_deformation", "columns"),
        ("oblique", "oblique", "columns"),
    ],
)
def test_references_are_what_their_programs_make(name, source, function):
    kept, made = reference(name), getattr(program(source), function)()
    assert list(kept) == list(made)
    for column, values in made.items():
        np.testing.assert_allclose(kept[column], values, rtol=1e-8, atol=1e-12, err_msg=column)


@pytest.mark.parametrize("name", ENTRIES)
def test_pages_have_the_texts_of_their_problems(name):
    page = (REPOSITORY / "docs" / "verify" / f"{name}.md").read_text()
    assert page.startswith(problem(name))


def test_references_of_profiles():
    """A part of the points; the disk with fewer functions, and it keeps its energy."""
    made, kept = program("elastic_piston").columns(points=5), reference("elastic_piston")
    for name, values in made.items():
        assert kept[name][::100] == pytest.approx(values, rel=1e-10, abs=1e-12), name
    disk, kept = program("disk"), reference("spinning_disk")
    made = disk.columns(20, 20, 5, (2.0,))
    for column, largest in (("real 2", 2e-5), ("imag 2", 2e-5), ("x 2", 1e-6)):
        assert np.abs(made[column] - kept[column][::25]).max() < largest, column
    assert abs(disk.solve(2.0, 2.0, 4, 0.1, 16, 16)[2]) < 1e-12


def test_references_of_gases():
    """Exact ones; those that are computed, on coarser grids."""
    gas, kept = program("gas"), reference("gas")
    made = gas.vortex(201)
    for name, values in zip(("r", "vortex u", "vortex rho", "vortex p"), made):
        np.testing.assert_allclose(kept[name][:201], values, rtol=1e-9, atol=1e-11, err_msg=name)
    for name, values in zip(("sod rho", "sod u", "sod p"), gas.sod(kept["X"], 0.2)):
        np.testing.assert_allclose(kept[name], values, rtol=1e-9, atol=1e-11, err_msg=name)
    known = np.isfinite(kept["x"])
    made, *ends = gas.shu_osher(kept["x"][known], points=(16, 32, 80))
    np.testing.assert_allclose(made, kept["shu_osher rho"][known], atol=5e-5)
    assert ends == pytest.approx([0.729853512, 2.396141891], abs=2e-9)
    kept, made = reference("taylor_green"), program("taylor_green").columns(32, 30)
    for name, values in made.items():
        np.testing.assert_allclose(kept[name], values, atol=5e-4, err_msg=name)
    lost = program("taylor_green").decay(24, 8, 4) - reference("taylor_green_1600")["E"][:5]
    assert (np.abs(lost) < (1e-15, 1e-10, 1e-9, 1e-7, 2e-6)).all()  # k < 8: it holds early


def test_places_in_the_viscous_tube():
    """Found where they are in a made-up flow."""
    x, y = np.linspace(0, 1, 801), np.linspace(0, 0.5, 101)
    X, Y = np.meshgrid(x, y)
    above, foot = 0.58 + 0.1 * (Y - 0.137), 0.58 + 0.4 * (Y - 0.137)
    shock = np.where(Y > 0.137, above, 0.58 + 0.3 * (0.137 - Y))
    # behind the foot p rises from 0.15 of the jump at the wall on
    first = np.where(Y > 0.137, 0.0, 0.15 + 0.8 * Y)
    behind = [0.5 + 0.5 * np.tanh((X - front) / 0.001) for front in (foot, shock)]
    p = 1.0 + first * behind[0] + (1.0 - first) * behind[1]
    assert triple_point(x, y, p) == pytest.approx((0.58, 0.137), abs=4e-3)
    bell = np.exp(-(((X - 0.763) / 0.1) ** 2)) * np.cos(np.pi * Y / 0.16) * (Y < 0.24)
    assert main_vortex(x, y, -bell) == pytest.approx((0.763, 0.08), abs=1e-3)


def test_an_entry_of_the_full_level_alone_has_a_page(tmp_path):
    done = solve("verify", "viscous_tube", "-verify_docs", "pages", cwd=tmp_path)
    assert done.returncode == 0 and "only with -verify_level full" in done.stdout
    text = (tmp_path / "pages" / "viscous_tube.md").read_text()
    assert "Only `-verify_level full` runs this." in text and len(text.splitlines()) <= 60


def test_references_are_those_of_the_literature():
    """Superseismic states, of which the case has ours; waves along half spaces; flutter."""
    table = reference("superseismic")
    ours, literature = ({name: v[row] for name, v in table.items()} for row in (0, 1))
    assert (case.PHI, case.P_WAVE, case.S_WAVE) == (ours["phi"], ours["a"], ours["b"])
    assert case.BEHIND == tuple(ours[name] for name in ("rho", "u", "v", "T"))
    published = {"rho": 0.4032762, "u": 0.7209148, "v": -0.04364727, "T": 0.2252081}
    published |= {"phi": -0.06047047, "a": -0.3079172, "b": 0.1229946}
    for name, value in published.items():
        assert literature[name] == pytest.approx(value, rel=1e-6), name
    waves = reference("normal_modes")
    metals = [waves[f"water over {name} imag"][1] for name in ("steel", "aluminium")]
    assert np.round(np.array(metals) / (2 * np.pi), 2) == pytest.approx([1479.60, 1476.76])
    flutter, theory = reference("panel_flutter"), program("beams")
    for ends, published in (("clamped", 636.57), ("hinged", 343.36)):
        thin = flutter[f"{ends} lambda"][0]
        assert thin == pytest.approx(published, abs=0.005)
        assert theory.onset(theory.thin(ends), "steady") == pytest.approx(thin, rel=1e-9)


def test_what_panels_are_made_of_in_theory():
    """Waves of a plate are those of Rayleigh and Lamb; pressure of a steep exp(a x) is known."""
    theory, d, k = program("beams"), 0.04, np.pi * np.arange(1, 4)
    squares = theory.plane(d, "hinged", 32, 8)[0][:3]
    alpha, beta = (np.sqrt(k**2 - squares / c**2) for c in (4.0 / d, 2.0 / d))
    left = 4.0 * alpha * beta * k**2 * np.tanh(0.5 * beta * d)
    assert left == pytest.approx((k**2 + beta**2) ** 2 * np.tanh(0.5 * alpha * d), rel=1e-10)
    a, s, half = 30.0, 0.3 + 2.0j, np.array([0.5, 0.5])
    x = theory.gauss(80)[0]
    w = np.polynomial.Legendre.fit(x, np.exp(a * (x - 1.0)), 70, domain=[0, 1]).coef[:, None]
    exact = (s + 2.0 * a) ** 2 / np.sqrt((s + 2.0 * a) ** 2 - a**2) / (2.0 * a)
    assert theory.pressure((None, half, w))(s)[0, 0] == pytest.approx(exact, rel=1e-9)


def test_entries_say_all_that_another_code_needs(tmp_path):
    for name in ENTRIES:
        entry = importlib.import_module(f"fsipetsc.verify.{name}")
        assert entry.SOURCE and entry.BOUNDS and entry.FULL
        title, _, *text = problem(name).splitlines()
        assert title.startswith("# ") and 5 < len(text) <= 40
        assert {order for _, order in entry.BOUNDS} <= {*entry.QUICK, *entry.FULL}
    done = solve("verify", "turek", cwd=tmp_path)
    message(done, 2, "there is no entry 'turek': expected elastic_piston")


SMALL = """
from mpi4py import MPI
from fsipetsc.errors import InputError, RanksError
from fsipetsc.verify.command import on_as_many

def run(ranks):
    tried.append(ranks.size)
    if ranks.size > most:
        raise RanksError("too many")

for most in (2, 1, 0):
    tried = []
    try:
        on_as_many(MPI.COMM_WORLD, run)
    except InputError as error:
        tried.append(str(error))
    if MPI.COMM_WORLD.rank == 0:
        print(tried)
"""


@pytest.mark.mpi
def test_a_problem_runs_on_as_many_ranks_as_it_can_feed(tmp_path):
    (tmp_path / "small.py").write_text(SMALL)
    done = mpirun(2, tmp_path / "small.py", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["[2]", "[2, 1]", "[2, 1, 'too many']"]


@pytest.mark.mpi
def test_entries_as_they_run(tmp_path):
    """On two ranks: the elastic piston, and beams, whose frequencies have no steps."""
    words = "verify elastic_piston beam -verify_docs pages".split()
    done = solve(*words, cwd=tmp_path, ranks=2)
    assert done.returncode == 0, done.stdout + done.stderr
    with (tmp_path / "verify.csv").open() as file:
        rows = list(csv.DictReader(file))
    verdicts = {row["quantity"]: row["verdict"] for row in rows}
    assert set(verdicts.values()) == {"holds"}
    assert verdicts["receding, stress"] == verdicts["clamped, d = 0.05"] == "holds"
    beams = [row for row in rows if row["case"] == "beam"]
    for row in beams:
        value, exact = float(row["value"]), float(row["reference"])
        assert float(row["error"]) == pytest.approx(abs(value / exact - 1.0), rel=1e-6)
    assert len(beams) == 2 and not any(row["value"] for row in rows if row not in beams)
    found = {}
    for row in rows:
        found.setdefault(row["quantity"], []).append(float(row["error"]))
    assert 0.0 < found["receding, stress"][1] < found["receding, stress"][0] < 1e-3
    assert 0.0 < found["clamped, d = 0.05"][0] < 3e-4
    assert 0.0 < found["hinged, d = 0.02"][0] < 1e-4
    text = (tmp_path / "pages" / "elastic_piston.md").read_text()
    assert "| receding, stress | 4 |" in text and len(text.splitlines()) <= 60
    assert (tmp_path / "pages" / "elastic_piston.png").stat().st_size > 10_000
    assert not list(tmp_path.glob("verify-*"))
