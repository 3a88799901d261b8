"""The narrow viscous terms of the compiled right-hand side: against matrices, on any cut, and what they do to energy."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from helpers import from_python
from test_kernels import (
    GAS,
    ORDERS,
    ROD,
    H,
    fluid_record,
    fluid_state,
    right_hand_side,
    solid_record,
    solid_state,
)

from fsipetsc.operators import OPERATORS
from fsipetsc.operators.kernels import BLOCK
from fsipetsc.operators.narrow import remainder
from fsipetsc.physics.fluid import navier_stokes
from fsipetsc.physics.gruneisen import gruneisen
from fsipetsc.physics.narrow import NARROW_GAS, NARROW_SOLID
from fsipetsc.physics.own_laws import transport_law
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.physics.solid import elastic_solid
from fsipetsc.scheme.laws import law
from fsipetsc.scheme.sweep import sweep


def relative(T):
    """mu and kappa over those of the material."""
    return (T / 300.0) * (T / 300.0), T / 200.0


TRANSPORT = transport_law(relative)
narrow_gas = from_python(sweep, law(navier_stokes(perfect_gas, TRANSPORT, NARROW_GAS)))
wide_gas = from_python(sweep, law(navier_stokes(perfect_gas, TRANSPORT)))
narrow_solid, wide_solid = (from_python(sweep, law(elastic_solid(gruneisen, terms))) for terms in (NARROW_SOLID, ()))
#: points: few, and enough for three blocks with ends in the middle of a vector
SIZES = pytest.mark.parametrize("n", [23, 2 * BLOCK + 37])


def narrowing(order: int, b: np.ndarray, u: np.ndarray, h: float = H) -> np.ndarray:
    """-H^-1 R(b) u / h^2."""
    return -remainder(OPERATORS[order].interior, b) @ u / OPERATORS[order].norm_weights(len(u)) / h**2


@ORDERS
@SIZES
def test_gas(order, n):
    """What is added is what the matrices say, to the round-off of that, and no more; nothing changes beyond the ends."""
    layer, q = fluid_record(n, 2, n - 2), fluid_state(n)
    found = [right_hand_side(kernel, layer, order, q, 0, n) for kernel in (wide_gas, narrow_gas)]
    added, active = found[1] - found[0], slice(2, n - 1)
    _, u, T, _ = GAS.primitive(q[active])
    mu, kappa = 4 / 3 * GAS.mu * relative(T)[0], GAS.kappa * relative(T)[1]
    assert not added[:, 0].any() and not added[:2].any() and not added[n - 1 :].any()
    expected = narrowing(order, mu, u), narrowing(order, u * mu, u) + narrowing(order, kappa, T)
    for unknown, truth in enumerate(expected, start=1):
        scale = np.abs(found[0][:, unknown]).max()
        assert np.abs(truth).max() > 1e-6 * scale
        np.testing.assert_allclose(added[active, unknown], truth, rtol=1e-9, atol=1e-14 * scale)


@ORDERS
@SIZES
def test_solid(order, n):
    layer, q = solid_record(n, 0.3), solid_state(n)
    found = [right_hand_side(kernel, layer, order, q, 0, n) for kernel in (wide_solid, narrow_solid)]
    added = found[1] - found[0]
    assert not added[:, [0, 1, 3]].any()
    x_X = OPERATORS[order].matrix(n, H) @ q[:, 3]
    truth = narrowing(order, ROD.kappa_e / x_X, q[:, 2]) / (ROD.m0 * ROD.alpha)
    scale = np.abs(found[0][:, 2]).max()
    np.testing.assert_allclose(added[:, 2], truth, rtol=1e-9, atol=1e-14 * scale)


@ORDERS
def test_any_cut_gives_the_same_bits(order):
    n = 2 * BLOCK + 37
    for kernel, layer, q in (
        (narrow_gas, fluid_record(n, 2, n - 2), fluid_state(n)),
        (narrow_solid, solid_record(n, 0.3), solid_state(n)),
    ):
        whole = right_hand_side(kernel, layer, order, q, 0, n)
        assert np.isfinite(whole).all()
        for begin, end, cuts in ((0, n, (5, 17, BLOCK + 3)), (0, 61, (9, 30)), (61, 700, (333,)), (700, n, (n - 7,))):
            assert np.array_equal(whole[begin:end], right_hand_side(kernel, layer, order, q, begin, end, cuts))


@ORDERS
def test_energy(order):
    """What is added takes nothing from momentum and energy, and what the flow loses by it is the sum of squares."""
    n = 61
    layer, q, op = fluid_record(n, 0, n - 1), fluid_state(n), OPERATORS[order]
    _, u, T, _ = GAS.primitive(q)
    added = right_hand_side(narrow_gas, layer, order, q, 0, n) - right_hand_side(wide_gas, layer, order, q, 0, n)
    norm = op.norm_weights(n)
    rounding = 1e-12 * np.abs(right_hand_side(wide_gas, layer, order, q, 0, n)).sum(axis=0)
    assert np.all(np.abs(norm @ added) <= rounding)
    lost = -norm @ (u * added[:, 1])
    squares = u @ remainder(op.interior, 4 / 3 * GAS.mu * relative(T)[0]) @ u / H**2
    np.testing.assert_allclose(lost, squares, rtol=1e-6)
    assert lost > 0


@ORDERS
def test_shortest_wave_is_damped(order):
    """(-1)^i in u and in T: gone at the rate z mu'/(rho h^2) with the narrow terms, left alone by D twice. So in a solid."""
    n, middle = 64, slice(24, 40)
    z = {2: 4.0, 4: 16 / 3, 6: 272 / 45, 8: 2048 / 315}[order]
    wave = (-1.0) ** np.arange(n)
    layer = fluid_record(n, 0, n - 1)
    layer["s"], rho, T = 0.0, 1.2, 300.0
    q = GAS.conserved(rho + 0 * wave, 1e-4 * wave, T + 0 * wave)
    wide, narrow = (right_hand_side(kernel, layer, order, q, 0, n)[middle] for kernel in (wide_gas, narrow_gas))
    rate = z * 4 / 3 * GAS.mu / H**2
    np.testing.assert_allclose(narrow[:, 1], -rate * 1e-4 * wave[middle], rtol=1e-6)
    assert np.abs(wide[:, 1]).max() < 1e-5 * rate * 1e-4
    layer, q = solid_record(n, 0.0), np.stack([0 * wave, 0 * wave, 300 + 0.1 * wave, H * np.arange(n)], axis=-1)
    wide, narrow = (right_hand_side(kernel, layer, order, q, 0, n)[middle, 2] for kernel in (wide_solid, narrow_solid))
    np.testing.assert_allclose(narrow, -z * ROD.kappa_e / (ROD.m0 * ROD.alpha * H**2) * 0.1 * wave[middle], rtol=1e-9)
    assert np.abs(wide).max() < 1e-9 * np.abs(narrow).max()
