"""Equations and laws of a gas as formulas: fluxes of pairs, entropy, viscous terms."""

import numpy as np
import pytest
from numba import njit

from fsipetsc.equations.gas import Gas
from fsipetsc.equations.logarithm import log
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.power_law import PowerLaw
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.operators.loops import CALL

LAWS = PerfectGas(1.4, 2.0), stiffened_gas(2.2, 1.5, 3.0)
STEP = 1e-6
EACH = pytest.mark.parametrize(("law", "d"), [(law, d) for law in LAWS for d in (1, 2, 3)])


def equations(law, d, mu=0.0, kappa=0.0):
    return Gas(law, PowerLaw(1.3, 0.7, 0.9), mu, kappa, (0.0,) * d)


def pair(gas, d, spread=1.0):
    """Two states, their areas and velocities of the grid."""
    rng = np.random.default_rng(d)
    l, r = (
        gas.state(1 + spread * rng.random(), rng.uniform(-1, 1, d), 2 + spread * rng.random())
        for _ in range(2)
    )
    return l, r, *map(tuple, rng.uniform(-1.0, 1.0, (4, d)))


def variables(gas, w):
    """All d + 2 entropy variables."""
    return np.array([gas.first_entropy_variable(w), *gas.entropy_variables(w)])


@EACH
@pytest.mark.parametrize("name", ["pair_flux", "mean_flux"])
def test_fluxes_are_symmetric_and_those_of_the_equations(law, d, name):
    gas = equations(law, d)
    l, r, a_l, v_l, a_r, v_r = pair(gas, d)

    def flux(l, r, a_l, v_l, a_r, v_r):
        return getattr(gas, name)(l, r, a_l, a_r, gas.volume_flux(a_l, v_l, a_r, v_r))

    there, back = flux(l, r, a_l, v_l, a_r, v_r), flux(r, l, a_r, v_r, a_l, v_l)
    np.testing.assert_allclose(there, back, rtol=1e-14)
    rho, p, T, u, a, g = *l[:3], np.array(l[3:-2]), np.array(a_l), np.dot(a_l, v_l)
    E, V = rho * law.internal_energy(rho, T) + 0.5 * rho * u @ u, a @ u
    exact = [rho * (V - g), *(rho * u * (V - g) + p * a), E * (V - g) + p * V]
    np.testing.assert_allclose(flux(l, l, a_l, v_l, a_l, v_l), exact, rtol=1e-13, atol=1e-14)


@EACH
def test_entropy_variables_are_the_derivative_of_entropy(law, d):
    gas = equations(law, d)
    w = pair(gas, d)[0]
    U = np.array(gas.densities(w))

    def entropy(U):
        return -gas.entropy_density(gas.primitive((1.0, *U)))

    slopes = [(entropy(U + STEP * e) - entropy(U - STEP * e)) / (2.0 * STEP) for e in np.eye(d + 2)]
    np.testing.assert_allclose(variables(gas, w), slopes, rtol=1e-7, atol=1e-8)


@EACH
@pytest.mark.parametrize("spread", [0.17, 3.0])
def test_two_point_flux_conserves_entropy(law, d, spread):
    """With logarithmic means of states that are near and far."""
    gas = equations(law, d)
    l, r, a_l, v_l, a_r, v_r = pair(gas, d, spread)
    a, g = 0.5 * np.add(a_l, a_r), 0.5 * (np.dot(a_l, v_r) + np.dot(a_r, v_l))
    # z . U + rho s: u times it is the potential of the flux
    of_l, of_r = (variables(gas, w) @ gas.densities(w) + gas.entropy_density(w) for w in (l, r))
    exact = of_r * (a @ r[3:-2] - g) - of_l * (a @ l[3:-2] - g)
    parts = (variables(gas, r) - variables(gas, l)) * gas.pair_flux(l, r, a_l, a_r, g)
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


@pytest.mark.parametrize("d", [1, 2, 3])
def test_viscous_flux_of_a_linear_field(d):
    """tau = mu (grad u + grad u^T - 2/3 div u), with mu and kappa of the temperature."""
    rng, gas = np.random.default_rng(d), equations(LAWS[0], d, 0.3, 0.7)
    G, h, u, T = rng.standard_normal((d, d)), rng.standard_normal(d), rng.standard_normal(d), 1.9
    w = gas.state(1.2, tuple(u), T)
    scaled = G / T - np.outer(u, h) / T**2  # grad (u/T)
    tau = np.reshape(gas.viscous_stress(w, tuple(scaled.ravel()), tuple(h / T**2)), (d, d))
    exact = 0.3 * (T / 1.3) ** 0.7 * (G + G.T - 2.0 / 3.0 * np.trace(G) * np.eye(d))
    np.testing.assert_allclose(tau, exact, rtol=1e-13, atol=1e-14)
    heat = gas.conduction(w, tuple(h / T**2))
    np.testing.assert_allclose(heat, 0.7 * (T / 1.3) ** 0.9 * h, rtol=1e-13)


def test_the_compiled_logarithm_is_that_of_numpy():
    """Either may be off by one unit in the last place."""
    compiled = njit(**{**CALL, "cache": False})(lambda x: log(x))
    x = np.concatenate([np.linspace(0.5, 2.0, 4001), 10.0 ** np.linspace(-300.0, 300.0, 4001)])
    error = np.abs([compiled(value) for value in x] - np.log(x))
    assert np.all(error <= 2.0 * np.spacing(np.abs(np.log(x))))
