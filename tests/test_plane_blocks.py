"""A layer is gone through in blocks of columns: where these begin, on a rank or on many, changes no bit of the rates."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("petsc4py")

import own_gas
from mpi4py import MPI

from fsipetsc.boundaries.plane import NoSlip, Slip
from fsipetsc.operators.rows import BLOCK
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.plane.grids import make_grids
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.own_laws import gas_law
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem
from fsipetsc.scheme.plane.equations import PlaneForm
from fsipetsc.stepping.plane.edge_data import EdgeData
from fsipetsc.stepping.plane.path import PlanePath

ROWS, COLUMNS = 24, 340


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_where_blocks_begin(order):
    """Between walls, with friction, rough: the whole against cuts next to both ends, one column wide, in the middle. Blocks
    then lie near an end or not, and closures stand in two of them.
    """
    h, material = 1.0 / COLUMNS, Fluid(0.02, 0.03, 1.4, 1.0)
    gas = PlaneFluidLayer("gas", material, (0.0, ROWS * h), lambda X, Y: np.ones((4, *X.shape)), Slip(), Slip())
    case, op = PlaneProblem((gas,), (0.0, 1.0), Slip(), Slip()), OPERATORS[order]
    layout = PlaneLayout(MPI.COMM_SELF, case, op, make_grids(case, op, h))
    path = PlanePath(layout, order, EdgeData(layout), PlaneForm())
    part, rough = path.part(0), np.random.default_rng(order)
    one = np.array([1.0, 1.2, 0.3, -0.2, 3.0])
    part.held[...] = one * (1.0 + 0.1 * rough.uniform(-1.0, 1.0, part.held.shape))
    part._lines[:, 0] = 0.05 * h * rough.uniform(-1.0, 1.0, part._lines[:, 0].shape)
    part.evaluate(0.0)
    whole = part._rates.reshape(part.own.shape).copy()
    assert np.isfinite(whole).all() and whole.shape[1] > 2 * BLOCK
    n = whole.shape[1]
    ends = [cut for k in range(1, 9) for cut in ((0, n - k), (n - k, n), (k, n), (0, k))]
    for a, b in [*ends, (100, 101), (60, 200), (130, 300), (7, 263)]:
        records = layout.records[:1].copy()
        records["own_x"][0] = a, b
        found = np.zeros((whole.shape[0], b - a, whole.shape[2]))
        part.evaluate_block(records, part.y, found.reshape(-1))
        assert np.array_equal(found, whole[:, a:b]), (a, b)
    path.destroy()
    layout.destroy()


def test_a_warm_wall_beside_a_gas_of_another_law():
    """What holds the temperature there takes the energy of the layer's own law: e = cv T - a rho."""

    def attracted(c, rho, T):
        return c[2] * T - 0.3 * rho

    def temperature(c, rho, e):
        return (e + 0.3 * rho) / c[2]

    plain = {name: getattr(own_gas, name) for name in own_gas.NAMES}
    law = gas_law(**{**plain, "energy": attracted, "temperature": temperature, "temperature_in_loops": temperature})
    gas = PlaneFluidLayer("gas", Fluid(0.02, 0.03, 1.4, 1.0, law=law), (0.0, 1.0), lambda X, Y: np.ones((4, *X.shape)))
    case, op = PlaneProblem((gas,), (0.0, 1.0), NoSlip(T=1.5), NoSlip()), OPERATORS[4]
    layout = PlaneLayout(MPI.COMM_SELF, case, op, make_grids(case, op, 1 / 16))
    path = PlanePath(layout, 4, EdgeData(layout), PlaneForm("divergence"))
    part = path.part(0)
    part.held[...] = 1.0, 2.0, 0.0, 0.0, 4.0
    part.settle(0.0)
    assert np.abs(part.own[0, :, 4] - 2.0 * (2.5 * 1.5 - 0.3 * 2.0)).max() < 1e-14
    assert np.array_equal(part.own[-1, :, 4], np.full(part.own.shape[1], 4.0))
    path.destroy()
    layout.destroy()
