"""What the sensor of shocks sees, by its formulas: gas_dissipation.py, solid_dissipation.py."""

from types import SimpleNamespace

import numpy as np
import pytest

from fsipetsc.blockrun.notes import MOST, steepest
from fsipetsc.equations.gas import Gas
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.scheme.gas_dissipation import NO_SHOCK, RISE, GasWaves
from fsipetsc.scheme.solid_dissipation import SolidWaves

AIR, WATER = PerfectGas(1.4, 287.0), stiffened_gas(4.4, 1000.0, 6e8)
CERTAIN = NO_SHOCK + 1.0 / RISE


def steepness(law, rho, u, p, a):
    """Of all nodes but the ends of a line. u: (d, n), a: (d, n)."""
    d, n = np.shape(u)
    gas = Gas(law, None, 0.0, 0.0, (0.0,) * d)
    state = np.array([rho, p, law.temperature_of(rho, p), *u])
    waves = GasWaves(gas, state, np.array(a), 0)
    return np.array([waves.steepness(i, 1) for i in range(1, n - 1)])


def steepness_of_solid(v):
    """The same of a solid that moves with v (d, n), c = 1."""
    d, n = v.shape
    waves = SolidWaves(d, np.concatenate([0.0 * v, v, 0.0 * v[:1]]).T, 0.02)
    return np.array([waves.steepness(i, 1) for i in range(1, n - 1)])


def sound(law, rho, p, size, cells):
    """(rho, u, p) of waves of so many cells to the right, Delta p = size."""
    change = size * np.sin(2.0 * np.pi * np.arange(2 * cells) / cells)
    c = np.sqrt(law.sound_speed_squared(rho, law.temperature_of(rho, p)))
    return rho + change / c**2, change[None] / (rho * c), p + change


@pytest.mark.parametrize("d", [2, 3])
def test_it_does_not_depend_on_axes(d):
    rng = np.random.default_rng(d)
    turn, _ = np.linalg.qr(rng.standard_normal((d, d)))
    u, a = 300.0 * rng.standard_normal((d, 9)), 0.1 * rng.standard_normal((d, 9))
    rho, p = rng.uniform(1.0, 1.01, 9), rng.uniform(1e5, 1.01e5, 9)
    seen = steepness(AIR, rho, u, p, a)
    np.testing.assert_allclose(steepness(AIR, rho, turn @ u, p, turn @ a), seen, rtol=1e-13)
    seen = steepness_of_solid(1e-2 * u / 300.0)
    assert seen.min() > 0.0
    np.testing.assert_allclose(steepness_of_solid(1e-2 * turn @ u / 300.0), seen, rtol=1e-13)


@pytest.mark.parametrize("law", [AIR, WATER])
def test_jumps_of_each_are_shocks(law):
    """Of density, pressure, velocity through areas; not where it rises, nor along them."""
    step, one = np.where(np.arange(6) < 3, 0.0, 1.0), np.ones(6)
    rho, p, c = (1.2, 1e5, 340.0) if law is AIR else (1000.0, 1e5, 1625.0)
    a, still = np.array([one, 0.0 * one]), np.zeros((2, 6))
    size = p if law is AIR else 6e8
    for state in (
        (rho * (1.0 + step), still, p * one),
        (rho * one, still, p + size * step),
        (rho * one, np.array([-2.0 * c * step, 0.0 * one]), p * one),
    ):
        assert steepness(law, *state, a)[1:3].max() > CERTAIN - 0.01
    for calm in ([c * step, 0.0 * one], [0.0 * one, c * step]):
        assert steepness(law, rho * one, np.array(calm), p * one, a).max() == 0.0


def test_sound_is_no_shock():
    """160 dB in air with 16 cells, in water with 8, a fifth of the pressure with 48."""
    for law, rho, p, size, cells in (
        (AIR, 1.2, 1e5, 2e3, 16),
        (WATER, 1000.0, 1e5, 1e6, 8),
        (AIR, 1.2, 1e5, 2e4, 48),
    ):
        rho, u, p = sound(law, rho, p, size, cells)
        assert steepness(law, rho, u, p, np.ones((1, p.size))).max() < NO_SHOCK


def test_a_burst_in_water_needs_no_capturing():
    """The note at the end looks at p + p_inf. A burst of 1e6 Pa is nothing there, one of 2e8 is."""
    patch = SimpleNamespace(ghosted=(3, 1, 1))
    part = SimpleNamespace(
        owned=np.arange(3), block=SimpleNamespace(dimension=1), part=SimpleNamespace(patch=patch)
    )
    for burst, noted in ((1e6, False), (2e8, True)):
        p = np.array([1e5, 1e5, burst])
        K = WATER.bulk_modulus(1000.0, WATER.temperature_of(1000.0, p))
        assert (steepest(part, p, K).max() > MOST[0]) == noted
