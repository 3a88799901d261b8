"""The built-in laws beside the pair that is always there: formulas in numbers, and runs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.power_law import power_law
from fsipetsc.materials.solid_pressure import mie_gruneisen
from fsipetsc.materials.sutherland import sutherland

# the pressure of a solid

ROCK = {"K": 3e9, "kappa_e": 2.0, "m0": 2700.0, "alpha": 900.0}
M0, ALPHA, T_0 = ROCK["m0"], ROCK["alpha"], 300.0
#: of a pressure: that of waves of 5000 m/s
SIZE = M0 * 5e3**2


def gruneisen(rho, epsilon):
    return 0.8 * rho * epsilon


def mie(rho, epsilon):
    """Behind a shock of speed u_s = 5350 + 1.34 u_p, by the jumps of mass, momentum and energy."""
    u_p = 5350 * (1 - M0 / rho) / (1 - 1.34 * (1 - M0 / rho))
    p_H = M0 * (5350 + 1.34 * u_p) * u_p
    return p_H + 2.1 * M0 * (epsilon - ALPHA * T_0 - 0.5 * p_H * (1 / M0 - 1 / rho))


#: name -> p(rho, epsilon) as the literature has it, and the solid
SOLIDS = {
    "gruneisen": (gruneisen, Solid(**ROCK, gruneisen=0.8)),
    "mie": (mie, Solid(**ROCK, pressing=mie_gruneisen(5350.0, 1.34, 2.1, T_0))),
}
EACH_SOLID = pytest.mark.parametrize("name", SOLIDS)
#: (T, x_X): squeezed, at rest, pulled
STATES = [(T, x_X) for T in (250.0, T_0, 1500.0) for x_X in (0.7, 1.0, 1.15)]


def slope(f, x):
    """Sixth-order difference."""
    d = 1e-3 * abs(x)
    return sum(w * (f(x + k * d) - f(x - k * d)) for k, w in ((1, 45), (2, -9), (3, 1))) / (60 * d)


def exact(name, T, x_X):
    """p, dp/dT and dp/dx_X of a law of the literature."""
    p = SOLIDS[name][0]
    by_T = slope(lambda T: p(M0 / x_X, ALPHA * T), T)
    return p(M0 / x_X, ALPHA * T), by_T, slope(lambda x_X: p(M0 / x_X, ALPHA * T), x_X)


@EACH_SOLID
def test_pressure_and_its_derivatives(name):
    """Also by differences, where a law of a case does not give them: 1e-9 of the formulas."""
    solid = SOLIDS[name][1]
    law = solid.pressure_law
    Given = NamedTuple("Given", [(name, float) for name in law._fields])
    Given.pressure = type(law).pressure
    own = Solid(**ROCK, pressing=Given(*law))
    for T, x_X in STATES:
        p, by_T, by_x = exact(name, T, x_X)
        assert solid.pressure(T, x_X) == pytest.approx(p, rel=1e-12, abs=1e-15 * SIZE)
        assert solid.elastic.pressure_by_temperature(T, x_X) == pytest.approx(by_T, rel=1e-8)
        assert solid.elastic.stiffness(T, x_X) == pytest.approx(-x_X * by_x, rel=1e-8)
        assert own.pressure(T, x_X) == solid.pressure(T, x_X)
        for what in ("pressure_by_temperature", "stiffness"):
            found, wanted = (getattr(one.elastic, what)(T, x_X) for one in (own, solid))
            assert found == pytest.approx(wanted, abs=1e-9 * (abs(p) + SIZE))


@EACH_SOLID
def test_speed_of_sound_is_that_of_the_linear_theory(name):
    """(3.1) without conduction, linearised with differences of the pressure: an eigenvalue."""
    solid = SOLIDS[name][1]
    for T, x_X in STATES:
        for sigma in (0.0, -2e8):
            A, (p, by_T, by_x) = np.zeros((4, 4)), exact(name, T, x_X)  # u, sigma, T, x_X
            A[0, 1:] = np.array([1.0, -by_T, -by_x]) / M0
            A[1:, 0] = solid.K / x_X, (sigma - p) / (ALPHA * M0), 1.0
            c = np.max(np.linalg.eigvals(A).real)
            assert solid.sound_speed(x_X, T, sigma) == pytest.approx(c, rel=1e-8)


MIE = SOLIDS["mie"][1].pressing
WRONG = {
    "mie_gruneisen: G_0 is 1, s is 0.2: expected G_0 of at most 4 s": lambda: mie_gruneisen(
        1.0, 0.2, 1.0, 300.0
    ),
    "sutherland: S is -111: expected a number not below 0": lambda: sutherland(273.0, -111.0),
    "power_law: T_ref is 0: expected a number above 0": lambda: power_law(0.0, 0.7),
    "gruneisen is 1 beside pressing": lambda: Solid(**ROCK, gruneisen=1.0, pressing=MIE),
    "Solid: pressing": lambda: Solid(**ROCK, pressing=sutherland(273.0, 111.0)),
    "Fluid: transport": lambda: Fluid(1.0, 1.0, 1.4, 1.0, transport=MIE),
    "Fluid: force is None: expected a number": lambda: Fluid(1.0, 1.0, 1.4, 1.0, force=None),
}


@pytest.mark.parametrize("said", WRONG)
def test_wrong_numbers_are_named(said):
    with pytest.raises(InputError) as caught:
        WRONG[said]()
    assert said in str(caught.value)


# viscosity and conductivity of a gas

AIR = {"mu": 1.716e-5, "kappa": 0.0241, "gamma": 1.4, "R": 287.0}


def relative(law, T):
    """mu(T)/mu, kappa(T)/kappa of air with this law."""
    transport = Fluid(**AIR, transport=law).transport_law
    return transport.viscosity(T), transport.conductivity(T)


def test_sutherland_and_power_law():
    """Air at 300 K: 184.6e-7 Pa s, 26.3e-3 W/(m K) [Incropera, DeWitt, Fundamentals of Heat and
    Mass Transfer, Table A.4].
    """
    T = np.array([200.0, 273.0, 300.0, 1000.0, 1900.0])
    factors = relative(sutherland(273.0, 111.0, 194.0), T)
    for factor, S in zip(factors, (111.0, 194.0), strict=True):
        np.testing.assert_allclose(factor, (T / 273) ** 1.5 * (273 + S) / (T + S), rtol=1e-14)
    mu_300, kappa_300 = (of_mu[2] for of_mu in factors)
    assert 1.716e-5 * mu_300 == pytest.approx(184.6e-7, rel=3e-3)
    assert 0.0241 * kappa_300 == pytest.approx(26.3e-3, rel=3e-3)
    powers = relative(power_law(273.0, 0.67, 0.81), T)
    np.testing.assert_allclose(powers, [(T / 273) ** 0.67, (T / 273) ** 0.81], rtol=1e-14)
    alike = relative(power_law(273.0, 0.67), T)
    np.testing.assert_array_equal(alike, [powers[0], powers[0]])
