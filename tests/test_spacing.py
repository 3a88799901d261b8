"""Layers with a spacing of their own: the motion, what is conserved, orders, convergence."""

import numpy as np
import pytest
from helpers import REPOSITORY, compute, message, rows_of, solve
from scipy.interpolate import CubicSpline

FILM = str(REPOSITORY / "tests" / "film.py")
#: a case of fsipetsc/cases whose second layer has a spacing of its own
OWN = """
from dataclasses import replace
from fsipetsc.cases import {name}
OPTIONS, DEFAULTS = {name}.OPTIONS, {name}.DEFAULTS

def build(opt):
    found, h = {name}.build(opt), opt["fsi_h"]
    first, second = found.{layers}
    return replace(found, {layers}=(first, replace(second, {own})))
"""


def test_a_film_moves_as_on_a_grid_of_one_spacing(tmp_path):
    """As the order has it, with few nodes; mass, momentum and energy stay what they were."""
    runs = {f"{h}": (FILM, f"-fsi_h {h} -film_cells 12") for h in (0.02, 0.01)}
    found = compute(1, tmp_path, {"one": (FILM, "-fsi_h 0.0025"), **runs})
    times = np.linspace(0.0, 1.0, 101)
    places = {
        name: CubicSpline(run.series["t"], run.series["x_interface"])(times)
        for name, run in found.items()
    }
    assert [run.summary["points"] for run in found.values()] == [811, 115, 215]
    coarse, fine = (np.abs(places[name] - places["one"]).max() for name in runs)
    assert np.ptp(places["one"][:, 0]) > 0.05
    assert fine < 4e-6 and coarse / fine > 2**3.3
    for run in found.values():
        assert max(run.summary["departures"].values()) < 1e-14


@pytest.mark.parametrize(("order", "least"), [(2, 1.5), (4, 2.3), (6, 3.5)])
@pytest.mark.parametrize("finer", [3, 1 / 3])
def test_orders_of_a_manufactured_solution(order, least, finer, tmp_path):
    """Cells of the solid a third or three times as long: as with one spacing."""
    own = f"cells=(round({finer} * second.cells[0]),)"
    (tmp_path / "own.py").write_text(OWN.format(name="box_mms", layers="blocks", own=own))
    words = f"-box_dimension 1 -fsi_order {order} -fsi_output_dt 1 -fsi_h"
    hs = (1 / 20, 1 / 40) if finer > 1 else (1 / 60, 1 / 120)
    runs = compute(1, tmp_path, {f"{h}": ("own.py", f"{words} {h}") for h in hs})
    for kind in ("fluid", "solid"):
        coarse, fine = (run.errors[kind]["combined"] for run in runs.values())
        assert np.log2(coarse / fine) > least


@pytest.mark.parametrize("own", ["cells=60", "h=1 / 60", "h=h / 3"])
def test_convergence_refines_all_layers(own, tmp_path):
    """Also one whose cells do not depend on -fsi_h, and one that has gone with it anyway, once."""
    (tmp_path / "own.py").write_text(OWN.format(name="heat", layers="layers", own=own))
    words = "own.py -fsi_orders 2 -fsi_h 0.05 -fsi_hs 0.05,0.025"
    done = solve("convergence", *words.split(), cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    text = (tmp_path / "own-convergence.csv").read_text()
    (tmp_path / "rows.csv").write_text(text.split("\n", 1)[1])
    rows = [row for row in rows_of(tmp_path / "rows.csv") if row["quantity"] == "fluid/combined"]
    assert [float(row["points"]) for row in rows] == [21 + 61, 41 + 121]
    assert float(rows[1]["rate"]) > 1.9


def test_too_few_cells(tmp_path):
    words = f"{FILM} -film_cells 5 -ts_max_steps 1".split()
    message(solve(*words, cwd=tmp_path), 2, "'film' has 6 nodes", "at least 8")
    message(solve(FILM, cwd=tmp_path), 2, "-fsi_h 0.04 misses an interface", "cells=")
