"""The built-in laws of materials beside the pair that is always there: formulas in numbers, and runs with them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from helpers import REPOSITORY, compute

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

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
        by_T = solid.pressure_by_temperature(T, x_X)
        assert by_T == pytest.approx(slope(lambda T, x_X=x_X: of_strain(p, T, x_X), T), rel=1e-8)
        stiffness = -x_X * slope(lambda x_X, T=T: of_strain(p, T, x_X), x_X)
        assert solid.stiffness(T, x_X) == pytest.approx(stiffness, rel=1e-8)


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
        assert own.pressure_by_temperature(T, x_X) == pytest.approx(solid.pressure_by_temperature(T, x_X), abs=1e-9 * size)
        assert own.stiffness(T, x_X) == pytest.approx(solid.stiffness(T, x_X), abs=1e-9 * size)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: stiffened_pressure(4.4, -1.0, 1.0), "stiffened_pressure: p_inf is -1: expected a number not below 0"),
        (lambda: mie_gruneisen(1.0, 0.2, 1.0, 300.0), "mie_gruneisen: G_0 is 1, s is 0.2: expected G_0 of at most 4 s"),
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


def test_the_example_is_the_built_in_law():
    """runs/sutherland.py writes the law by hand."""
    case = load_case(str(REPOSITORY / "runs" / "sutherland.py"))
    options = defaults(case)
    own, built_in = (case.build({**options, "hot_law": k}).layers[0].material for k in (1, 2))
    T = np.linspace(200.0, 2000.0, 7)
    np.testing.assert_allclose(own.relative(T), built_in.relative(T), rtol=1e-14)
    assert isinstance(built_in.transport, Sutherland) and not isinstance(own.transport, Sutherland)


# --- runs -------------------------------------------------------------------------------------------------------------

LEAST_RATE = {4: 2.6, 6: 4.2}
COARSE = 0.05, 0.025
LONG = pytest.mark.long  # the kernels of these laws are those of no other test: a minute


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """name -> result; all of one rank in one process, which compiles once."""
    folder = tmp_path_factory.mktemp("materials")
    listed = {}
    for order in (4, 6):
        for h in COARSE:
            listed[f"column_{order}_{h}"] = (str(CASE), f"-fsi_order {order} -fsi_h {h} -materials_state column")
    listed |= {f"fall_{c}": (str(CASE), f"-fsi_h 0.05 -fsi_cfl {c} -materials_state fall") for c in (0.4, 0.2)}
    return {name: fsipetsc.open_run(path) for name, path in compute(1, folder, listed).items()}


@LONG
@pytest.mark.parametrize("name", ["column_4", "column_6"])
def test_a_column_under_gravity_stays_at_rest(runs, name):
    """Gas that carries a solid that carries gas ...: what is not at rest falls with the order."""
    coarse, fine = (runs[f"{name}_{h}"] for h in COARSE)
    speeds = [max(np.nanmax(np.abs(layer["u"][-1])) for layer in run.layers) for run in (coarse, fine)]
    order = int(name.split("_")[1])
    assert np.log2(speeds[0] / speeds[1]) >= LEAST_RATE[order]


@LONG
def test_all_fall_alike(runs):
    """Between walls that fall, too: u = g t, and nothing else changes; what does is the time step's, of order 4."""
    coarse, fine = (np.array([runs[f"fall_{c}"].errors[kind]["combined"] for kind in ("fluid", "solid")]) for c in (0.4, 0.2))
    assert np.all(coarse < 2e-8) and np.all(coarse > 13 * fine)
    assert np.all(runs["fall_0.2"].layers[2]["u"][-1] < -0.6)
