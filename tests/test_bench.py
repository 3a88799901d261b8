"""The command `bench`: that it measures and tells what it says; not how fast anything is."""

import time

import pytest
from helpers import rows_of, solve


def test_table(tmp_path):
    other = tmp_path / "rod"
    other.write_text("#!/bin/sh\necho $1 484 $6 0.1 2.5 1\n")
    other.chmod(0o755)
    words = "-bench_problems 0,1 -bench_rod 240 -bench_line 24 -bench_form entropy "
    words += "-bench_seconds 0.01 -bench_repeats 2 -bench_rod_program ."
    begun = time.perf_counter()
    done = solve("bench", *words.split(), cwd=tmp_path, ranks=2)
    most = 1e6 * (time.perf_counter() - begun) / 12  # of a step: two samples of six steps at least
    assert done.returncode == 0, done.stderr
    rows = rows_of(tmp_path / "bench.csv")
    found = [(row["problem"], row["n"], row["ranks"]) for row in rows]
    assert found == [(*problem, n) for problem in (("rod", "240"), ("1-D", "24")) for n in "12"]
    one, two = (float(row["step_us"]) for row in rows[:2])
    # each of 240 points takes a nanosecond, and more, in each of four stages
    assert 1.0 < one < most and 1.0 < two < most
    assert [row["other_us"] for row in rows] == ["2.5", "2.5", "", ""]
    # a ratio of two samples is the mean of their ratios, so is that of the medians
    assert float(rows[0]["ratio"]) == pytest.approx(one / 2.5, rel=6e-3)
    assert rows[0]["speed_up"] == "" and float(rows[1]["speed_up"]) > 0.0
    # of the rod's 6 m in three layers, and of two blocks: all points of all ranks, four stages; the
    # rod has one or two more once its gases move, as points come and go
    for row, points, more in zip(rows, (243, 243, 48, 48), (2, 2, 0, 0), strict=True):
        nodes = 1e3 * float(row["step_us"]) / (4 * float(row["ns_node_rhs"]))
        assert (1.0 - 6e-3) * (points - more) < nodes < (1.0 + 6e-3) * (points + more)
