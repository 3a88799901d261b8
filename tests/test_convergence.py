"""The command convergence: its table, its files, grids compared with each other, and refusals."""

import csv

import numpy as np
import pytest
from helpers import solve, well

from fsipetsc.studies.verdicts import Expected, Row


def table(folder, *words, name="mms", ranks=1):
    """(quantity, order) -> lines of the table that the command writes, from coarse to fine."""
    well(solve("convergence", *words, cwd=folder, ranks=ranks))
    found = {}
    with (folder / f"{name}-convergence.csv").open() as file:
        next(file)
        for line in csv.DictReader(file):
            found.setdefault((line["quantity"], line["order"]), []).append(line)
    return found


def test_orders_of_differences_of_any_grids():
    """Of errors c h^p; log h for p = 0."""
    for hs in ((0.4, 0.2, 0.1), (2.0, 1.0, 2 / 3)):
        for p in (-1.0, 0.0, 0.5, 7.0):
            found = [abs(a**p - b**p) if p else np.log(a / b) for a, b in zip(hs, hs[1:])]
            found = [0.1 * difference for difference in found]
            row = Row("box", "gas/rho", 4, hs, tuple(found), Expected(p), between=True)
            assert row.observed == pytest.approx((p,), abs=1e-9)
            assert row.verdict == ("converges" if found[-1] < 0.1 else "falls short")


def test_grids_of_a_case_are_compared_with_each_other(tmp_path):
    """mms as if it had no exact solution: the orders are those of its errors, on two ranks."""
    (tmp_path / "bare.py").write_text(
        "from dataclasses import replace\nfrom fsipetsc.cases import load_case\n"
        "mms = load_case('mms')\nOPTIONS, DEFAULTS = mms.OPTIONS, mms.DEFAULTS\n"
        "def build(opt):\n    problem = mms.build(opt)\n"
        "    bare = tuple(replace(layer, exact=None) for layer in problem.layers)\n"
        "    return replace(problem, layers=bare)\n"
    )
    words = "bare.py -fsi_orders 4 -fsi_hs 0.1,0.05,0.025".split()
    found = table(tmp_path, *words, name="bare", ranks=2)
    for layer in ("left", "solid", "right"):
        coarse, fine = found[f"{layer}/combined", "4"]
        assert not coarse["rate"] and 2.7 < float(fine["rate"]) < 5.0, layer
        assert fine["verdict"] == "converges" and fine["h"] == "0.05"
    assert float(found["series/u_interface", "4"][1]["rate"]) > 2.5
    left = {path.name for path in tmp_path.iterdir()} - {"__pycache__"}
    assert left == {"bare.py", "bare-convergence.csv", "bare-convergence.png"}


def test_command(tmp_path):
    found = table(tmp_path, *"mms -fsi_orders 2,6 -fsi_hs 0.025,0.05,0.05".split())
    for order, fluid, solid in (("2", 1.9, 1.8), ("6", 4.3, 4.1)):
        for kind, rate in (("fluid", fluid), ("solid", solid)):
            coarse, fine = found[f"{kind}/combined", order]
            assert (coarse["h"], fine["h"]) == ("0.05", "0.025") and float(fine["rate"]) > rate
            assert fine["verdict"] == "converges" and int(fine["points"]) == 150


def test_a_run_that_fails_is_one_line_of_the_table(tmp_path):
    line = "convergence mms -fsi_orders 4,8 -fsi_hs 0.05,0.025 -fsi_cfl 4"
    done = solve(*line.split(), cwd=tmp_path)
    assert done.returncode == 3 and "  failed: " in done.stdout
    assert done.stderr.count("\n") == 1 and "failed; order " in done.stderr
    assert "computed before" not in done.stderr + done.stdout, "it is removed"
    assert (tmp_path / "mms-convergence.csv").read_text().count("\n") == 2
    assert not (tmp_path / "mms-convergence.png").exists()
