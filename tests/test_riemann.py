"""The exact solution of the Riemann problem of gas and elastic solid fulfils its equations."""

import numpy as np
import pytest

from fsipetsc import Solid
from fsipetsc.cases.riemann import GasState, GasWave, SolidState, SolidWave, behind_shock
from fsipetsc.cases.riemann import pressure_between as between
from fsipetsc.materials.fluid import Fluid

GAS = Fluid(0.0, 0.0, 1.4, 1.0)


def problem(left, p, u=0.0, F=1.0, m0=0.5) -> tuple[GasWave, SolidWave]:
    solid = SolidWave(Solid(4.0, 0.0, m0, 1.3), SolidState(u, -p, 0.9, F))
    return GasWave(GAS, left), solid


HIGH = GasState(1.0, 0.0, 1.0)
STRONG = behind_shock(GAS, GasState(0.125, 0.0, 0.1), 3.0)[0]
#: fan | shock, shock | shock, shock | fan, fan | fan; strained or not
PROBLEMS = {
    "sod": problem(HIGH, 0.1),
    "strong": problem(STRONG, 0.1, F=0.8),
    "back": problem(HIGH, 2.5, F=1.2),
    "apart": problem(HIGH, 1.1, u=0.6),
    "heavy": problem(HIGH, 0.1, m0=1e3),
}


def of_gas(q: GasState) -> tuple[np.ndarray, np.ndarray]:
    U = np.array([q.rho, q.rho * q.u, q.p / 0.4 + 0.5 * q.rho * q.u**2])
    return U, U * q.u + np.array([0.0 * q.u, q.p, q.p * q.u])


def of_solid(m: Solid, q: SolidState) -> tuple[np.ndarray, np.ndarray]:
    U = np.array([q.F, m.m0 * q.u, 0.5 * m.m0 * q.u**2 + m.alpha * m.m0 * q.T])
    return U, -np.array([q.u, q.sigma, q.sigma * q.u])


def total(function, *edges: float) -> np.ndarray:
    nodes, weights = np.polynomial.legendre.leggauss(40)
    pieces = zip(edges, edges[1:])
    return sum(
        0.5 * (b - a) * function(0.5 * (a + b + (b - a) * nodes)) @ weights for a, b in pieces
    )


@pytest.mark.parametrize("name", PROBLEMS)
def test_both_sides_have_one_velocity_and_pressure_and_nothing_is_lost(name):
    """Mass, momentum and energy of the gas, strain, momentum and energy of the solid: what came."""
    (in_gas, in_solid), t, far = PROBLEMS[name], 0.3, 60.0
    p = between(in_gas, in_solid)
    u = in_solid.behind(p).u
    gas, solid = in_gas.at(p, np.array([u]), 1.0), in_solid.at(p, np.array([0.0]), 1.0)
    assert abs(gas.u[0] - solid.u[0]) < 1e-12 and abs(gas.p[0] + solid.sigma[0]) < 1e-12 * max(p, 1)
    waves = [t * v for v in in_gas.speeds(p)]
    found = total(lambda x: of_gas(in_gas.at(p, x, t))[0], -far, *waves, t * u)
    U, F = of_gas(in_gas.before)
    came = t * (F - np.array([0.0, p, p * u]))
    assert np.abs(found - far * U - came).max() < 1e-11 * np.abs(far * U).max()
    front, back = in_solid.speeds(p)
    edges = 0.0, t * back, t * front, far
    found = total(lambda X: of_solid(in_solid.solid, in_solid.at(p, X, t))[0], *edges)
    U, F = of_solid(in_solid.solid, in_solid.before)
    came = t * (np.array([-u, p, p * u]) - F)
    assert np.abs(found - far * U - came).max() < 1e-11 * np.abs(far * U).max()


def test_the_gas_against_a_table():
    """Toro (2009), Tables 4.2 and 4.3, tests 1 and 5; and the shock of Mach number 3."""
    for before, p, u, rho in (
        (GasState(1.0, 0.0, 1.0), 0.30313, 0.92745, 0.42632),
        (GasState(5.99924, 19.5975, 460.894), 1691.64, 8.68975, 14.2823),
    ):
        wave = GasWave(GAS, before)
        assert wave.behind(p) == pytest.approx((rho, u, p), rel=2e-5)
    behind, s = behind_shock(GAS, GasState(1.0, 0.3, 1.0), 3.0)
    assert behind.p == pytest.approx(31 / 3, rel=1e-14)
    assert behind.rho == pytest.approx(27 / 7, rel=1e-14)
    assert behind.rho * (s - behind.u) == pytest.approx(s - 0.3, rel=1e-14)
