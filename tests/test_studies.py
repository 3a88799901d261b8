"""Commands that study: convergence, bench, modes."""

import numpy as np
import pytest
from helpers import message, program, rows_of, solve, well


def table(folder, *words, name="mms", ranks=1):
    """(quantity, order) -> lines of the table that the command writes, from coarse to fine."""
    well(solve("convergence", *words, cwd=folder, ranks=ranks))
    found = {}
    for line in rows_of(folder / f"{name}-convergence.csv"):
        found.setdefault((line["quantity"], line["order"]), []).append(line)
    return found


def test_grids_of_a_case_are_compared_with_each_other(tmp_path):
    """mms as if it had no exact solution: the orders are those of its errors, on two ranks."""
    (tmp_path / "bare.py").write_text(
        "from dataclasses import replace\nfrom fsipetsc.cases import load_case\n"
        "mms = load_case('mms')\nOPTIONS, DEFAULTS = mms.OPTIONS, mms.DEFAULTS\n"
        "def build(opt):\n    problem = mms.build(opt)\n"
        "    return replace(problem, layers=[replace(of, exact=None) for of in problem.layers])\n"
    )
    words = "-fsi_orders", 4, "-fsi_hs", "0.1,0.05,0.025"
    found = table(tmp_path, "bare.py", *words, name="bare", ranks=2)
    for layer in ("left", "solid", "right"):
        coarse, fine = found[f"{layer}/combined", "4"]
        assert not coarse["rate"] and 2.7 < float(fine["rate"]) < 5.0, layer
        assert fine["verdict"] == "converges" and fine["h"] == "0.05"
    left = {path.name for path in tmp_path.iterdir()} - {"__pycache__"}
    assert left == {"bare.py", "bare-convergence.csv", "bare-convergence.png"}


def test_convergence_of_errors(tmp_path):
    found = table(tmp_path, *"mms -fsi_orders 2,6 -fsi_hs 0.025,0.05,0.05".split())
    for order, fluid, solid in (("2", 1.9, 1.8), ("6", 4.3, 4.1)):
        for kind, rate in (("fluid", fluid), ("solid", solid)):
            coarse, fine = found[f"{kind}/combined", order]
            assert (coarse["h"], fine["h"]) == ("0.05", "0.025") and float(fine["rate"]) > rate
            assert fine["verdict"] == "converges" and int(fine["points"]) == 150


def test_a_run_that_fails_ends_the_study(tmp_path):
    done = solve(*"convergence mms -fsi_orders 8 -fsi_hs 0.05 -fsi_cfl 4".split(), cwd=tmp_path)
    assert "computed before" not in message(done, 3, "order 8, h = 0.05: "), "it is removed"
    assert "result in" not in done.stdout, "runs of a study are quiet"
    assert not list(tmp_path.iterdir())
    done = solve(*"convergence mms -fsi_orders 2,8 -fsi_hs 0.1,0.05".split(), cwd=tmp_path)
    message(done, 2, "order 8, h = 0.1: ", "needs 16: ")
    assert {path.suffix for path in tmp_path.iterdir()} == {".csv", ".png"}, "of order 2"


def test_the_table_of_bench(tmp_path):
    """It measures and tells what it says; not how fast anything is."""
    other = tmp_path / "rod"
    other.write_text("#!/bin/sh\necho $1 484 $6 0.1 2.5 1\n")
    other.chmod(0o755)
    words = "-bench_problems 0,1 -bench_rod 240 -bench_line 24 -bench_form entropy "
    words += "-bench_seconds 0.01 -bench_repeats 2 -bench_rod_program ."
    well(solve("bench", *words.split(), cwd=tmp_path, ranks=2))
    rows = rows_of(tmp_path / "bench.csv")
    found = [(row["problem"], row["n"], row["ranks"]) for row in rows]
    assert found == [(*problem, n) for problem in (("rod", "240"), ("1-D", "24")) for n in "12"]
    one, two = (float(row["step_us"]) for row in rows[:2])
    assert 1.0 < min(one, two)  # each of 240 points takes a nanosecond, and more, in four stages
    assert [row["other_us"] for row in rows] == ["2.5", "2.5", "", ""]
    # a ratio of two samples is the mean of their ratios, so is that of the medians
    assert float(rows[0]["ratio"]) == pytest.approx(one / 2.5, rel=6e-3)
    assert rows[0]["speed_up"] == "" and float(rows[1]["speed_up"]) > 0.0
    # of the rod's 6 m in three layers, and of two blocks: all points of all ranks, four stages; the
    # rod has one or two more once its gases move, as points come and go
    for row, points, more in zip(rows, (243, 243, 48, 48), (2, 2, 0, 0), strict=True):
        nodes = 1e3 * float(row["step_us"]) / (4 * float(row["ns_node_rhs"]))
        assert (1.0 - 6e-3) * (points - more) < nodes < (1.0 + 6e-3) * (points + more)


def test_the_slowest_mode_of_heat(tmp_path):
    """It decays as the exact solution of the case; what is at rest is no mode."""
    well(solve("modes", "heat", "-modes_near", 0.1, "-modes_count", 1, cwd=tmp_path))
    (row,) = rows_of(tmp_path / "modes.csv")
    assert float(row["omega_im"]) == pytest.approx(-0.1841332775, rel=1e-5)


def test_modes_of_a_panel_decay_below_and_grow_above(tmp_path):
    """A thick panel, with the two slowest modes of theory, below the onset of flutter and above."""
    beams, dynamic = program("beams"), (350, 650)
    panel = beams.plane(0.1, "clamped")
    known = [np.array(beams.modes(panel, at)) for at in dynamic]  # s = -i omega
    coarse = "-fsi_h 0.0625 -panel_thickness 0.1 -modes_count 2 -fsi_output some.csv"
    found = []
    for at in dynamic:
        well(solve("modes", "panel", *coarse.split(), "-panel_lambda", at, cwd=tmp_path, ranks=2))
        rows = rows_of(tmp_path / "some.csv")
        found.append([complex(float(r["omega_im"]), float(r["omega_re"])) for r in rows])
    np.testing.assert_allclose(found[0], known[0], rtol=0.05)  # before they meet
    fastest = max(found[1], key=lambda s: s.real)
    assert max(s.real for s in found[0]) < 0 < fastest.real
    assert abs(fastest - known[1][1]) < 0.05
