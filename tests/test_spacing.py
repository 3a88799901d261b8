"""Layers with a spacing of their own: orders, convergence; sums: test_block_oracle.py."""

import numpy as np
import pytest
from helpers import compute

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


@pytest.mark.parametrize(("order", "least", "finer"), [(2, 1.5, 3), (4, 2.3, 3), (6, 3.5, 1 / 3)])
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
