"""The built-in laws of materials beside the pair that is always there: formulas in numbers, and runs with them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from helpers import REPOSITORY, compute

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from conftest import ORDERS

import fsipetsc
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.power_law import power_law
from fsipetsc.materials.solid_pressure import mie_gruneisen, stiffened_pressure
from fsipetsc.materials.sutherland import Sutherland, sutherland
from fsipetsc.options import defaults

CASE = REPOSITORY / "tests" / "materials.py"

# --- the pressure of a solid ------------------------------------------------------------------------------------------

ROCK = {"K": 3e9, "kappa_e": 2.0, "m0": 2700.0, "alpha": 900.0}
T_0 = 300.0


def gruneisen(rho, epsilon):
    return 0.8 * rho * epsilon


def stiffened(rho, epsilon):
    q = ROCK["alpha"] * T_0 - (1e5 + 4.4 * 6e8) / (3.4 * ROCK["m0"])
    return 3.4 * rho * (epsilon - q) - 4.4 * 6e8


def mie(rho, epsilon):
    """The state behind a shock of speed u_s = 5350 + 1.34 u_p, by the jumps of mass, momentum and energy."""
    m0 = ROCK["m0"]
    u_p = 5350 * (1 - m0 / rho) / (1 - 1.34 * (1 - m0 / rho))
    p_H = m0 * (5350 + 1.34 * u_p) * u_p
    return p_H + 2.1 * m0 * (epsilon - ROCK["alpha"] * T_0 - 0.5 * p_H * (1 / m0 - 1 / rho))


#: name -> p(rho, epsilon) as the literature has it, and the solid
SOLIDS = {
    "gruneisen": (gruneisen, Solid(**ROCK, gruneisen=0.8)),
    "stiffened": (stiffened, Solid(**ROCK, pressing=stiffened_pressure(4.4, 6e8, T_0, 1e5))),
    "mie": (mie, Solid(**ROCK, pressing=mie_gruneisen(5350.0, 1.34, 2.1, T_0))),
}
EACH_SOLID = pytest.mark.parametrize("name", SOLIDS)
#: (T, x_X): squeezed, at rest, pulled
STATES = [(T, x_X) for T in (250.0, T_0, 1500.0) for x_X in (0.7, 1.0, 1.15)]


def slope(f, x):
    """Sixth-order difference."""
    d = 1e-3 * abs(x)
    return sum(w * (f(x + k * d) - f(x - k * d)) for k, w in ((1, 45), (2, -9), (3, 1))) / (60 * d)


def of_strain(p, T, x_X):
    """p(epsilon, rho) as a function of temperature and strain."""
    return p(ROCK["m0"] / x_X, ROCK["alpha"] * T)


@EACH_SOLID
def test_pressure_and_its_derivatives(name):
    p, solid = SOLIDS[name]
    scale = 1e-15 * ROCK["m0"] * 5e3**2
    for T, x_X in STATES:
        assert solid.pressure(T, x_X) == pytest.approx(of_strain(p, T, x_X), rel=1e-12, abs=scale)
        by_T = solid.elastic.pressure_by_temperature(T, x_X)
        assert by_T == pytest.approx(slope(lambda T, x_X=x_X: of_strain(p, T, x_X), T), rel=1e-8)
        stiffness = -x_X * slope(lambda x_X, T=T: of_strain(p, T, x_X), x_X)
        assert solid.elastic.stiffness(T, x_X) == pytest.approx(stiffness, rel=1e-8)


@EACH_SOLID
def test_speed_of_sound_is_that_of_the_linear_theory(name):
    """The equations (3.1) without conduction, linearised with differences of the pressure: an eigenvalue."""
    p, solid = SOLIDS[name]
    heat = solid.alpha * solid.m0
    for T, x_X in STATES:
        for sigma in (0.0, -2e8):
            A = np.zeros((4, 4))  # u, sigma, T, x_X
            by_T, by_x = slope(lambda T, x_X=x_X: of_strain(p, T, x_X), T), slope(lambda x_X, T=T: of_strain(p, T, x_X), x_X)
            A[0, 1:] = np.array([1.0, -by_T, -by_x]) / solid.m0
            A[1:, 0] = solid.K / x_X, (sigma - of_strain(p, T, x_X)) / heat, 1.0
            c = np.max(np.linalg.eigvals(A).real)
            assert solid.sound_speed(x_X, T, sigma) == pytest.approx(c, rel=1e-8)


def test_speeds_of_sound_that_the_literature_gives():
    """c^2 = gamma (p + p_inf)/rho of a stiffened gas and c_0 of the Hugoniot, in matter without strength."""
    rho, soft = ROCK["m0"] / 0.8, {**ROCK, "K": 1e-6}
    gas, rock = (Solid(**soft, pressing=SOLIDS[name][1].pressing) for name in ("stiffened", "mie"))
    c = 0.8 * gas.sound_speed(0.8, 400.0)  # with respect to x, not X
    assert c**2 == pytest.approx(4.4 * (gas.pressure(400.0, 0.8) + 6e8) / rho, rel=1e-12)
    assert rock.sound_speed(1.0, T_0) == pytest.approx(5350.0, rel=1e-12)


@EACH_SOLID
def test_no_point_is_faster_than_what_bounds_the_step(name):
    """The speed of the hottest, shortest and least stressed that there is, point by point or not."""
    _, solid = SOLIDS[name]
    rng = np.random.default_rng(7)
    T, x_X, sigma = rng.uniform(250, 1500, 500), rng.uniform(0.7, 1.15, 500), rng.uniform(-2e9, 2e8, 500)
    p = solid.pressure(T, x_X)
    fastest = np.sqrt(solid.elastic.wave_modulus(T, p, sigma, x_X) / solid.m0).max()
    bound = solid.sound_speed(x_X.min(), T.max(), min(sigma.min(), solid.pressure(T.max(), x_X.min())))
    assert fastest <= bound < 2 * fastest


@EACH_SOLID
def test_derivatives_that_a_law_of_a_case_does_not_give(name):
    """By differences: 1e-9 of the formulas."""
    _, solid = SOLIDS[name]
    law = solid.pressure_law
    Given = NamedTuple("Given", [(name, float) for name in law._fields])
    Given.pressure = type(law).pressure
    own = Solid(**ROCK, pressing=Given(*law))
    for T, x_X in STATES:
        size = abs(solid.pressure(T, x_X)) + ROCK["m0"] * 5e3**2
        assert own.pressure(T, x_X) == solid.pressure(T, x_X)
        for name in ("pressure_by_temperature", "stiffness"):
            found, wanted = (getattr(one.elastic, name)(T, x_X) for one in (own, solid))
            assert found == pytest.approx(wanted, abs=1e-9 * size)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: stiffened_pressure(1.0, 1.0, 1.0), "stiffened_pressure: gamma is 1: expected a number above 1"),
        (lambda: stiffened_pressure(4.4, -1.0, 1.0), "stiffened_pressure: p_inf is -1: expected a number not below 0"),
        (lambda: stiffened_pressure(4.4, 1.0, "warm"), "stiffened_pressure: T_0 is 'warm': expected a number above 0"),
        (lambda: mie_gruneisen(1.0, 0.2, 1.0, 300.0), "mie_gruneisen: G_0 is 1, s is 0.2: expected G_0 of at most 4 s"),
        (lambda: mie_gruneisen(0.0, 1.0, 1.0, 300.0), "mie_gruneisen: c_0 is 0: expected a number above 0"),
        (lambda: sutherland(273.0, -111.0), "sutherland: S is -111: expected a number not below 0"),
        (lambda: power_law(0.0, 0.7), "power_law: T_ref is 0: expected a number above 0"),
        (lambda: Solid(**ROCK, gruneisen=1.0, pressing=SOLIDS["mie"][1].pressing), "gruneisen is 1 beside pressing"),
        (lambda: Solid(**ROCK, pressing=sutherland(273.0, 111.0)), "Solid: pressing"),
        (lambda: Fluid(1.0, 1.0, 1.4, 1.0, transport=mie_gruneisen(1.0, 1.0, 1.0, 1.0)), "Fluid: transport"),
        (lambda: Fluid(1.0, 1.0, 1.4, 1.0, force=None), "Fluid: force is None: expected a number"),
    ],
)
def test_wrong_numbers_are_named(call, said):
    with pytest.raises(InputError) as caught:
        call()
    assert said in str(caught.value)


def test_conduction_amplifies_waves_in_a_pulled_solid_whose_pressure_grows_with_temperature():
    """What docs/materials.md says of these equations: the rate grows to (sigma - p) p_T / (2 m0 kappa_e)."""
    K, m0, alpha, kappa_e, by_T, by_x = 10.0, 2.0, 1.0, 0.03, 3.0, -8.0

    def growth(k, net):
        rows = np.zeros((4, 4), complex)  # u, sigma, T, x_X over exp(i k X)
        rows[0, 1:] = np.array([1.0, -by_T, -by_x]) * 1j * k / m0
        rows[1:, 0] = 1j * k * K, 1j * k * net / (alpha * m0), 1j * k
        rows[2, 2] = -kappa_e / (alpha * m0) * k * k
        return np.linalg.eigvals(rows).real.max()

    rates = [growth(k, 2.0) for k in (1.0, 10.0, 100.0, 1e4)]
    bound = 2.0 * by_T / (2 * m0 * kappa_e)
    assert 0 < rates[0] < rates[1] < rates[2] < rates[3] < bound and rates[3] > 0.99 * bound
    assert growth(100.0, -2.0) < 1e-9


# --- viscosity and conductivity of a gas ------------------------------------------------------------------------------

AIR = {"mu": 1.716e-5, "gamma": 1.4, "R": 287.0}


def test_sutherland_and_power_law():
    """Air at 300 K: 184.6e-7 Pa s, 26.3e-3 W/(m K) [Incropera, DeWitt, Fundamentals of Heat and Mass Transfer, Table A.4]."""
    T = np.array([200.0, 273.0, 300.0, 1000.0, 1900.0])
    law = sutherland(273.0, 111.0, 194.0)
    factors = Fluid(**AIR, kappa=0.0241, transport=law).relative(T)
    for factor, S in zip(factors, (111.0, 194.0), strict=True):
        np.testing.assert_allclose(factor, (T / 273) ** 1.5 * (273 + S) / (T + S), rtol=1e-14)
    mu_300, kappa_300 = (of_mu[2] for of_mu in factors)
    assert 1.716e-5 * mu_300 == pytest.approx(184.6e-7, rel=3e-3) and 0.0241 * kappa_300 == pytest.approx(26.3e-3, rel=3e-3)
    powers = Fluid(**AIR, kappa=0.0241, transport=power_law(273.0, 0.67, 0.81)).relative(T)
    np.testing.assert_allclose(powers, [(T / 273) ** 0.67, (T / 273) ** 0.81], rtol=1e-14)
    alike = Fluid(**AIR, kappa=0.0241, transport=power_law(273.0, 0.67)).relative(T)
    np.testing.assert_array_equal(alike, [powers[0], powers[0]])


def test_the_prandtl_number_instead_of_kappa():
    T = np.array([250.0, 900.0])
    for transport in ({}, {"transport": sutherland(273.0, 111.0)}, {"transport": power_law(273.0, 0.67)}):
        air = Fluid.with_prandtl(prandtl=0.71, **AIR, **transport)
        of_mu, of_kappa = air.relative(T)
        cp = air.R * air.gamma / (air.gamma - 1)
        np.testing.assert_allclose(cp * air.mu * of_mu / (air.kappa * of_kappa), 0.71, rtol=1e-14)
    with pytest.raises(InputError, match="has a law of its own for kappa"):
        Fluid.with_prandtl(prandtl=0.71, **AIR, transport=sutherland(273.0, 111.0, 194.0))
    with pytest.raises(InputError, match=r"with_prandtl: prandtl is 0: expected a number above 0"):
        Fluid.with_prandtl(prandtl=0.0, **AIR)


def test_the_example_is_the_built_in_law():
    """runs/sutherland.py writes the law by hand."""
    case = load_case(str(REPOSITORY / "runs" / "sutherland.py"))
    options = defaults(case)
    own, built_in = (case.build({**options, "hot_law": k}).layers[0].material for k in (1, 2))
    T = np.linspace(200.0, 2000.0, 7)
    np.testing.assert_allclose(own.relative(T), built_in.relative(T), rtol=1e-14)
    assert isinstance(built_in.transport, Sutherland) and not isinstance(own.transport, Sutherland)


# --- runs -------------------------------------------------------------------------------------------------------------

#: those of test_mms; 8/4 is not there yet on these grids
LEAST_RATE = {2: 1.9, 4: 2.6, 6: 4.2, 8: 4.4}
COARSE = 0.05, 0.025
LONG = pytest.mark.long  # the kernels of these laws are those of no other test: a minute


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """name -> result; all of one rank in one process, which compiles once."""
    folder = tmp_path_factory.mktemp("materials")
    listed = {}
    for order in ORDERS:
        for h in COARSE:
            listed[f"column_{order}_{h}"] = (str(CASE), f"-fsi_order {order} -fsi_h {h} -materials_state column")
    listed |= {f"fall_{c}": (str(CASE), f"-fsi_h 0.05 -fsi_cfl {c} -materials_state fall") for c in (0.4, 0.2)}
    return {name: fsipetsc.open_run(path) for name, path in compute(1, folder, listed).items()}


@LONG
@pytest.mark.parametrize("name", [f"column_{order}" for order in ORDERS])
def test_a_column_under_gravity_stays_at_rest(runs, name):
    """Gas that carries a solid that carries gas ...: what is not at rest falls with the order."""
    coarse, fine = (runs[f"{name}_{h}"] for h in COARSE)
    speeds = [max(np.nanmax(np.abs(layer["u"][-1])) for layer in run.layers) for run in (coarse, fine)]
    order = int(name.split("_")[1])
    assert np.log2(speeds[0] / speeds[1]) >= LEAST_RATE[order] - 0.6 * (order == 8)


@LONG
def test_all_fall_alike(runs):
    """Between walls that fall, too: u = g t, and nothing else changes; what does is the time step's, of order 4."""
    coarse, fine = (np.array([runs[f"fall_{c}"].errors[kind]["combined"] for kind in ("fluid", "solid")]) for c in (0.4, 0.2))
    assert np.all(coarse < 2e-8) and np.all(coarse > 13 * fine)
    assert np.all(runs["fall_0.2"].layers[2]["u"][-1] < -0.6)
