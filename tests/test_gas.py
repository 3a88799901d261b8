"""Equations and laws of a gas as formulas: fluxes of pairs, entropy, viscous terms, dissipation."""

from __future__ import annotations

from fractions import Fraction
from math import factorial

import numpy as np
import pytest

from fsipetsc.equations.gas import Gas
from fsipetsc.equations.means import NEAR, near_harmonic_mean, near_mean
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.power_law import PowerLaw
from fsipetsc.materials.stiffened_gas import StiffenedGas
from fsipetsc.operators.loops import dot

LAWS = (PerfectGas(1.4, 2.0), StiffenedGas(2.2, 1.5, 3.0))
STEP = 1e-6


def equations(law, d, mu=0.0, kappa=0.0):
    return Gas(law, PowerLaw(1.3, 0.7, 0.9), mu, kappa, (0.3, -0.2, 0.5)[:d])


def states(gas, rng, d, spread=1.0):
    """Two states, areas and velocities of the grid."""
    found = []
    for _ in range(2):
        u = tuple(rng.uniform(-1.0, 1.0, d))
        found.append(gas.state(1.0 + spread * rng.random(), u, 2.0 + spread * rng.random()))
    areas = [tuple(rng.uniform(-1.0, 1.0, d)) for _ in range(4)]
    return *found, *areas


def variables(gas, w):
    """All d + 2 entropy variables."""
    return np.array([gas.first_entropy_variable(w), *gas.entropy_variables(w)])


def potential(gas, w):
    """z . U + rho s, which u times is that of the flux."""
    return variables(gas, w) @ np.array(gas.densities(w)) + gas.entropy_density(w)


@pytest.fixture(params=[(law, d) for law in LAWS for d in (1, 2, 3)])
def case(request):
    law, d = request.param
    return equations(law, d), d, np.random.default_rng(d)


@pytest.mark.parametrize("name", ["pair_flux", "mean_flux"])
def test_fluxes_are_symmetric_and_consistent(case, name):
    gas, d, rng = case
    l, r, a_l, v_l, a_r, v_r = states(gas, rng, d)
    flux = getattr(gas, name)
    there, back = flux(l, r, a_l, v_l, a_r, v_r), flux(r, l, a_r, v_r, a_l, v_l)
    np.testing.assert_allclose(there, back, rtol=1e-14)
    assert gas.volume_flux(a_l, v_l, a_r, v_r) == 0.5 * (dot(a_l, v_r) + dot(a_r, v_l))
    g = gas.volume_flux(a_l, v_l, a_l, v_l)
    exact = np.array(gas.flux(l, a_l)) - g * np.array(gas.densities(l))
    np.testing.assert_allclose(flux(l, l, a_l, v_l, a_l, v_l), exact, rtol=1e-13, atol=1e-14)
    through = {"pair_flux": gas.flux_through, "mean_flux": gas.mean_flux_through}[name]
    one_area = flux(l, r, a_l, v_l, a_l, v_l)
    np.testing.assert_allclose(through(l, r, a_l, g), one_area, rtol=1e-13, atol=1e-14)


def test_flux_through_an_area_is_that_of_the_equations(case):
    gas, d, rng = case
    w, _, a, *_ = states(gas, rng, d)
    rho, p, u = w[0], w[1], np.array(w[3:-2])
    E = rho * gas.law.internal_energy(rho, w[2]) + 0.5 * rho * u @ u
    normal = np.array(a) @ u
    exact = [rho * normal, *(rho * u * normal + p * np.array(a)), (E + p) * normal]
    np.testing.assert_allclose(gas.flux(w, a), exact, rtol=1e-14)
    np.testing.assert_allclose(gas.densities(w), [rho, *(rho * u), E], rtol=1e-14)
    q = gas.conserved(1.7, rho, tuple(u), w[2])
    np.testing.assert_allclose(q, [1.7, *(1.7 * np.array([rho, *(rho * u), E]))], rtol=1e-14)
    np.testing.assert_allclose(gas.primitive(q), w, rtol=1e-13)
    force = np.array(gas.force)
    np.testing.assert_allclose(
        gas.body_force(q), [*(1.7 * rho * force), 1.7 * rho * force @ u], rtol=1e-14
    )


def test_entropy_variables_are_the_derivative_of_entropy(case):
    gas, d, rng = case
    w, *_ = states(gas, rng, d)
    U = np.array(gas.densities(w))

    def entropy(U):
        return -gas.entropy_density(gas.primitive((1.0, *U)))

    slopes = [(entropy(U + STEP * e) - entropy(U - STEP * e)) / (2.0 * STEP) for e in np.eye(d + 2)]
    np.testing.assert_allclose(variables(gas, w), slopes, rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("spread", [0.05, 3.0])
def test_two_point_flux_conserves_entropy(case, spread):
    gas, d, rng = case
    l, r, a_l, v_l, a_r, v_r = states(gas, rng, d, spread)
    a, g = 0.5 * (np.array(a_l) + np.array(a_r)), gas.volume_flux(a_l, v_l, a_r, v_r)
    of_l, of_r = potential(gas, l), potential(gas, r)
    F = np.array(gas.pair_flux(l, r, a_l, v_l, a_r, v_r))
    exact = of_r * (a @ r[3:-2] - g) - of_l * (a @ l[3:-2] - g)
    parts = np.abs((variables(gas, r) - variables(gas, l)) * F).sum()
    assert abs((variables(gas, r) - variables(gas, l)) @ F - exact) < 1e-13 * (parts + abs(exact))
    np.testing.assert_allclose(gas.flux_through(l, r, tuple(a), g), F, rtol=1e-13, atol=1e-14)


def test_polynomials_of_near_means_are_the_series():
    """B = sum_n (-z)^n n!^2 / (2n + 1)!, A = 1 / ((1 + z/4) B)."""
    for z in np.linspace(0.0, NEAR, 101):
        exact = [Fraction(z) ** n * factorial(n) ** 2 / factorial(2 * n + 1) for n in range(16)]
        B = sum(term * (-1) ** n for n, term in enumerate(exact))
        assert near_harmonic_mean(1.0, 1.0, z) == pytest.approx(float(B), rel=2.3e-16, abs=0.0)
        A = 1 / ((1 + Fraction(z) / 4) * B)
        assert near_mean(1.0, 1.0, z) == pytest.approx(float(A), rel=2.3e-16, abs=0.0)


def test_fastest_wave_through_a_moving_area(case):
    gas, d, rng = case
    w, _, a, *_ = states(gas, rng, d)
    c = np.sqrt(gas.law.sound_speed_squared(w[0], w[2]))
    exact = abs(np.array(a) @ w[3:-2] - 0.7) + c * np.linalg.norm(a)
    assert gas.fastest(w, a, 0.7) == pytest.approx(exact, rel=1e-14)
    assert gas.speed_of_sound(w) == pytest.approx(c, rel=1e-14)


def test_sound_speed_follows_from_pressure_and_entropy(case):
    """c^2 = dp/drho at constant entropy; K_T, p_T, cv are derivatives of p and e."""
    law, (rho, T) = case[0].law, (1.3, 2.1)
    p, e, s = law.pressure, law.internal_energy, law.entropy

    def slope(f, along):
        dr, dT = (STEP, 0.0) if along == "rho" else (0.0, STEP)
        return (f(rho + dr, T + dT) - f(rho - dr, T - dT)) / (2.0 * STEP)

    with_rho = slope(p, "rho") - slope(p, "T") * slope(s, "rho") / slope(s, "T")
    assert law.sound_speed_squared(rho, T) == pytest.approx(with_rho, rel=1e-8)
    assert law.bulk_modulus(rho, T) == pytest.approx(rho * slope(p, "rho"), rel=1e-8)
    assert law.pressure_by_temperature(rho, T) == pytest.approx(slope(p, "T"), rel=1e-8)
    assert law.heat_capacity(rho, T) == pytest.approx(slope(e, "T"), rel=1e-8)
    # T ds = de - p/rho^2 drho
    assert T * slope(s, "T") == pytest.approx(slope(e, "T"), rel=1e-8)
    gap = T * slope(s, "rho") - slope(e, "rho") + p(rho, T) / rho**2
    assert abs(gap) < 1e-8 * p(rho, T)


def test_laws_invert_themselves(case):
    law, (rho, T) = case[0].law, (1.3, 2.1)
    p, e = law.pressure(rho, T), law.internal_energy(rho, T)
    assert law.temperature(rho, e) == pytest.approx(T, rel=1e-14)
    assert law.temperature_of(rho, p) == pytest.approx(T, rel=1e-14)
    assert law.density(p, T) == pytest.approx(rho, rel=1e-14)
    assert law.energy_density(rho, T) == pytest.approx(rho * e, rel=1e-14)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_viscous_flux_of_a_linear_field(d):
    """tau = mu (grad u + grad u^T - 2/3 div u), with mu and kappa of the temperature."""
    rng, gas = np.random.default_rng(d), equations(LAWS[0], d, 0.3, 0.7)
    G, h, u, T = rng.standard_normal((d, d)), rng.standard_normal(d), rng.standard_normal(d), 1.9
    w = gas.state(1.2, tuple(u), T)
    scaled = G / T - np.outer(u, h) / T**2  # grad (u/T)
    tau = np.reshape(gas.viscous_stress(w, tuple(scaled.ravel()), tuple(h / T**2)), (d, d))
    of_mu, of_kappa = (T / 1.3) ** 0.7, (T / 1.3) ** 0.9
    exact = 0.3 * of_mu * (G + G.T - 2.0 / 3.0 * np.trace(G) * np.eye(d))
    np.testing.assert_allclose(tau, exact, rtol=1e-13, atol=1e-14)
    heat = gas.conduction(w, tuple(h / T**2))
    np.testing.assert_allclose(heat, 0.7 * of_kappa * h, rtol=1e-13)
    a = rng.standard_normal(d)
    flux = gas.viscous_flux(w, tuple(tau.ravel()), heat, tuple(a))
    np.testing.assert_allclose(flux, [*(tau @ a), a @ (tau @ u + heat)], rtol=1e-12, atol=1e-13)
