"""The manufactured solution in one, two and three dimensions: the errors have the order they
should.

A wrong term in the scheme, or in the solution's forcing, leaves an error of order 0.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers import assert_same_fields, compute

pytest.importorskip("petsc4py")

#: dimension -> law of the solid, whether its sides are periodic or given, grids, end, least order:
#: measured 3.3 and 2.5, 2.8 and 2.7 in gas and solid in one and two dimensions
#: (the solid's are those of a start without damping: docs/convergence.md, orders that are reached)
STUDIES = {
    1: ("log", "yes", (1 / 16, 1 / 32), 0.25, 2.4),
    2: ("svk", "no", (1 / 12, 1 / 24), 0.1, 2.7),
    3: ("neo-hookean", "yes", (1 / 8, 1 / 12), 0.05, 2.7),
}


@pytest.mark.parametrize("d", STUDIES)
def test_orders(d, tmp_path):
    """Of 4/2."""
    law, periodic, spacings, end, least = STUDIES[d]
    words = f"-box_dimension {d} -solid_law {law} -box_periodic {periodic} -ts_max_time {end}"
    runs = {f"{h}": ("box_mms", f"{words} -fsi_h {h} -fsi_output_dt 1") for h in spacings}
    results = compute(1, tmp_path, runs)
    coarse, fine = (results[f"{h}"].errors for h in spacings)
    for kind in ("fluid", "solid"):
        gained = np.log(coarse[kind]["combined"] / fine[kind]["combined"])
        order = gained / np.log(spacings[0] / spacings[1])
        assert order > least, (kind, order, coarse[kind], fine[kind])
        assert fine[kind]["combined"] < 2e-3


@pytest.mark.long
@pytest.mark.parametrize(
    ("shape", "gas", "solid"), [("ring", 3.5, 3.6), ("disk", 1.8, 2.9), ("panel", 2.4, 2.6)]
)
def test_orders_on_joined_blocks(shape, gas, solid, tmp_path):
    """Of 4/2, between 8 and 16 cells a block; measured: ring 3.7 and 3.8, panel 2.6 and 2.9, disk
    1.9 and 3.2, where errors of the gas are largest along the rays to the corners of the box.
    """
    runs = {f"{n}": ("body_mms", f"-body_shape {shape} -fsi_h {1 / n}") for n in (8, 16)}
    results = compute(1, tmp_path, runs)
    coarse, fine = (results[n].errors for n in runs)
    for kind, least in (("fluid", gas), ("solid", solid)):
        assert np.log2(coarse[kind]["combined"] / fine[kind]["combined"]) > least, kind
        assert fine[kind]["combined"] < 4e-3


@pytest.mark.mpi
def test_three_dimensions_have_the_same_bits_on_any_number_of_ranks(tmp_path):
    words = "-box_dimension 3 -fsi_h 0.0625 -ts_max_time 0.01 -fsi_output_dt 0.005"
    runs = {"box": ("box_mms", words)}
    one, *others = (compute(n, tmp_path / f"{n}", runs)["box"] for n in (1, 2, 4))
    for other in others:
        assert other.summary["steps"] == one.summary["steps"] > 1
        assert_same_fields(one, other)
