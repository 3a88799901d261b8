"""The treatments of an interface: they meet the conditions, change no more than they may, and
`projection` and `energy` are orthogonal projections in the symmetric variables."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from helpers import from_python

pytest.importorskip("numba")

from paper_parts import closure, operator_of
from paper_parts import primitive as primitive_of

from fsipetsc.materials.constant_transport import ConstantTransport
from fsipetsc.materials.line_solid import Elastic
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.solid_pressure import Gruneisen
from fsipetsc.operators import OPERATORS
from fsipetsc.paper.coupling import KINDS, Face, couple, multipliers, residuals
from fsipetsc.paper.laws import Gas

couple, residuals, multipliers = map(from_python, (couple, residuals, multipliers))

R, CV = 287.0, 287.0 / 0.4
P0, T0, H = 1e5, 300.0, 0.0125
SOUND = (1.4 * 287.0 * T0) ** 0.5
MU = 4 / 3 * 0.5
ALPHA, K = 1.0, 1e5

SIDES = itertools.product(OPERATORS, (1.0, -1.0))
ALL = pytest.mark.parametrize(("order", "normal"), list(SIDES), ids=lambda v: f"{v:+g}")
EVERY_KIND = pytest.mark.parametrize("kind", KINDS)
VISCOUS = pytest.mark.parametrize("mu", [MU, 0.0])
PRESSED = pytest.mark.parametrize("gruneisen", [0.0, 0.4])
#: who conducts heat: conductivities of gas and solid
CONDUCTION = {"both": (0.7, 0.5), "gas": (0.7, 0.0), "solid": (0.0, 0.5), "none": (0.0, 0.0)}
HEAT = pytest.mark.parametrize("heat", CONDUCTION)
JUMPS = 0.3, 2e3, 5.0, -40.0


def interface(normal, jump=(0, 0, 0, 0), mu=MU, heat="both", m0=2700.0, gruneisen=0.0):
    """(interface, jumps) with the rod's materials, a viscosity that counts, and changes."""
    kappa, kappa_e = CONDUCTION[heat]
    gas = Gas(PerfectGas(1.4, R), ConstantTransport(), mu, kappa, 1.4, 0.0)
    solid = Elastic(Gruneisen(gruneisen), K, kappa_e, m0, ALPHA, 0.0)
    jump = np.array(jump, float)
    if heat == "none":
        jump[3] = 0.0
    return Face(0, gas, solid, normal, H), jump


def rows(order, normal, seed=0):
    """Smooth random rows (rho, rho u, e) and (u, sigma, T, x); conditions badly violated."""
    n, rng = len(closure(order)), np.random.default_rng(seed)
    X = H * np.arange(n)

    def smooth(mean, size):
        a, b, phase = rng.uniform(-1, 1, 3)
        return mean + size * (a * np.cos(7 * X + phase) + b * np.sin(11 * X))

    rho, u, T = smooth(1.16, 0.1), smooth(0.0, 3.0), smooth(T0, 20.0)
    fluid = np.stack([rho, rho * u, rho * (CV * T + 0.5 * u**2)], axis=-1)
    x = 1.0 - normal * X * (1 + 0.1 * rng.uniform(-1, 1) + 0.5 * X)
    return fluid, np.stack([smooth(0.0, 3.0), smooth(-P0, 1e4), smooth(T0, 20.0), x], axis=-1)


def treated(kind, of, order, fluid, solid):
    """Treated copies."""
    fluid, solid = fluid.copy(), solid.copy()
    couple(operator_of(order), of[0]._replace(kind=KINDS[kind]), of[1], fluid, solid)
    return fluid, solid


def derivative(of, order):
    """d_j of the gas's closure row at the interface."""
    return of[0].n / H * closure(order)


def scaled_residuals(of, order, fluid, solid):
    """Of the four conditions, over sound speed, pressure, temperature and largest heat flux."""
    out = np.zeros(4)
    residuals(operator_of(order), *of, fluid, solid, out)
    conductivity = max(of[0].gas.kappa, of[0].solid.kappa_e, 1e-300)
    return np.abs(out) / [SOUND, P0, T0, conductivity * np.abs(derivative(of, order)).sum() * T0]


@ALL
@EVERY_KIND
@HEAT
@VISCOUS
@PRESSED
def test_the_conditions_hold_to_round_off_and_a_second_time_changes_nothing(
    order, normal, kind, heat, mu, gruneisen
):
    of = interface(normal, JUMPS, mu, heat, gruneisen=gruneisen)
    before = rows(order, normal)
    assert np.all(scaled_residuals(of, order, *before)[:2] > 1e-4)
    once = treated(kind, of, order, *before)
    left = scaled_residuals(of, order, *once)
    assert np.all(left[[True, True, heat == "both", heat != "none"]] < 4e-15), left
    for first, second in zip(once, treated(kind, of, order, *once), strict=True):
        assert np.all(np.abs(second - first) <= 1e-12 * np.abs(first).max(axis=0))
    assert np.array_equal(once[0][1:, 0], before[0][1:, 0]), "densities beyond the interface stay"
    assert np.array_equal(once[1][:, 3], before[1][:, 3]), "so do positions"


@EVERY_KIND
@pytest.mark.parametrize("order", OPERATORS)
def test_both_orientations_are_mirror_images(kind, order):
    right = rows(order, 1.0)
    left = (right[0] * [1, -1, 1], right[1] * [-1, 1, 1, -1])
    fluid, solid = treated(kind, interface(1.0), order, *right)
    mirrored_fluid, mirrored_solid = treated(kind, interface(-1.0), order, *left)
    np.testing.assert_allclose(mirrored_fluid * [1, -1, 1], fluid, rtol=1e-12)
    np.testing.assert_allclose(mirrored_solid * [-1, 1, 1, -1], solid, rtol=1e-12)


def assert_orthogonal(change, weights, conditions):
    """The change has no part in what the conditions leave free, in the norm of the weights."""
    root = np.sqrt(weights)
    scaled = conditions / root
    free = np.linalg.svd(scaled / np.linalg.norm(scaled, axis=1)[:, None])[2][len(scaled) :]
    assert np.linalg.norm(free @ (root * change)) < 1e-11 * np.linalg.norm(root * change)
    assert np.linalg.norm(root * change) > 1.0


@ALL
@VISCOUS
@PRESSED
def test_projection_is_orthogonal(order, normal, mu, gruneisen):
    """With the temperatures given, (u_s, sigma, p, u_j) changes in the norm

        a_0 (m0 du_s^2 + dsigma^2 / K + dp^2 / p^) + sum_j a_j rho^ du_j^2

    at a right angle to all changes that keep u_s - u_0 and sigma + p - mu' sum_j d_j u_j.
    """
    of = interface(normal, JUMPS, mu, gruneisen=gruneisen)
    fluid, solid = rows(order, normal)
    new_fluid, new_solid = treated("projection", of, order, fluid, solid)
    rho, u, T = primitive_of(of[0].gas, fluid)
    new_rho, new_u, new_T = primitive_of(of[0].gas, new_fluid)
    d, n = derivative(of, order), len(u)
    a = np.array([*map(float, OPERATORS[order].norm), 1.0])[:n]
    rho_hat, p_hat = rho[1], R * rho[1] * T[1]
    p_change = R * new_T[0] * (new_rho[0] - rho[0])
    change = np.array([*(new_solid[0, :2] - solid[0, :2]), p_change, *(new_u - u)])
    solid_weights = a[0] * np.array([of[0].solid.m0, 1 / K, 1 / p_hat])
    conditions = np.zeros((2, n + 3))
    conditions[0, [0, 3]] = 1.0, -1.0
    conditions[1, :3], conditions[1, 3:] = (0.0, 1.0, 1.0), -mu * d
    assert_orthogonal(change, np.array([*solid_weights, *(a * rho_hat)]), conditions)
    np.testing.assert_allclose(new_T[1:], T[1:], rtol=1e-14)
    assert np.array_equal(new_solid[1:], solid[1:])


@ALL
@HEAT
@VISCOUS
@PRESSED
def test_energy_is_orthogonal(order, normal, heat, mu, gruneisen):
    """The change of q = (u_s, sigma, rho_0; T_s, u_f, T_f) in the norm of the symmetric variables.

    The change of rho_0 that counts is that of the linearised pressure, R T^ drho + R rho^ dT.
    """
    of = interface(normal, JUMPS, mu, heat, gruneisen=gruneisen)
    kappa, kappa_e = CONDUCTION[heat]
    fluid, solid = rows(order, normal)
    new_fluid, new_solid = treated("energy", of, order, fluid, solid)
    rho, u, T = primitive_of(of[0].gas, fluid)
    new_rho, new_u, new_T = primitive_of(of[0].gas, new_fluid)
    d, n, m0 = derivative(of, order), len(u), of[0].solid.m0
    a = np.array([*map(float, OPERATORS[order].norm), 1.0])[:n]
    rho_hat, T_hat, x_X = rho[1], T[1], -d @ solid[:, 3]
    c = gruneisen * m0 * ALPHA / x_X
    modulus = (K + c * solid[0, 2]) / x_X
    pressure = R * (new_rho[0] * new_T[0] - rho[0] * T[0])
    linear_rho = (pressure - R * rho_hat * (new_T[0] - T[0])) / (R * T_hat)
    first = [*(new_solid[0, :2] - solid[0, :2]), linear_rho]
    change = np.concatenate([first, new_solid[:, 2] - solid[:, 2], new_u - u, new_T - T])
    at_interface = a[0] * np.array([m0, 1 / modulus, R * T_hat / rho_hat])
    weights = ALPHA * m0 / T_hat, rho_hat, rho_hat * CV / T_hat
    weights = np.concatenate([at_interface, *(a * weight for weight in weights)])
    conditions = np.zeros((4, 3 + 3 * n))
    Ts, uf, Tf = 3, 3 + n, 3 + 2 * n  # where they begin
    conditions[0, [0, uf]] = 1.0, -1.0
    conditions[1, [1, 2, Ts, Tf]] = 1.0, R * T_hat, -c, R * rho_hat
    conditions[1, uf : uf + n] -= mu * d
    conditions[2, [Ts, Tf]] = 1.0, -1.0
    conditions[3, Ts:uf], conditions[3, Tf:] = -kappa_e / x_X * d, -kappa * d
    assert_orthogonal(change, weights, conditions[[True, True, heat == "both", heat != "none"]])
    assert np.array_equal(new_solid[1:, :2], solid[1:, :2])


@ALL
def test_without_viscosity_velocity_and_stress_are_weighted_means(order, normal):
    """(4.17): the velocities weighted with the masses; the stress with the moduli."""
    of = interface(normal, mu=0.0, gruneisen=0.4)
    fluid, solid = rows(order, normal)
    new_fluid, new_solid = treated("projection", of, order, fluid, solid)
    rho, u, T = primitive_of(of[0].gas, fluid)
    new_rho, new_u, new_T = primitive_of(of[0].gas, new_fluid)
    m0, rho_hat = of[0].solid.m0, rho[1]
    mean = (m0 * solid[0, 0] + rho_hat * u[0]) / (m0 + rho_hat)
    np.testing.assert_allclose([new_solid[0, 0], new_u[0]], mean, rtol=1e-13)
    p_hat, x_X = R * rho_hat * T[1], -derivative(of, order) @ solid[:, 3]
    p_solid = 0.4 * m0 * ALPHA * new_solid[0, 2] / x_X
    traction = p_hat * (solid[0, 1] - p_solid) - K * R * rho[0] * new_T[0]
    traction /= p_hat + K
    np.testing.assert_allclose(new_solid[0, 1] - p_solid, traction, rtol=1e-13)
    np.testing.assert_allclose(-R * new_rho[0] * new_T[0], traction, rtol=1e-13)


@ALL
def test_traditional_takes_velocity_from_the_solid_and_load_from_the_gas(order, normal):
    of = interface(normal, gruneisen=0.4)
    fluid, solid = rows(order, normal)
    new_fluid, new_solid = treated("traditional", of, order, fluid, solid)
    _, new_u, new_T = primitive_of(of[0].gas, new_fluid)
    d = derivative(of, order)
    assert new_solid[0, 0] == solid[0, 0] and new_fluid[0, 0] == fluid[0, 0]
    np.testing.assert_allclose(new_u[0], solid[0, 0], rtol=1e-14)
    load = -R * fluid[0, 0] * new_T[0] + MU * (d @ new_u)
    p_solid = 0.4 * of[0].solid.m0 * ALPHA * new_solid[0, 2] / (-d @ solid[:, 3])
    np.testing.assert_allclose(new_solid[0, 1], load + p_solid, rtol=1e-13, atol=1e-10 * P0)
    assert np.array_equal(new_solid[1:], solid[1:]) and np.array_equal(new_fluid[1:], fluid[1:])


def test_multipliers_solve_their_system():
    rng = np.random.default_rng(0)
    for _ in range(20):
        conditions = rng.normal(size=(4, 9)) * 10.0 ** rng.uniform(-6, 6, (4, 1))  # in any units
        S = conditions @ conditions.T
        S[0, 2:] = S[2:, 0] = 0.0
        S[0, 0] *= 4.0  # stays positive definite
        r = conditions @ rng.normal(size=9)
        found = multipliers(S[0, 0], S[0, 1], *S[1, 1:], *S[2, 2:], S[3, 3], *r)
        size = np.sqrt(np.diag(S))
        wanted = np.linalg.solve(S / np.outer(size, size), r / size)
        np.testing.assert_allclose(found * size, wanted, rtol=1e-8)
