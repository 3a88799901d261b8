"""The command `bench`: that it measures and tells what it says; not how fast anything is."""

from __future__ import annotations

import csv
import math
import time
from types import SimpleNamespace

import pytest
from helpers import mpirun, run, solve

pytest.importorskip("petsc4py")

from fsipetsc.bench import plane, square
from fsipetsc.bench.command import _FORMS
from fsipetsc.bench.cost_model import Model, fit, rounds, scaling, shares
from fsipetsc.bench.document import renew
from fsipetsc.bench.measure import clock
from fsipetsc.bench.study import OF_FORM
from fsipetsc.bench.table import BenchStudy, Row, load
from fsipetsc.cases import load_case
from fsipetsc.errors import FileError, InputError
from fsipetsc.options import defaults

_QUICK = "-bench_orders 4 -bench_points 480,1000 -bench_seconds 0.01 -bench_repeats 2 -bench_more false".split()
_QUICK += "-bench_dimensions", "1"
TRUE = Model(overhead=5.0, work={4: 0.01, 8: 0.02}, overlap=0.3, latency=1.2, error=0.0)


def study() -> BenchStudy:
    """What TRUE would have measured."""
    facts = {f"triad {ranks} {1 << k}": 80.0 / (k - 10) / ranks for ranks in (1, 2) for k in (14, 20, 26)}
    made = BenchStudy([], facts, {"processor": "none"})
    for order in TRUE.work:
        for points in (500, 5000, 50_000):
            for ranks in (1, 2):
                share, reductions = points // ranks, 0 if ranks == 1 else 5
                step = TRUE.step(made, order, share, ranks)
                nothing = dict.fromkeys(("inner", "ends", "exchange", "reduction", "petsc", "call", "bound"), 0.1)
                counts = {"sends": 4 * (ranks - 1), "reductions": reductions, "doubles": 20 * points}
                made.rows.append(Row(order, 6 / points, points, ranks, share, 100, step, step, **nothing, **counts))
    return made


def test_model_is_found_again():
    model = fit(study())
    assert model.error < 1e-6
    assert (model.overhead, model.overlap, model.latency) == pytest.approx((5.0, 0.3, 1.2), rel=1e-4)
    assert model.work == pytest.approx(TRUE.work, rel=1e-4)


def test_rounds_are_a_tree():
    assert rounds(1) == 0
    assert rounds(1024) - rounds(512) == pytest.approx(rounds(4) - rounds(2)) == 5


def test_shares_of_the_partition():
    largest = shares(4, 0.0125)
    assert largest(1) == 483
    assert 483 / 4 <= largest(4) <= 483 / 3
    with pytest.raises(InputError):
        largest(1000)
    table = scaling(TRUE, study(), 4, 0.0125, (1, 2, 4, 1000))
    assert list(table) == [1, 2, 4]
    assert table[1][1] == 1


def test_saved_and_loaded(tmp_path):
    made, path = study(), tmp_path / "b.csv"
    made.save(path)
    again = load(path)
    assert again.facts == pytest.approx(made.facts, rel=1e-5)
    assert again.about == made.about
    assert [r.step for r in again.rows] == pytest.approx([r.step for r in made.rows], rel=1e-5)
    assert all(math.isnan(r.yardstick) for r in again.rows)
    with pytest.raises(FileError):
        load(tmp_path / "nothing.csv")


def test_benchmarks_of_earlier_versions_are_read(tmp_path):
    """They have no columns of other grids and forms; one that lacks another column is no benchmark."""
    made, path = study(), tmp_path / "b.csv"
    made.save(path)
    with path.open() as file:
        rows = list(csv.DictReader(file))

    def without(*names):
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, [name for name in rows[0] if name not in names], extrasaction="ignore")
            writer.writeheader()
            writer.writerows(rows)

    without("stretched", "entropy")
    assert [r.points for r in load(path).rows] == [r.points for r in made.rows]
    without("speedup")
    with pytest.raises(FileError, match="speedup"):
        load(path)


def test_a_benchmark_of_two_dimensions(tmp_path):
    """Beside a program that takes 1 us; the table is saved, and can be put into a document."""
    program = tmp_path / "plane"
    program.write_text('#!/bin/sh\necho "$1 $2 $3  us/step cpu 2.0 median 1.0 best 0.5"\n')
    program.chmod(0o755)
    document = tmp_path / "page.md"
    document.write_text("<!-- bench: plane -->\n<!-- end -->\n<!-- bench: steps -->\nas it was\n<!-- end -->\n")
    words = "-bench_dimensions 2 -bench_orders 4 -bench_squares 32 -bench_form viscous -bench_seconds 0.01 -bench_repeats 2"
    asked = (*words.split(), "-bench_plane_yardstick", str(tmp_path), "-bench_doc", str(document))
    done = solve("bench", *asked, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (row,) = plane.load(tmp_path / "bench-plane.csv")
    assert (row.order, row.form, row.n, row.ranks, row.yardstick) == (4, "viscous", 32, 1, 1.0)
    assert row.ratio == pytest.approx(row.step, rel=0.9) and row.best <= row.step
    assert 1.0 < row.gas < 1e4 and 1.0 < row.solid < 1e4 and row.doubles > 5 * 6
    assert f"| {row.step:.4g} |" in document.read_text() and "as it was" in document.read_text()


def test_names_of_forms():
    assert tuple(square.FORMS) == _FORMS


def test_forms_are_compared_per_point_in_pairs(monkeypatch):
    """The machine is twice as slow in every other round, and has a hiccup in the last one."""
    from mpi4py import MPI

    from fsipetsc.bench import measure

    seen, destroyed = [], []

    class Stand:
        def __init__(self, case, opt, comm):
            self.state, self.cost = SimpleNamespace(points=opt["points"]), opt["cost"]

        def sample(self, seconds):
            return 7

        def steps(self, count):
            seen.append(count)
            if count != 7:
                return 1e9
            done = sum(c == 7 for c in seen) - 1
            return self.cost * self.state.points * (1 + (done // 2) % 2) * (100 if done == 9 else 1)

        def destroy(self):
            destroyed.append(self.cost)

    monkeypatch.setattr(measure, "Stand", Stand)
    options = {"rigid": {"points": 100, "cost": 2.0}, "stretched": {"points": 90, "cost": 2.2}}
    found = measure.compare(None, options, MPI.COMM_SELF, 0.1, 5)
    assert found == pytest.approx({"rigid": 1.0, "stretched": 1.1})
    assert destroyed == [2.0, 2.2]


def test_document_is_renewed(tmp_path):
    path = tmp_path / "d.md"
    names = ("machine", "steps", "parts", "scaling", "around", "model", "expected")
    path.write_text("".join(f"BEFORE\n<!-- bench: {name} -->\nOLD\n<!-- end -->\nAFTER\n" for name in names))
    renew(path, study(), fit(study()))
    text = path.read_text()
    assert "OLD" not in text
    assert text.count("BEFORE") == text.count("AFTER") == len(names)
    renew(path, study(), fit(study()))
    assert path.read_text() == text
    path.write_text("<!-- bench: other --><!-- end -->")
    with pytest.raises(InputError, match="other"):
        renew(path, study(), None)


def test_clock_takes_the_shortest_of_samples_that_are_long_enough(monkeypatch):
    """A clock that stands still but for what is measured: 3 µs a repetition, and a delay in every sample but one."""
    from mpi4py import MPI

    now, delays, counts = 0.0, iter([9e-3, 0, *[5e-3] * 3, 0, *[7e-3] * 99]), []

    def action(count):
        nonlocal now
        counts.append(count)
        now += 3e-6 * count + (next(delays) if count == counts[0] or count > 2500 else 0)

    monkeypatch.setattr(time, "perf_counter", lambda: now)
    assert clock(MPI.COMM_SELF, action, 0.2) == pytest.approx(3.0)
    assert counts[0] == counts[1] == 1, "the first call loads the code, and is not looked at"
    assert 3e-6 * counts[-1] >= 0.2 / 20 and counts[-5:] == [counts[-1]] * 5


@pytest.mark.mpi
def test_command(tmp_path):
    done = mpirun(2, "-m", "fsipetsc", "bench", *_QUICK, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "bench.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["ranks"] for row in rows] == ["1", "2", "1", "2"]
    assert [row["points"] for row in rows] == [row["points"] for row in (rows[0], rows[0], rows[2], rows[2])]
    for row in rows:  # under load any part may seem longer than the whole
        assert float(row["step"]) >= float(row["best"]) > 0
        assert float(row["petsc"]) > 0
        parts = [float(row[name]) for name in ("inner", "ends", "exchange", "petsc", "python")]
        digits = 1e-5 * max(map(abs, parts))  # under load two parts may be large, and of different sign: six digits are saved
        assert sum(parts) == pytest.approx(float(row["best"]), rel=1e-4, abs=digits)
    assert rows[1]["reductions"] == "5" and rows[0]["reductions"] == "0"
    known = defaults(load_case("rod"))
    for name in (name for name, chosen in OF_FORM.items() if chosen.keys() <= known.keys()):  # on one rank
        assert [row[name] == "" for row in rows] == [False, True, False, True]
        assert all(0.2 < float(row[name]) < 20 for row in rows[::2])
    assert (tmp_path / "bench-facts.csv").exists()
    again = solve("bench", "-bench_from", "bench.csv", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert "µs/step" in again.stdout


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (("-bench_ranks", 3), "mpiexec -n 3"),
        (("-bench_yardstick", "."), "rod"),
        (("-bench_orders", 5), "2, 4, 6, 8"),
    ],
)
def test_bad_input(tmp_path, options, word):
    done = solve("bench", *options, cwd=tmp_path)
    assert done.returncode == 2
    assert word in done.stderr
    assert done.stderr.count("\n") == 1


def test_phases_in_the_summary_and_the_log(tmp_path):
    options = "-fsi_h 0.1 -ts_max_steps 20 -fsi_output_dt 1 -log_view".split()
    done = run("-m", "fsipetsc", "rod", *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for phase in ("set-up", "time loop", "output"):
        assert f"{phase} " in next(line for line in done.stdout.splitlines() if line.startswith("phases: "))
        assert any(f" {phase}: " in line for line in done.stdout.splitlines()), "a stage of PETSc's log"
    steps = next(line for line in done.stdout.splitlines() if line.startswith("fsi step"))
    assert steps.split()[2] == "20"
    assert float(steps.split()[6]) > 20 * 4 * 60 * 50, "floating-point operations"
