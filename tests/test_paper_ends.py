"""Ends in the paper's method: beside a gas no mode grows; a right end is a left one in a mirror."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from recorded import recorded

from fsipetsc.boundaries import Dirichlet, Open, absorbing, clamped, free
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.power_law import ConstantTransport
from fsipetsc.materials.solid import Solid
from fsipetsc.operators import OPERATORS
from fsipetsc.operators.narrow import STIFFNESS, STIFFNESS_OF_WIDE, remainder
from fsipetsc.paper.laws import Gas, law_of
from fsipetsc.paper.layout import RECORD
from fsipetsc.paper.outer_ends import Ends, close_solid, fill_ghost, gradient_values
from fsipetsc.paper.stencils import stencils
from fsipetsc.studies.spectra import CENTRAL


class Part(NamedTuple):
    """What the ends of a layer take; seen: u, T for gradients at both ends."""

    op: Any
    ends: Ends
    law: Any
    layers: Any
    local: Any
    seen: Any


def fill_both(part):
    """Fill the ghost points at both ends, and find what gradients see there."""
    for side in range(2):
        fill_ghost(part, side)
    for side in range(2):
        ghost = part.layers[0].hi if side else part.layers[0].lo
        part.seen[side, 0], part.seen[side, 1] = gradient_values(part, ghost, side)


def compiled(function, law, layer, q, order, facts):
    """The procedure for these points of a layer, and its part. facts: what its ends are."""
    records = np.array([layer], RECORD)
    part = Part(stencils(order), facts, law, records, q, np.zeros((2, 2)))
    return recorded(function, part), part


#: a gas with rho = c = T = 1, on N points with h = 1
GAMMA, N, STEP = 1.4, 24, 1e-3
R, CV = 1 / GAMMA, 1 / GAMMA / (GAMMA - 1)
#: whether the gas has viscosity, and whether it conducts
BOTH = (1, 1), (1, 0), (0, 1)


def record(n, h):
    """Of a layer of n points, all active and on this rank."""
    layer = np.zeros(1, RECORD)[0]
    layer["n"] = layer["own_hi"] = n
    layer["hi"], layer["h"], layer["present"] = n - 1, h, 1
    return layer


@lru_cache(None)
def filled(kind, mach, mu, kappa, of_end, delta):
    """The derivative (5, N, 3 N) of rho, u, T, and u, T of gradients, by rho, u, T."""
    gas = Gas(PerfectGas(GAMMA, R), ConstantTransport(), mu, kappa, GAMMA, 0.0)
    layer = record(N, 1.0)
    layer["end_x"], facts = N - 1 - delta, Ends((kind,) * 2, (1 + of_end // 2,) * 2, ("", ""))
    layer["end_data"] = (R, 1.0, mach, of_end) if kind is Open else (1.0, mach, 1.0, 0.0)

    fill, part = compiled(fill_both, gas, layer, np.zeros((3, N)), 4, facts)

    def seen(v):
        rho, u, T = v.reshape(3, N)
        q = part.local
        q[:] = rho, rho * u, gas.total_energy(rho, u, T)
        fill()
        u, T = gas.velocity_and_temperature(*q)
        found = np.array([q[0], u, T, u, T])
        for side in range(2):
            found[3:, -side] = part.seen[side]
        return found.ravel()

    base, near = np.repeat([1.0, mach, 1.0], N), np.arange(3 * N) % N
    found = np.zeros((5 * N, 3 * N))
    for k in np.flatnonzero((near < 7) | (near >= N - 7)):
        change = STEP * np.eye(3 * N)[k]
        pairs = [seen(base + m * change) - seen(base - m * change) for m in range(1, 5)]
        found[:, k] = np.tensordot(CENTRAL, pairs, 1) / STEP
    found = found.reshape(5, N, 3, N)
    for row, column in enumerate((0, 1, 2, 1, 2)):
        found[row, 7:-7, :, 7:-7] = 0.0
        found[row, range(7, N - 7), column, range(7, N - 7)] = 1.0
    return found.reshape(5, N, 3 * N)


def assert_stable(kind, order, mach, mu, kappa, of_end, delta, narrow, bound):
    """No mode grows about a uniform flow, nor with steps of Courant number 0.8."""
    op = OPERATORS[order]
    D, none = op.matrix(N), np.zeros((N, N))
    D2 = D @ D - narrow * remainder(op.interior, np.ones(N)) / op.norm_weights(N)[:, None]
    of_gas = (mu, kappa) if kind is Open else (0.0, 0.0)  # given data do not depend on them
    seen = filled(kind, mach, *of_gas, of_end, delta)
    ghost = seen[:3].reshape(3 * N, 3 * N)
    A = np.block([[mach * D, D, none], [R * D, mach * D, R * D], [none, R / CV * D, mach * D]])
    diffusion = np.vstack([np.zeros((N, 3 * N)), mu * D2 @ seen[3], kappa / CV * D2 @ seen[4]])
    values = np.linalg.eigvals(ghost @ (diffusion - A @ ghost))
    assert values.real.max() < bound
    stiffness = STIFFNESS[order] if narrow else STIFFNESS_OF_WIDE
    z = 0.8 * values / ((1 + abs(mach)) ** 4 + (stiffness * max(mu, kappa / CV)) ** 4) ** 0.25
    assert np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max() < 1 + bound


@pytest.mark.parametrize("order", OPERATORS)
@pytest.mark.parametrize("kind", [Open, Dirichlet], ids=["open", "given"])
def test_no_mode_grows_between_ends(order, kind):
    for mach in (0.01, 0.3, 0.95, 1.5):  # one end with outflow, one with inflow
        for nu in (0.0, 0.01, 0.6, 10.0):
            for mu, kappa in BOTH if nu > 0 else ((0, 0),):
                numbers = kind, order, mach, mu * nu, kappa * CV * nu
                if kind is Dirichlet:
                    for delta in (0.0, 0.5, 0.8):
                        assert_stable(*numbers, order, delta, 0, 1e-8)
                    continue
                for of_open, narrow in ((0, 0), (1, 0), (1, 1)):
                    # without viscosity 2e-5 at most, near the speed of sound
                    slow = narrow and (order, mach, mu) == (8, 0.95, 0)
                    assert_stable(*numbers, of_open, 0.3, narrow, 5e-5 if slow else 1e-12)


@pytest.mark.parametrize("kind", [Open, Dirichlet], ids=["open", "given"])
def test_a_right_end_of_a_gas_is_a_left_end_in_a_mirror(kind):
    numbers, sign = (0.02, 0.03, 1, 0.3), np.array([1, -1, 1, -1, 1])
    for mach in (0.3, 1.5):
        one, other = (filled(kind, m, *numbers).reshape(5, N, 3, N) for m in (mach, -mach))
        mirrored = sign[:, None, None, None] * other[:, ::-1, :, ::-1] * sign[:3, None]
        assert np.isfinite(one).all()
        np.testing.assert_allclose(one, mirrored, atol=1e-11)


@pytest.mark.parametrize(
    ("kind", "heated", "heat"),
    [
        (clamped, "", 0.0),
        (free, "T", 320.0),
        (absorbing, "heat_flux", 1e3),
    ],
    ids=["clamped", "free", "absorbing"],
)
def test_a_right_end_of_a_solid_is_a_left_end_in_a_mirror(kind, heated, heat):
    solid = law_of(Solid(K=1e5, kappa_e=0.5, m0=2700.0, alpha=1.0, gruneisen=0.3))
    X, mirror = 0.01 * np.arange(40), np.array([-1.0, 1.0, 1.0, -1.0])
    fields = np.cos(2 * X), -1e5 + 1e4 * np.sin(3 * X), 300 + 30 * np.sin(X), X + 0.1 * np.sin(X)
    left = np.stack(fields, axis=-1)
    right, before = left[::-1] * mirror, left.copy()
    for side, q in enumerate((left, right)):
        layer = record(40, 0.01)
        facts = Ends(*(pair[:: 1 - 2 * side] for pair in ((kind, None), (0, 0), (heated, ""))))
        layer["end_data"][side, 0] = 0.7 * (1 - 2 * side) if kind is clamped else -9e4
        layer["end_heat"][side] = heat
        close, part = compiled(close_solid, solid, layer, q.T.copy(), 6, facts)
        close()
        q[:] = part.local.T
    np.testing.assert_allclose(right, left[::-1] * mirror, rtol=1e-13)
    assert np.array_equal(left[1:], before[1:]) and (left[0] != before[0]).any()
    assert np.isfinite(left[0]).all()
