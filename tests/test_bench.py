"""The command `bench`: that it measures and tells what it says; not how fast anything is."""

from __future__ import annotations

import csv
import stat

import pytest
from helpers import run, solve

pytest.importorskip("petsc4py")


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (("-bench_ranks", 3), "mpiexec -n 3"),
        (("-bench_rod_program", "."), "rod"),
        (("-bench_orders", 5), "2, 4, 6, 8"),
    ],
)
def test_bad_input(tmp_path, options, word):
    done = solve("bench", *options, cwd=tmp_path)
    assert done.returncode == 2
    assert word in done.stderr
    assert done.stderr.count("\n") == 1


def test_table(tmp_path):
    other = tmp_path / "rod"
    other.write_text("#!/bin/sh\necho $1 484 $6 0.1 2.5 1\n")
    other.chmod(other.stat().st_mode | stat.S_IXUSR)
    options = "-bench_problems 0,1 -bench_rod 240 -bench_line 24 -bench_form entropy".split()
    options += "-bench_seconds 0.01 -bench_repeats 2 -bench_rod_program .".split()
    done = solve("bench", *options, cwd=tmp_path, ranks=2)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "bench.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["problem"], row["n"], row["ranks"]) for row in rows] == [
        *[("rod", "240", "1"), ("rod", "240", "2"), ("1-D", "24", "1"), ("1-D", "24", "2")]
    ]
    one, two = (float(row["step_us"]) for row in rows[:2])
    assert one > 0.0 and two > 0.0
    assert [row["other_us"] for row in rows] == ["2.5", "2.5", "", ""]
    # a ratio of two samples is the mean of their ratios, so is that of the medians
    assert float(rows[0]["ratio"]) == pytest.approx(one / 2.5, rel=6e-3)
    assert rows[0]["speed_up"] == "" and float(rows[1]["speed_up"]) > 0.0
    nodes = 1e3 * float(rows[2]["step_us"]) / (4 * float(rows[2]["ns_node_rhs"]))
    assert nodes == pytest.approx(48, rel=0.02)
    assert "the table is in bench.csv" in done.stdout


def test_phases_in_the_summary_and_the_log(tmp_path):
    options = "-fsi_h 0.1 -ts_max_steps 20 -fsi_output_dt 1 -log_view".split()
    done = run("-m", "fsipetsc", "rod", *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for phase in ("set-up", "time loop", "output"):
        phases = next(line for line in done.stdout.splitlines() if line.startswith("phases: "))
        assert f"{phase} " in phases
        stages = [line for line in done.stdout.splitlines() if f" {phase}: " in line]
        assert stages, "a stage of PETSc's log"
    steps = next(line for line in done.stdout.splitlines() if line.startswith("fsi step"))
    assert steps.split()[2] == "20"
