"""Laws of solids against the formulas of the oracle, the bound of their waves, and pressures."""

from functools import partial

import numpy as np
import oracle_formulas as formulas
import pytest

from fsipetsc.materials.solid import LAWS, ElasticSolid
from fsipetsc.materials.solid_pressure import gruneisen, mie_gruneisen

MU, LAMBDA, P_REF = 1.3, 2.1, 0.4
PRESSURES = gruneisen(1.2), mie_gruneisen(2.0, 1.4, 1.1, 0.8)
M0, ALPHA, T = 1.7, 0.6, 1.1
EACH_D = pytest.mark.parametrize("d", [1, 2, 3])


def solid(**more):
    return ElasticSolid(MU, LAMBDA, 0.7, M0, ALPHA, **more)


def strains(d, size=0.2):
    """Deformation gradients with J > 0, (6, d, d)."""
    return np.eye(d) + np.random.default_rng(0).uniform(-size, size, (6, d, d))


def flat(F):
    return tuple(F.ravel().tolist())


def derivative(f, F, step=1e-5):
    """Of numbers or tensors by F: (…, d, d)."""
    bumps = step * np.eye(F.size).reshape(F.size, *F.shape)
    found = [(np.array(f(F + bump)) - f(F - bump)) / (2.0 * step) for bump in bumps]
    return np.moveaxis(found, 0, -1).reshape(*np.shape(found[0]), *F.shape)


def energy_and_stress(m, F, p_ref):
    """(W, P) of a law by its name."""
    energy, d = partial(formulas.elastic_energy, m, p_ref=p_ref), len(F)
    return energy(formulas.three(F)), formulas.stress_of(energy, formulas.three(F))[:d, :d]


@EACH_D
@pytest.mark.parametrize("name", LAWS)
def test_energy_and_stress(name, d):
    """Those of the oracle; the stress is the derivative of the energy; no energy at rest."""
    law, of_oracle = solid(law=name, p_ref=P_REF).solid_law, formulas.Solid(name, MU, LAMBDA)
    assert law.energy(flat(np.eye(d))) == 0.0
    for F in strains(d):
        W, P = energy_and_stress(of_oracle, F, P_REF)
        assert law.energy(flat(F)) == pytest.approx(W, abs=1e-14)
        assert np.abs(np.reshape(law.stress(flat(F)), (d, d)) - P).max() < 1e-13
        slopes = derivative(lambda G: law.energy(flat(G)), F)
        assert np.abs(slopes - P).max() < 1e-8


@EACH_D
@pytest.mark.parametrize(
    ("law", "pressing"), [*((name, None) for name in LAWS), *(("log", p) for p in PRESSURES)]
)
def test_no_wave_is_faster_than_the_modulus_says(law, pressing, d):
    """On an adiabat alpha m0 dT = P : dF, T follows from the work of all stresses."""
    equations, ratios = solid(law=law, pressing=pressing).equations(d), []
    rng = np.random.default_rng(5)
    for F in strains(d, 0.15 if pressing else 0.2):
        P = np.reshape(equations.stress_at(flat(F), T), (d, d))

        def adiabatic(G, F=F, P=P):
            warmer = T + (P * (G - F)).sum() / (M0 * ALPHA)
            return np.reshape(equations.stress_at(flat(G), warmer), (d, d))

        A, bound = derivative(adiabatic, F), equations.wave_modulus_at(flat(F), T)
        N = rng.standard_normal((8, d))
        N /= np.linalg.norm(N, axis=1)[:, None]
        found = np.linalg.eigvals(np.einsum("iajb,na,nb->nij", A, N, N)).real.max()
        assert found <= bound * (1.0 + 1e-4)
        ratios.append(bound / found)
    if not pressing:  # not far too large: steps would be far too short
        assert max(ratios) < 3.5
        unit = equations.wave_modulus_at(flat(np.eye(d)), T)
        assert unit == pytest.approx(2.0 * MU + LAMBDA, rel=1e-14)


@pytest.mark.parametrize("pressing", PRESSURES)
@EACH_D
def test_the_pressure_is_part_of_the_stress(d, pressing):
    F = strains(d)[0]
    J = np.linalg.det(F)
    p = pressing.pressure(J, T, M0, ALPHA)
    _, P = energy_and_stress(formulas.Solid("log", MU, LAMBDA), F, 0.0)
    found = solid(pressing=pressing).equations(d).stress_at(flat(F), T)
    assert np.abs(np.subtract(found, flat(P - p * J * np.linalg.inv(F).T))).max() < 1e-13
