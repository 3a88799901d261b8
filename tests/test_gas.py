"""Laws of gases as formulas, and the logarithm; fluxes: test_block_oracle.py."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from recorded import recorded

from fsipetsc.equations.elementary import logarithm_rest
from fsipetsc.kernels.loops import each
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.stiffened_gas import stiffened_gas

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
