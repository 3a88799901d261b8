"""The command `bench`: that it measures and tells what it says; not how fast anything is."""

import pytest
from helpers import message, rows_of, solve


def test_bad_input(tmp_path):
    for words, said in (
        ("-bench_ranks 3", "mpiexec -n 3"),
        ("-bench_rod_program .", "no rod"),
        ("-bench_orders 5", "2,4,6,8"),
    ):
        message(solve("bench", *words.split(), cwd=tmp_path), 2, said)


def test_table(tmp_path):
    other = tmp_path / "rod"
    other.write_text("#!/bin/sh\necho $1 484 $6 0.1 2.5 1\n")
    other.chmod(0o755)
    words = "-bench_problems 0,1 -bench_rod 240 -bench_line 24 -bench_form entropy "
    words += "-bench_seconds 0.01 -bench_repeats 2 -bench_rod_program ."
    done = solve("bench", *words.split(), cwd=tmp_path, ranks=2)
    assert done.returncode == 0, done.stderr
    rows = rows_of(tmp_path / "bench.csv")
    found = [(row["problem"], row["n"], row["ranks"]) for row in rows]
    assert found == [(*problem, n) for problem in (("rod", "240"), ("1-D", "24")) for n in "12"]
    one, two = (float(row["step_us"]) for row in rows[:2])
    assert one > 0.0 and two > 0.0
    assert [row["other_us"] for row in rows] == ["2.5", "2.5", "", ""]
    # a ratio of two samples is the mean of their ratios, so is that of the medians
    assert float(rows[0]["ratio"]) == pytest.approx(one / 2.5, rel=6e-3)
    assert rows[0]["speed_up"] == "" and float(rows[1]["speed_up"]) > 0.0
    nodes = 1e3 * float(rows[2]["step_us"]) / (4 * float(rows[2]["ns_node_rhs"]))
    assert nodes == pytest.approx(48, rel=0.02)
