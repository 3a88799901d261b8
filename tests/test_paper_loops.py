"""The compiled right-hand sides of the paper's method against plain matrices."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")

from paper_parts import (
    GAS,
    HALO,
    ROD,
    H,
    elastic_rates,
    gas_rates,
    gas_record,
    gas_state,
    operator_of,
    primitive,
    solid_record,
    solid_state,
)

from fsipetsc.boundaries import WALL
from fsipetsc.materials.solid_pressure import Gruneisen
from fsipetsc.operators import OPERATORS
from fsipetsc.operators.narrow import remainder
from fsipetsc.paper import rates

ORDERS = pytest.mark.parametrize("order", OPERATORS)
NARROW = pytest.mark.parametrize("narrow", [False, True], ids=["wide", "narrow"])
RUBBER = ROD.elastic._replace(law=Gruneisen(0.3))


def second(order: int, b: np.ndarray, narrow: bool) -> np.ndarray:
    """(b f_X)_X as a matrix: D b D, or the narrow one."""
    op, n = OPERATORS[order], len(b)
    D = op.matrix(n, H)
    narrowing = remainder(op.interior, b) / op.norm_weights(n)[:, None] / H**2 if narrow else 0.0
    return D @ np.diag(b) @ D - narrowing


def gas_reference(order: int, layer: np.void, q: np.ndarray, narrow: bool) -> np.ndarray:
    """(4.20) with dense matrices."""
    active = slice(layer["lo"], layer["hi"] + 1)
    D = OPERATORS[order].matrix(layer["hi"] - layer["lo"] + 1, H)
    rho, u, T = primitive(GAS, q[active])
    p, v, unit = GAS.law.pressure(rho, T), u - layer["s"], np.ones(len(rho))
    f = np.zeros_like(q)
    f[active, 0] = -D @ (rho * v)
    f[active, 1] = -D @ (rho * u * v + p) + second(order, GAS.mu * unit, narrow) @ u
    f[active, 2] = -D @ (q[active, 2] * v + u * p)
    f[active, 2] += second(order, GAS.mu * u, narrow) @ u
    f[active, 2] += second(order, GAS.kappa * unit, narrow) @ T
    return f


def solid_reference(order: int, q: np.ndarray, narrow: bool) -> np.ndarray:
    """(4.19) with dense matrices."""
    D = OPERATORS[order].matrix(len(q), H)
    u, sigma, T, x = q.T
    x_X, u_X = D @ x, D @ u
    traction = sigma - 0.3 * ROD.m0 * ROD.alpha * T / x_X
    heat = traction * u_X + second(order, ROD.kappa_e / x_X, narrow) @ T
    u_t = D @ traction / ROD.m0 + ROD.force
    return np.stack([u_t, ROD.K / x_X * u_X, heat / (ROD.alpha * ROD.m0), u], axis=-1)


def found(kernel, law, layer: np.void, op: np.void, q: np.ndarray, cuts=()) -> np.ndarray:
    """Rates of all points, by ranks that own them between the cuts; not a number beyond halos."""
    n, parts = len(q), []
    for begin, end in zip((0, *cuts), (*cuts, n), strict=True):
        layer["own_lo"], layer["own_hi"] = begin, end
        layer["halo_lo"], layer["halo_hi"] = min(HALO, begin), min(HALO, n - end)
        local = q[begin - layer["halo_lo"] : end + layer["halo_hi"]].copy()
        kept, out = local.copy(), np.full((end - begin, q.shape[1]), np.nan)
        # the margins of narrow derivatives are zero; nothing else of the scratch is read unset
        scratch = np.full((rates.ROWS, len(local) + rates.MORE), 0.0 if op["narrow"] else np.nan)
        kernel(op, law, layer, local, np.zeros((0, q.shape[1])), scratch, out)
        assert np.array_equal(local, kept), "the state is only read"
        parts.append(out)
    return np.concatenate(parts)


def assert_close(got: np.ndarray, wanted: np.ndarray) -> None:
    """Equal up to round-off of the largest number in a column."""
    off = np.abs(got - wanted) / np.abs(wanted).max(axis=0)
    assert off.max() <= 1e-10, off.max(axis=0)


def sizes(order: int) -> list[int]:
    least = OPERATORS[order].min_points
    return [*range(least, least + 4), 60]


@ORDERS
@NARROW
def test_gas_against_matrices(order, narrow):
    for active in sizes(order):
        n = active + 9
        layer, q, op = gas_record(n, 9, n - 1), gas_state(n), operator_of(order, narrow)
        layer["end_kind"][0] = WALL
        got = found(gas_rates, GAS, layer, op, q)
        assert_close(got, gas_reference(order, layer, q, narrow))
        assert np.all(got[:9] == 0), "points in reserve stay as they are"


@ORDERS
@NARROW
def test_solid_against_matrices(order, narrow):
    for n in sizes(order):
        layer, q, op = solid_record(n), solid_state(n), operator_of(order, narrow)
        assert_close(found(elastic_rates, RUBBER, layer, op, q), solid_reference(order, q, narrow))


@ORDERS
@NARROW
def test_cuts_change_no_bit(order, narrow):
    op, n = operator_of(order, narrow), 70
    for kernel, law, layer, q in (
        (gas_rates, GAS, gas_record(n, 3, n - 1), gas_state(n)),
        (elastic_rates, RUBBER, solid_record(n), solid_state(n)),
    ):
        layer["end_kind"][0] = WALL
        whole = found(kernel, law, layer, op, q)
        for cuts in ((35,), (20, 45), (17, 34, 51)):
            assert np.array_equal(found(kernel, law, layer, op, q, cuts), whole)
