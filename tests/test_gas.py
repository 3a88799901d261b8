"""Equations and laws of a gas as formulas: entropy and its flux, laws, the logarithm."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from recorded import recorded

from fsipetsc.equations.gas import Gas
from fsipetsc.equations.logarithm import logarithm_rest
from fsipetsc.kernels.loops import each
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.power_law import ConstantTransport
from fsipetsc.materials.stiffened_gas import stiffened_gas

LAWS = PerfectGas(1.4, 2.0), stiffened_gas(2.2, 1.5, 3.0)
STEP = 1e-6


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("d", [1, 2, 3])
@pytest.mark.parametrize("spread", [0.17, 3.0])
def test_two_point_flux_conserves_entropy(law, d, spread):
    """With logarithmic means of states that are near and far."""
    gas, rng = Gas(law, ConstantTransport(), 0.0, 0.0, (0.0,) * d), np.random.default_rng(d)
    l, r = (
        gas.state(1 + spread * rng.random(), rng.uniform(-1, 1, d), 2 + spread * rng.random())
        for _ in range(2)
    )
    # areas, and velocities of the grid
    a_l, v_l, a_r, v_r = map(tuple, rng.uniform(-1.0, 1.0, (4, d)))
    a, g = 0.5 * np.add(a_l, a_r), 0.5 * (np.dot(a_l, v_r) + np.dot(a_r, v_l))

    def variables(w):
        return np.array([gas.first_entropy_variable(w), *gas.entropy_variables(w)])

    # z . U + rho s: u times it is the potential of the flux
    of_l, of_r = (variables(w) @ gas.densities(w) + gas.entropy_density(w) for w in (l, r))
    exact = of_r * (a @ r[3:-2] - g) - of_l * (a @ l[3:-2] - g)
    parts = (variables(r) - variables(l)) * gas.pair_flux(l, r, a_l, a_r, g)
    assert abs(parts.sum() - exact) < 1e-13 * (np.abs(parts).sum() + abs(exact))


@pytest.mark.parametrize("law", LAWS)
def test_laws_are_consistent(law):
    """They invert themselves; T ds = de - p/rho^2 drho; c^2 = dp/drho at constant entropy."""
    rho, T, p, e, s = 1.3, 2.1, law.pressure, law.internal_energy, law.entropy
    near = lambda value, rel=1e-8: pytest.approx(value, rel=rel)  # noqa: E731
    assert law.temperature(rho, e(rho, T)) == near(T, 1e-14)
    assert law.temperature_of(rho, p(rho, T)) == near(T, 1e-14)
    assert law.density(p(rho, T), T) == near(rho, 1e-14)
    assert law.energy_density(rho, T) == near(rho * e(rho, T), 1e-14)

    def slopes(f):
        by_rho, by_T = f(rho + STEP, T) - f(rho - STEP, T), f(rho, T + STEP) - f(rho, T - STEP)
        return by_rho / (2.0 * STEP), by_T / (2.0 * STEP)

    (p_rho, p_T), (e_rho, e_T), (s_rho, s_T) = map(slopes, (p, e, s))
    assert law.bulk_modulus(rho, T) == near(rho * p_rho)
    assert law.pressure_by_temperature(rho, T) == near(p_T)
    assert law.heat_capacity(rho, T) == near(e_T)
    assert law.sound_speed_squared(rho, T) == near(p_rho - p_T * s_rho / s_T)
    assert T * s_T == near(e_T)
    assert abs(T * s_rho - e_rho + p(rho, T) / rho**2) < 1e-8 * p(rho, T)


def test_what_the_logarithm_is_above_its_tangent_has_all_digits():
    """x - 1 - ln x, in Python and as a procedure in C."""

    def rests(x, found):
        for i in each(x.shape[0]):
            found[i] = logarithm_rest(x[i] - 1.0, x[i])

    sizes = 10.0 ** np.linspace(-12.0, -0.05, 400)
    x = np.array([*(1.0 + sizes), *(1.0 - sizes), 1e-3, 1e3])
    of_C = np.zeros(x.size)
    recorded(rests, x, of_C)()
    with localcontext() as digits:
        digits.prec = 50
        exact = [Decimal(value) - 1 - Decimal(value).ln() for value in x.tolist()]
        for found in of_C, logarithm_rest(x - 1.0, x):
            errors = [Decimal(a) / b - 1 for a, b in zip(found.tolist(), exact, strict=True)]
            assert max(map(abs, errors)) < 2e-15


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_dissipation_moves_no_more_than_the_state(law, size):
    """A change over 1 + its square is below half of rho, sqrt(rho K), what K bears of heat."""
    rng, gas = np.random.default_rng(5), Gas(law, ConstantTransport(), 0.0, 0.0, (0.0, 0.0))
    for _ in range(20):
        w = gas.state(1.3, (0.4, -0.2), 0.7)
        dz = tuple(size * rng.uniform(-1.0, 1.0, 4))
        dU, u = gas.densities_of_change(w, dz), np.array(gas.velocity(w))
        eta, K = gas.size_of_change(w, dz, dU), law.bulk_modulus(w[0], w[2])
        drho, push = dU[0], np.array(dU[1:3]) - u * dU[0]
        h = (law.energy_density(w[0], w[2]) + w[1]) / w[0]
        heat = dU[3] - (h - w[2] * law.pressure_by_temperature(w[0], w[2]) / w[0]) * drho
        heat = heat - 0.5 * u @ u * drho - u @ push
        warm = w[0] * law.heat_capacity(w[0], w[2]) * w[2]
        parts = [drho / w[0], *(push / np.sqrt(w[0] * K)), heat / np.sqrt(warm * K)]
        assert eta == pytest.approx(np.square(parts).sum(), rel=1e-9)
        assert np.abs(parts).max() / (1.0 + eta) <= 0.5


def test_a_jump_of_velocity_alone_hardly_moves_cold_gas():
    """Without a bound, a shear layer would take five times its mass out of a node."""
    gas, T, v = Gas(LAWS[0], None, 0.0, 0.0, (0.0, 0.0)), 0.01, (-1.0, -1.0, 1.0)
    c = np.sqrt(1.4 * 2.0 * T)
    W = [gas.state(1.0, (0.0, 12.0 * c * of), T) for of in v]
    z = np.array([(gas.first_entropy_variable(w), *gas.entropy_variables(w)) for w in W])
    dz = tuple(z[0] - 2.0 * z[1] + z[2])
    dU = np.array(gas.densities_of_change(W[1], dz))
    assert abs(dU[0]) > 100.0
    assert abs(dU[0]) / (1.0 + gas.size_of_change(W[1], dz, dU)) < 0.01
