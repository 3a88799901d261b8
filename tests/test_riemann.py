"""The exact solution of the Riemann problem of a gas and an elastic solid, held against its equations and tables."""

from __future__ import annotations

import numpy as np
import pytest

from fsipetsc.cases.riemann import GasState, GasWave, Riemann, SolidState, behind_shock
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.own import pressure_law

GAS = Fluid(0.0, 0.0, 1.4, 1.0)


def problem(left: GasState, p: float, gruneisen: float = 0.0, u: float = 0.0, F: float = 1.0, m0: float = 0.5) -> Riemann:
    """A gas before a solid under the pressure p."""
    solid = Solid(4.0, 0.0, m0, 1.3, gruneisen=gruneisen)
    return Riemann(GAS, solid, left, SolidState(u, float(solid.pressure(0.9, F)) - p, 0.9, F))


HIGH = GasState(1.0, 0.0, 1.0)
STRONG = behind_shock(GAS, GasState(0.125, 0.0, 0.1), 3.0)[0]
#: fan | shock, shock | shock, shock | fan, fan | fan; with and without a pressure, strained or not
PROBLEMS = {
    "sod": problem(HIGH, 0.1),
    "sod, pressure": problem(HIGH, 0.1, 0.5),
    "strong": problem(STRONG, 0.1),
    "strong, pressure": problem(STRONG, 0.1, 0.5, F=0.8),
    "very strong, pressure": problem(GasState(10.0, 100.0, 1e3), 0.1, 0.7),
    "back": problem(HIGH, 2.5, F=1.2),
    "back, pressure": problem(HIGH, 2.5, 0.5),
    "apart": problem(HIGH, 1.1, u=0.6),
    "apart, pressure": problem(GasState(1.0, -0.5, 1.0), 1.1, 0.3, u=0.3, F=0.7),
    "heavy": problem(HIGH, 0.1, m0=1e3),
    "nothing": problem(HIGH, 1.0),
}
WAVES = {name: (r.p > r.left.p, r.right.F > r.F) for name, r in PROBLEMS.items() if name != "nothing"}


def test_the_problems_have_all_kinds_of_waves():
    assert set(WAVES.values()) == {(False, True), (True, True), (True, False), (False, False)}


@pytest.mark.parametrize("name", PROBLEMS)
def test_both_sides_have_one_velocity_and_pressure(name):
    r = PROBLEMS[name]
    scale = abs(r.u) + 1.0  # 1e-13 of it is reached, but for a solid that is pressed nearly as far as it goes
    gas, (solid, _) = r.in_gas(np.array([r.u]), 1.0), r.in_solid(np.array([0.0]), 1.0)
    assert abs(r.gas_wave.velocity(r.p) - r.u) < 1e-12 * scale
    assert abs(gas.u[0] - solid.u[0]) < 1e-12 * scale
    stress = solid.sigma - r.solid.pressure(solid.T, solid.F)
    assert abs(gas.p[0] + stress[0]) < 1e-12 * max(r.p, 1.0)


@pytest.mark.parametrize("name", [name for name, (gas, _) in WAVES.items() if gas])
def test_jumps_of_a_shock_in_the_gas(name):
    """Mass, momentum and energy through it; and it is slower than sound behind it, faster than sound before it."""
    r = PROBLEMS[name]
    s = r.gas_wave.speeds(r.p)[0]
    states = r.left, GasState(*(float(v) for v in r.in_gas(np.array(0.5 * (s + r.u)), 1.0)))
    flux = [np.array([rho * (u - s), rho * u * (u - s) + p, e * (u - s) + p * u]) for rho, u, p, e in map(_with_energy, states)]
    assert np.abs(flux[1] - flux[0]).max() < 1e-12 * np.abs(flux[0]).max()
    sound = [np.sqrt(1.4 * p / rho) for rho, _, p in states]
    assert states[1].u - sound[1] < s < states[0].u - sound[0]


def _with_energy(state: GasState) -> tuple[float, ...]:
    return *state, state.p / 0.4 + 0.5 * state.rho * state.u**2


@pytest.mark.parametrize("name", [name for name, (_, solid) in WAVES.items() if solid])
def test_jumps_of_a_shock_in_the_solid(name):
    """Strain, momentum and energy through it; sigma follows the strain; and it is of the kind that lasts."""
    r = PROBLEMS[name]
    s = r.solid_wave.speeds(r.F)[0]
    states = [SolidState(*(float(v) for v in r.in_solid(np.array(f * s), 1.0)[0])) for f in (0.5, 1.5)]
    jump = np.diff([_conserved(r.solid, state) for state in states], axis=0)[0]
    flux = np.diff([_flux(r.solid, state) for state in states], axis=0)[0]
    assert np.abs(s * jump - flux).max() < 1e-12 * max(np.abs(s * jump).max(), 1.0)
    assert states[0].sigma - states[1].sigma == pytest.approx(r.solid.K * np.log(states[0].F / states[1].F), rel=1e-13)
    behind, before = (r.solid.sound_speed(v.F, v.T, v.sigma) for v in states)
    assert before < s < behind


def _conserved(solid: Solid, q: SolidState) -> np.ndarray:
    return np.array([q.F, solid.m0 * q.u, 0.5 * solid.m0 * q.u**2 + solid.alpha * solid.m0 * q.T])


def _flux(solid: Solid, q: SolidState) -> np.ndarray:
    stress = q.sigma - solid.pressure(q.T, q.F)
    return np.array([-q.u, -stress, -stress * q.u])


@pytest.mark.parametrize("name", PROBLEMS)
def test_nothing_is_lost(name):
    """Mass, momentum and energy of gas, strain, momentum and energy of the solid, in pieces of which each wave is one."""
    r, t, far = PROBLEMS[name], 0.3, 60.0
    p, u = r.p, r.u
    edges = [-far, *(t * v for v in r.gas_wave.speeds(p)), t * u]
    gas = sum(_integral(lambda x: _conserved_gas(r.in_gas(x, t)), a, b) for a, b in zip(edges, edges[1:], strict=False))
    rho0, u0, p0 = r.left
    e0 = p0 / 0.4 + 0.5 * rho0 * u0**2
    came = np.array([rho0 * u0, rho0 * u0**2 + p0 - p, (e0 + p0) * u0 - p * u])
    expected = far * np.array([rho0, rho0 * u0, e0]) + t * came
    assert np.abs(gas - expected).max() < 1e-11 * np.abs(far * np.array([rho0, rho0 * u0, e0])).max()

    front, back = r.solid_wave.speeds(r.F)
    edges = [0.0, t * back, t * front, far]
    solid = sum(
        _integral(lambda X: _conserved(r.solid, r.in_solid(X, t)[0]), a, b) for a, b in zip(edges, edges[1:], strict=False)
    )
    before = far * _conserved(r.solid, r.right)
    expected = before + t * (np.array([-u, p, p * u]) - _flux(r.solid, r.right))
    assert np.abs(solid - expected).max() < 1e-11 * np.abs(before).max()


def _conserved_gas(state: GasState) -> np.ndarray:
    return np.array([state.rho, state.rho * state.u, state.p / 0.4 + 0.5 * state.rho * state.u**2])


def _integral(function, a: float, b: float) -> np.ndarray:
    nodes, weights = np.polynomial.legendre.leggauss(40)
    return 0.5 * (b - a) * (function(0.5 * (a + b) + 0.5 * (b - a) * nodes) @ weights) if b > a else 0.0


@pytest.mark.parametrize("name", [name for name, (gas, solid) in WAVES.items() if not (gas and solid)])
def test_fans_satisfy_the_equations(name):
    """Of unit x/t: -xi q' + A q' = 0, by differences; entropy and sigma - K ln F stay."""
    r, d = PROBLEMS[name], 1e-5
    gas_shock, solid_shock = WAVES[name]
    if not gas_shock:
        front, back = r.gas_wave.speeds(r.p)
        xi = np.linspace(front, back, 7)[1:-1]
        left, middle, right = (r.in_gas(xi + k * d, 1.0) for k in (-1, 0, 1))
        slope = [(b - a) / (2 * d) for a, b in zip(left, right, strict=True)]
        relative = middle.u - xi
        assert np.allclose(relative * slope[0] + middle.rho * slope[1], 0, atol=1e-8)
        assert np.allclose(relative * slope[1] + slope[2] / middle.rho, 0, atol=1e-8)
        assert middle.p / middle.rho**1.4 == pytest.approx(r.left.p / r.left.rho**1.4, rel=1e-13)
    if not solid_shock:
        front, back = r.solid_wave.speeds(r.F)
        xi = np.linspace(back, front, 7)[1:-1]
        (a, _), (q, _), (b, _) = (r.in_solid(xi + k * d, 1.0) for k in (-1, 0, 1))
        stress = [v.sigma - r.solid.pressure(v.T, v.F) for v in (a, q, b)]
        per_xi = [(y - x) / (2 * d) for x, y in zip((*a, stress[0]), (*b, stress[2]), strict=True)]
        u_X, T_X, F_X, P_X = per_xi[0], per_xi[2], per_xi[3], per_xi[4]
        assert np.allclose(-xi * F_X, u_X, atol=1e-7)
        assert np.allclose(-xi * r.solid.m0 * u_X, P_X, atol=1e-7)
        assert np.allclose(-xi * r.solid.alpha * r.solid.m0 * T_X, stress[1] * u_X, atol=1e-7)
        assert q.sigma - r.right.sigma == pytest.approx(r.solid.K * np.log(q.F / r.right.F), rel=1e-13)


@pytest.mark.parametrize("name", PROBLEMS)
def test_where_the_material_points_are(name):
    """x_t = u and x_X = F, continuous at the fronts."""
    r, t = PROBLEMS[name], 0.3
    front, back = r.solid_wave.speeds(r.F)
    X = np.linspace(0, 1.5 * front * t, 6) + 1e-3
    d = 1e-6
    state, _ = r.in_solid(X, t)
    assert np.allclose((r.in_solid(X, t + d)[1] - r.in_solid(X, t - d)[1]) / (2 * d), state.u, atol=1e-7)
    assert np.allclose((r.in_solid(X + d, t)[1] - r.in_solid(X - d, t)[1]) / (2 * d), state.F, atol=1e-7)
    for speed in (front, back):
        near = r.in_solid(np.array([speed * t * (1 - 1e-14), speed * t * (1 + 1e-14)]), t)[1]
        assert abs(near[1] - near[0]) < 1e-12 * max(1.0, speed)


def test_the_gas_against_a_table():
    """Toro (2009), Table 4.2 and 4.3, tests 1 and 5: behind the left fan, the left shock; and the shock of Mach number 3."""
    for before, p, u, rho in (
        (GasState(1.0, 0.0, 1.0), 0.30313, 0.92745, 0.42632),
        (GasState(5.99924, 19.5975, 460.894), 1691.64, 8.68975, 14.2823),
    ):
        wave = GasWave(GAS, before)
        assert wave.velocity(p) == pytest.approx(u, rel=2e-5)
        assert wave.behind(p).rho == pytest.approx(rho, rel=2e-5)
    behind, s = behind_shock(GAS, GasState(1.0, 0.3, 1.0), 3.0)
    assert behind.p == pytest.approx(31 / 3, rel=1e-14) and behind.rho == pytest.approx(27 / 7, rel=1e-14)
    assert behind.rho * (s - behind.u) == pytest.approx(s - 0.3, rel=1e-14)


def test_weak_waves_are_sound():
    """What a small jump does is said by the impedances Z of the two sides."""
    r = problem(GasState(1.0, 0.0, 1.0 + 1e-6), 1.0)
    Z_gas, Z_solid = np.sqrt(1.4), np.sqrt(4.0 * 0.5)
    assert r.u == pytest.approx(1e-6 / (Z_gas + Z_solid), rel=2e-6)
    assert r.p - 1.0 == pytest.approx(1e-6 * Z_solid / (Z_gas + Z_solid), rel=2e-6)


def test_what_has_no_solution():
    with pytest.raises(InputError, match="part"):
        problem(GasState(1.0, -100.0, 1.0), 1.0).F  # noqa: B018
    with pytest.raises(InputError, match="above 0"):
        problem(GasState(0.0, 0.0, 1.0), 1.0)
    zero = pressure_law(lambda J, T, m0, alpha: 0.0 * T)
    with pytest.raises(InputError, match="Grüneisen"):
        Riemann(GAS, Solid(1.0, 0.0, 1.0, 1.0, pressing=zero), HIGH, SolidState(0.0, -1.0, 1.0, 1.0))
