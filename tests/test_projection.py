"""The interface projection: it meets the conditions, is a projection, and an orthogonal one in the symmetric variables."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from helpers import from_python

pytest.importorskip("numba")

from paper_parts import closure, operator_of
from paper_parts import primitive as primitive_of

from fsipetsc.materials.constant_transport import ConstantTransport
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.solid_pressure import Gruneisen
from fsipetsc.operators import OPERATORS
from fsipetsc.paper.coupling import KINDS, Face, couple, residuals
from fsipetsc.paper.laws import Elastic, Gas

couple, residuals = from_python(couple), from_python(residuals)

R, CV = 287.0, 287.0 / 0.4
P0, T0, H = 1e5, 300.0, 0.0125
SOUND = (1.4 * 287.0 * T0) ** 0.5
MU = 4 / 3 * 0.5

ALL = pytest.mark.parametrize(
    ("order", "normal"), list(itertools.product(OPERATORS, (1.0, -1.0))), ids=lambda v: f"{v:+g}"
)


def interface(
    normal: float,
    jump: tuple[float, ...] = (0, 0, 0, 0),
    mu: float = MU,
    kappa: float = 0.7,
    kappa_e: float = 0.5,
    m0: float = 2700.0,
    gruneisen: float = 0.0,
) -> tuple[Face, np.ndarray]:
    """(interface, jumps) with the rod's materials, a viscosity that counts, and changes."""
    gas = Gas(PerfectGas(1.4, R), ConstantTransport(), mu, kappa, 1.4, 0.0)
    solid = Elastic(Gruneisen(gruneisen), 1e5, kappa_e, m0, 1.0, 0.0)
    return Face(0, gas, solid, normal, H), np.array(jump, float)


def traces(order: int, normal: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Smooth random rows (rho, rho u, e) and (u, sigma, T, x), j = 0 at the interface; conditions badly violated."""
    n = len(closure(order))
    rng = np.random.default_rng(seed)
    X = H * np.arange(n)

    def smooth(mean: float, size: float) -> np.ndarray:
        a, b, phase = rng.uniform(-1, 1, 3)
        return mean + size * (a * np.cos(7 * X + phase) + b * np.sin(11 * X))

    rho, u, T = smooth(1.16, 0.1), smooth(0.0, 3.0), smooth(T0, 20.0)
    fluid = np.stack([rho, rho * u, rho * (CV * T + 0.5 * u**2)], axis=-1)
    x = 1.0 - normal * X * (1 + 0.1 * rng.uniform(-1, 1) + 0.5 * X)
    return fluid, np.stack([smooth(0.0, 3.0), smooth(-P0, 1e4), smooth(T0, 20.0), x], axis=-1)


def treated(kind: str, face: tuple[Face, np.ndarray], order: int, fluid: np.ndarray, solid: np.ndarray):
    """Treated copies."""
    fluid, solid = fluid.copy(), solid.copy()
    couple(operator_of(order), face[0]._replace(kind=KINDS[kind]), face[1], fluid, solid)
    return fluid, solid


def apply(face, order: int, fluid: np.ndarray, solid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Projected copies."""
    return treated("projection", face, order, fluid, solid)


def primitive(face, fluid: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """rho, u, T of conserved rows."""
    return primitive_of(face[0].gas, fluid)


def derivative_weights(face, order: int) -> np.ndarray:
    """d_j of the fluid's closure row at the interface."""
    return face[0].n / H * closure(order)


def scaled_residuals(face, order: int, fluid: np.ndarray, solid: np.ndarray) -> np.ndarray:
    """Residuals of the four conditions over the sound speed, the pressure, the temperature and the largest heat flux."""
    out = np.zeros(4)
    residuals(operator_of(order), *face, fluid, solid, out)
    slope = np.abs(derivative_weights(face, order)).sum()
    conductivity = max(face[0].gas.kappa, face[0].solid.kappa_e)
    return np.abs(out) / [SOUND, P0, T0, max(conductivity, 1e-300) * slope * T0]


CONDUCTION = {"both": (0.7, 0.5), "fluid only": (0.7, 0.0), "solid only": (0.0, 0.5), "none": (0.0, 0.0)}
JUMP = {"no jump": (0.0, 0.0, 0.0, 0.0), "jumps": (0.3, 2e3, 5.0, -40.0)}


@ALL
@pytest.mark.parametrize("conduction", CONDUCTION)
@pytest.mark.parametrize("jump", JUMP)
@pytest.mark.parametrize("mu", [MU, 0.0])
@pytest.mark.parametrize("gruneisen", [0.0, 0.4])
def test_the_conditions_hold_to_round_off(order, normal, conduction, jump, mu, gruneisen):
    kappa, kappa_e = CONDUCTION[conduction]
    values = JUMP[jump] if conduction != "none" else (*JUMP[jump][:3], 0.0)
    face = interface(normal, values, mu=mu, kappa=kappa, kappa_e=kappa_e, gruneisen=gruneisen)
    for seed in range(3):
        fluid, solid = traces(order, normal, seed)
        before = scaled_residuals(face, order, fluid, solid)
        fluid, solid = apply(face, order, fluid, solid)
        left = scaled_residuals(face, order, fluid, solid)
        imposed = [True, True, conduction == "both", conduction != "none"]
        assert np.all(before[:2] > 1e-4)
        assert np.all(left[imposed] < 2e-15), left


@ALL
@pytest.mark.parametrize("conduction", CONDUCTION)
def test_projecting_twice_changes_nothing_more(order, normal, conduction):
    kappa, kappa_e = CONDUCTION[conduction]
    face = interface(normal, (0.3, 2e3, 5.0, 0.0), kappa=kappa, kappa_e=kappa_e, gruneisen=0.4)
    once = apply(face, order, *traces(order, normal))
    twice = apply(face, order, *once)
    for first, second in zip(once, twice, strict=True):
        assert np.all(np.abs(second - first) <= 1e-13 * np.abs(first).max(axis=0))


@ALL
@pytest.mark.parametrize("mu", [MU, 0.0])
@pytest.mark.parametrize("gruneisen", [0.0, 0.4])
def test_the_change_is_orthogonal_to_what_the_conditions_leave_free(order, normal, mu, gruneisen):
    """With the temperatures given, (u_s, sigma, u_j, p) changes in the norm of the symmetric variables,

        a_0 (m0 du_s^2 + dsigma^2 / K) + sum_j a_j rho^ du_j^2 + a_0 dp^2 / p^,

    at a right angle to all changes that keep u_s - u_0 and sigma + p - mu' sum_j d_j u_j.
    """
    face = interface(normal, JUMP["jumps"], mu=mu, gruneisen=gruneisen)
    fluid, solid = traces(order, normal)
    new_fluid, new_solid = apply(face, order, fluid, solid)
    (rho, u, T), (new_rho, new_u, new_T) = primitive(face, fluid), primitive(face, new_fluid)
    d, n = derivative_weights(face, order), len(u)
    a = np.array([*map(float, OPERATORS[order].norm), 1.0])[:n]
    rho_hat, p_hat = rho[1], R * rho[1] * T[1]

    p_change = R * new_T[0] * (new_rho[0] - rho[0])  # at the new temperature
    change = np.array([new_solid[0, 0] - solid[0, 0], new_solid[0, 1] - solid[0, 1], p_change, *(new_u - u)])
    weights = np.array([a[0] * face[0].solid.m0, a[0] / face[0].solid.K, a[0] / p_hat, *(a * rho_hat)])
    conditions = np.zeros((2, n + 3))
    conditions[0, 0], conditions[0, 3] = 1.0, -1.0
    conditions[1, 1], conditions[1, 2], conditions[1, 3:] = 1.0, 1.0, -mu * d
    # in variables scaled by the norm: the change has no part in the null space of the conditions
    root = np.sqrt(weights)
    scaled = conditions / root
    free = np.linalg.svd(scaled)[2][2:]
    assert np.linalg.norm(free @ (root * change)) < 1e-12 * np.linalg.norm(root * change)
    assert np.linalg.norm(root * change) > 1.0


@ALL
def test_only_what_may_change_changes(order, normal):
    face = interface(normal, JUMP["jumps"])
    fluid, solid = traces(order, normal)
    new_fluid, new_solid = apply(face, order, fluid, solid)
    (rho, _, T), (new_rho, _, new_T) = primitive(face, fluid), primitive(face, new_fluid)
    assert np.array_equal(new_rho[1:], rho[1:])
    np.testing.assert_allclose(new_T[1:], T[1:], rtol=1e-14)
    assert np.array_equal(new_solid[1:], solid[1:])
    assert np.array_equal(new_solid[:, 3], solid[:, 3])


@ALL
def test_without_viscosity_velocity_and_stress_are_weighted_means(order, normal):
    """(4.17): the velocities weighted with the masses; the stress with the moduli."""
    face = interface(normal, mu=0.0, gruneisen=0.4)
    fluid, solid = traces(order, normal)
    new_fluid, new_solid = apply(face, order, fluid, solid)
    (rho, u, T), (new_rho, new_u, new_T) = primitive(face, fluid), primitive(face, new_fluid)
    m0, rho_hat = face[0].solid.m0, rho[1]
    mean = (m0 * solid[0, 0] + rho_hat * u[0]) / (m0 + rho_hat)
    np.testing.assert_allclose([new_solid[0, 0], new_u[0]], mean, rtol=1e-13)
    np.testing.assert_allclose(new_u[1:], u[1:], rtol=1e-14, atol=1e-14)

    K, p_hat = face[0].solid.K, R * rho_hat * T[1]
    x_X = -derivative_weights(face, order) @ solid[:, 3]
    p_solid = face[0].solid.law.G * m0 * face[0].solid.alpha * new_solid[0, 2] / x_X
    p_before = R * rho[0] * new_T[0]
    traction = (p_hat * (solid[0, 1] - p_solid) - K * p_before) / (p_hat + K)
    np.testing.assert_allclose(new_solid[0, 1] - p_solid, traction, rtol=1e-13)
    np.testing.assert_allclose(-R * new_rho[0] * new_T[0], traction, rtol=1e-13)


@pytest.mark.parametrize("order", OPERATORS)
def test_both_orientations_are_mirror_images(order):
    right = traces(order, 1.0)
    left = (right[0] * [1, -1, 1], right[1] * [-1, 1, 1, -1])
    fluid, solid = apply(interface(1.0), order, *right)
    mirrored_fluid, mirrored_solid = apply(interface(-1.0), order, *left)
    np.testing.assert_allclose(mirrored_fluid * [1, -1, 1], fluid, rtol=1e-13)
    np.testing.assert_allclose(mirrored_solid * [-1, 1, 1, -1], solid, rtol=1e-13)


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e3])
def test_the_lighter_side_gives_way(ratio):
    """The solid takes the share rho^ / (m0 + rho^) of the velocity difference: no stiff step at any density ratio."""
    fluid, solid = traces(4, 1.0)
    rho_hat = fluid[1, 0]
    face = interface(1.0, mu=0.0, m0=ratio * rho_hat)
    _, new_solid = apply(face, 4, fluid, solid)
    difference = fluid[0, 1] / fluid[0, 0] - solid[0, 0]
    np.testing.assert_allclose(new_solid[0, 0] - solid[0, 0], difference / (1 + ratio), rtol=1e-12)
