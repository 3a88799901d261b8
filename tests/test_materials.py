"""Laws of materials against the literature, and what is refused."""

from decimal import Decimal, localcontext
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import recorded

from fsipetsc import Fluid, InputError
from fsipetsc.equations.elementary import logarithm_rest
from fsipetsc.kernels.loops import each
from fsipetsc.materials.own import check_inverses, gas_law, solid_law, transport_law
from fsipetsc.materials.solid import ElasticSolid, Solid
from fsipetsc.materials.solid_pressure import gruneisen, mie_gruneisen
from fsipetsc.materials.stiffened_gas import PerfectGas, stiffened_gas
from fsipetsc.materials.sutherland import sutherland
from fsipetsc.scheme.gas_terms import convection_of

ROCK = {"K": 3e9, "kappa_e": 2.0, "m0": 2700.0, "alpha": 900.0}
M0, ALPHA, T_0 = ROCK["m0"], ROCK["alpha"], 300.0
SIZE = M0 * 5e3**2  # of a pressure: that of waves of 5000 m/s


def mie(rho, epsilon):
    """Behind a shock of speed u_s = 5350 + 1.34 u_p, by the jumps of mass, momentum and energy."""
    u_p = 5350 * (1 - M0 / rho) / (1 - 1.34 * (1 - M0 / rho))
    p_H = M0 * (5350 + 1.34 * u_p) * u_p
    return p_H + 2.1 * M0 * (epsilon - ALPHA * T_0 - 0.5 * p_H * (1 / M0 - 1 / rho))


#: p(rho, epsilon) as the literature has it, and the solid
SOLIDS = {
    "gruneisen": (lambda rho, epsilon: 0.8 * rho * epsilon, Solid(**ROCK, pressing=gruneisen(0.8))),
    "mie": (mie, Solid(**ROCK, pressing=mie_gruneisen(5350.0, 1.34, 2.1, T_0))),
}


def slope(f, x):
    d = 1e-3 * abs(x)
    return sum(w * (f(x + k * d) - f(x - k * d)) for k, w in ((1, 45), (2, -9), (3, 1))) / (60 * d)


@pytest.mark.parametrize("x_X", [0.7, 1.0, 1.15])
@pytest.mark.parametrize("T", [250.0, T_0, 1500.0])
@pytest.mark.parametrize("name", SOLIDS)
def test_pressure_of_a_solid(name, T, x_X):
    """With its derivatives; sound by the eigenvalues of (3.1)."""
    exact, solid = SOLIDS[name]
    p = exact(M0 / x_X, ALPHA * T)
    by_T = slope(lambda T: exact(M0 / x_X, ALPHA * T), T)
    by_x = slope(lambda x_X: exact(M0 / x_X, ALPHA * T), x_X)
    assert solid.pressure(T, x_X) == pytest.approx(p, rel=1e-12, abs=1e-15 * SIZE)
    near = {"rel": 1e-8, "abs": 1e-12 * (abs(p) + SIZE)}
    assert solid.elastic.pressure_slopes(T, x_X) == pytest.approx([by_x, by_T], **near)
    for sigma in (0.0, -2e8):
        A = np.zeros((4, 4))  # u, sigma, T, x_X
        A[0, 1:] = np.array([1.0, -by_T, -by_x]) / M0
        A[1:, 0] = solid.K / x_X, (sigma - p) / (ALPHA * M0), 1.0
        c = np.max(np.linalg.eigvals(A).real)
        assert solid.sound_speed(x_X, T, sigma) == pytest.approx(c, rel=1e-8)


def relative(law, T):
    """mu(T)/mu, kappa(T)/kappa of a gas with this law."""
    transport = Fluid(1.0, 1.0, 1.4, 287.0, transport=law).transport_law
    return transport.viscosity(T), transport.conductivity(T)


def test_sutherland_and_a_power_of_the_temperature():
    """Air at 300 K is that of Incropera, DeWitt, Fundamentals of Heat and Mass Transfer, A.4."""
    T = np.array([200.0, 273.0, 300.0, 1000.0, 1900.0])
    factors = relative(sutherland(273.0, 111.0, 194.0), T)
    for factor, S in zip(factors, (111.0, 194.0), strict=True):
        np.testing.assert_allclose(factor, (T / 273) ** 1.5 * (273 + S) / (T + S), rtol=1e-14)
    assert 1.716e-5 * factors[0][2] == pytest.approx(184.6e-7, rel=3e-3)
    assert 0.0241 * factors[1][2] == pytest.approx(26.3e-3, rel=3e-3)
    np.testing.assert_array_equal(*relative(sutherland(273.0, 111.0), T))
    powers = relative(transport_law(lambda T: (T / 273) ** 0.67), T)
    np.testing.assert_array_equal(powers, [(T / 273) ** 0.67] * 2)


R = 287.0
GAS = {
    "pressure": lambda rho, T: R * rho * T,
    "internal_energy": lambda rho, T: 717.5 * T,
    "temperature": lambda rho, e: e / 717.5,
    "density": lambda p, T: p / (R * T),
    "temperature_of": lambda rho, p: p / (R * rho),
}
SOLID = {"mu_e": 1.3, "lambda_e": 2.1, "kappa_e": 0.0, "m0": 1.7, "alpha": 0.6}
LOG, gas = ElasticSolid(**SOLID).solid_law, partial(Fluid, 0.0, 0.0, 1.4, R)


def elastic(stress=lambda F: LOG.stress(F), **energy):
    made = ElasticSolid(**SOLID, law=solid_law(stress=stress, **energy), heat="elastic")
    return made.equations(2).law


def rock(law=None, **wrong):
    return Solid(**ROCK, pressing=law or type("own", (gruneisen,), wrong)(0.8))


def test_functions_as_laws_are_the_built_in_ones():
    """With what is not given, but for the entropy of a gas."""
    own, built_in = gas(law=gas_law(**GAS)).gas_law, PerfectGas(1.4, R)
    names = "energy_density", "heat_capacity", "bulk_modulus", "pressure_by_temperature"
    for name in (*GAS, *names, "sound_speed_squared"):
        wanted = getattr(built_in, name)(1.3, 310.0)
        assert getattr(own, name)(1.3, 310.0) == pytest.approx(wanted, rel=1e-9)
    assert np.isnan(own.entropy(1.3, 310.0))
    own = elastic(energy=lambda F: LOG.energy(F))
    for F in (1.0, 0.0, 0.0, 1.0), (1.1, 0.05, -0.08, 0.95), (0.7, -0.3, 0.2, 1.3):
        assert (own.stress(F), own.energy(F)) == (LOG.stress(F), LOG.energy(F))


WRONG = {
    "a tuple: expected a number": lambda: gas_law(**GAS | {"density": lambda p, T: (p, T)}),
    "law is 'rubber': expected 'log', 'neo-hookean'": lambda: ElasticSolid(**SOLID, law="rubber"),
    "lambda_e is -1: expected": lambda: ElasticSolid(**SOLID | {"lambda_e": -1.0}),
    "kappa_e is nan": lambda: ElasticSolid(**SOLID | {"kappa_e": float("nan")}),
    "density(pressure(rho, T), T) is 2.04: expected 2": lambda: check_inverses(
        gas_law(**GAS | {"density": lambda p, T: 1.02 * p / (R * T)}), np.array([2.0]), 300.0, ""
    ),
    "temperature(rho, internal_energy(rho, T)) is nan: expected 3": lambda: check_inverses(
        gas_law(**GAS | {"temperature": lambda rho, e: np.sqrt(e / 717.5 - 4.0) ** 2 + 4.0}),
        np.array([2.0, 2.0]),
        np.array([5.0, 3.0]),
        "",
    ),
    "stress is not the derivative of energy": lambda: elastic(
        lambda F: (np.log(-(F[1] ** 2)), 0.0, 0.0, 0.0), energy=lambda F: LOG.energy(F)
    ),
    "law is 1.4, which has no 'bulk_modulus'": lambda: gas(law=1.4),
    "(stiffened_gas), which is no NamedTuple": lambda: gas(law=stiffened_gas),
    "law: gamma is None": lambda: gas(law=stiffened_gas(None, 1.0, 0.0)),
    "no formula energy(F), which heat='elastic' needs": lambda: elastic(),
    "not the derivative of energy": lambda: elastic(energy=lambda F: 1.001 * LOG.energy(F)),
    "test_materials.py, line": lambda: elastic(
        lambda F: tuple(np.array(F) - np.eye(2).ravel()), energy=lambda F: LOG.energy(F)
    ),
    "s is 0.2: expected a number not below 0.25": lambda: rock(mie_gruneisen(1, 0.2, 1, 300)),
    "G_0 is None: expected": lambda: rock(mie_gruneisen(1.0, 0.2, None, 300.0)),
    "pressure: ": lambda: rock(pressure=lambda *at: at),
}


@pytest.mark.parametrize("said", WRONG)
def test_what_is_wrong_with_a_material(said):
    with pytest.raises(InputError) as caught:
        WRONG[said]()
    assert said in str(caught.value)


def test_derivatives_of_a_law_of_a_case_are_exact():
    """They follow from the recorded formula: no differences of nearly equal numbers."""
    law = gas_law(
        pressure=lambda rho, T: rho * T / (1.0 - 0.1 * rho) - 0.3 * rho**2,
        internal_energy=lambda rho, T: 2.5 * T + 0.01 * T**2 - 0.3 * rho,
        temperature=lambda rho, e: e,
        density=lambda p, T: p / T,
        temperature_of=lambda rho, p: p / rho,
    )
    rho, T = np.array([0.3, 1.7]), np.array([1.2, 0.4])
    wanted = rho * (T / (1.0 - 0.1 * rho) ** 2 - 0.6 * rho)
    np.testing.assert_allclose(law.bulk_modulus(rho, T), wanted, rtol=1e-15)
    np.testing.assert_allclose(law.heat_capacity(rho, T), 2.5 + 0.02 * T, rtol=1e-15)
    np.testing.assert_allclose(law.pressure_by_temperature(1.7, 0.4), 1.7 / 0.83, rtol=1e-15)


# laws of gases as formulas, and the logarithm; fluxes: test_block_oracle.py

LAWS = PerfectGas(1.4, 2.0), stiffened_gas(2.2, 1.5, 3.0)
STEP = 1e-6


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


def test_the_form_of_convection():
    """The flux that conserves entropy is for the gases whose entropy it conserves."""
    laws = *LAWS, gas(law=gas_law(**GAS)).gas_law
    for option, wanted in ("auto", (1, 1, 0)), ("entropy", (1, 1)), ("divergence", (0, 0, 0)):
        forms = [convection_of(option, SimpleNamespace(law=law, force=(0.0,))) for law in laws]
        assert tuple(form.entropy for form in forms)[: len(wanted)] == wanted
