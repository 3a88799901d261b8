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
