"""Laws of solids: derivatives, objectivity, waves; a solid of them."""

from __future__ import annotations

import numpy as np
import pytest

from fsipetsc.errors import InputError
from fsipetsc.materials.linear_elastic import LinearElastic
from fsipetsc.materials.log_solid import Log
from fsipetsc.materials.neo_hookean import NeoHookean
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.solid_pressure import gruneisen, mie_gruneisen
from fsipetsc.materials.st_venant_kirchhoff import StVenantKirchhoff

MU, LAMBDA, P_REF = 1.3, 2.1, 0.4
OBJECTIVE = Log, NeoHookean, StVenantKirchhoff
LAWS = *OBJECTIVE, LinearElastic
PRESSURES = gruneisen(1.2), mie_gruneisen(2.0, 1.4, 1.1, 0.8)
M0, ALPHA = 1.7, 0.6


def strains(d, count=6, size=0.2, seed=0):
    """Deformation gradients with J > 0, (count, d, d)."""
    noise = np.random.default_rng(seed).uniform(-size, size, (count, d, d))
    return np.eye(d) + noise


def rotation(d, seed=1):
    Q, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((d, d)))
    return Q * np.linalg.det(Q) if d == 3 else Q @ np.diag([*[1.0] * (d - 1), np.linalg.det(Q)])


def flat(F):
    return tuple(F.ravel().tolist())


def tensor(P):
    d = round(len(P) ** 0.5)
    return np.array(P).reshape(d, d)


def slopes(f, F, step=1e-5):
    """df/dF by central differences, of numbers or of tensors: (…, d, d)."""
    d, found = len(F), []
    for m in range(d * d):
        bump = np.zeros(d * d)
        bump[m] = step
        bump = bump.reshape(d, d)
        found.append((np.array(f(F + bump)) - np.array(f(F - bump))) / (2.0 * step))
    return np.moveaxis(np.array(found), 0, -1).reshape(*np.shape(found[0]), d, d)


def acoustic(law, F, N):
    """Largest eigenvalue of N . d2W/dF2 . N: m0 c^2 of waves in the direction N."""
    A = slopes(lambda G: tensor(law.stress(flat(G))), F)
    return np.linalg.eigvalsh(np.einsum("iajb,a,b->ij", A, N, N)).max()


@pytest.mark.parametrize("d", [1, 2, 3])
@pytest.mark.parametrize("law", LAWS)
def test_the_stress_is_the_derivative_of_the_energy(law, d):
    law = law(MU, LAMBDA, P_REF)
    for F in strains(d):
        wanted = slopes(lambda G: law.energy(flat(G)), F)
        assert np.abs(tensor(law.stress(flat(F))) - wanted).max() < 1e-8


@pytest.mark.parametrize("d", [1, 2, 3])
@pytest.mark.parametrize("law", LAWS)
def test_all_laws_are_hookes_for_small_strains(law, d):
    """With Lamé's constants, but for the pressure -p_ref cof F; W = 0 without strain."""
    E = 1e-6 * strains(d, 1, 1.0)[0]  # not symmetric: a small rotation is no strain
    loaded, free = (law(MU, LAMBDA, p).stress(flat(np.eye(d) + E)) for p in (P_REF, 0.0))
    hooke = LAMBDA * np.trace(E) * np.eye(d) + MU * (E + E.T)
    assert np.abs(tensor(free) - hooke).max() < 1e-10
    cofactor = np.linalg.det(np.eye(d) + E) * np.linalg.inv(np.eye(d) + E).T
    assert np.abs(tensor(loaded) - tensor(free) + P_REF * cofactor).max() < 1e-14
    assert law(MU, LAMBDA, P_REF).energy(flat(np.eye(d))) == 0.0


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("law", OBJECTIVE)
def test_a_rotation_changes_no_energy_and_turns_the_stress(law, d):
    law, Q = law(MU, LAMBDA, P_REF), rotation(d)
    for F in strains(d):
        assert abs(law.energy(flat(Q @ F)) - law.energy(flat(F))) < 1e-13
        P = tensor(law.stress(flat(F)))
        assert np.abs(tensor(law.stress(flat(Q @ F))) - Q @ P).max() < 1e-13
        assert np.abs(P @ F.T - F @ P.T).max() < 1e-13


@pytest.mark.parametrize("d", [1, 2, 3])
@pytest.mark.parametrize("law", LAWS)
def test_no_wave_is_faster_than_the_modulus_says(law, d):
    law, rng = law(MU, LAMBDA, 0.0), np.random.default_rng(2)
    ratios = []
    for F in strains(d):
        bound = law.wave_modulus(flat(F))
        N = rng.standard_normal((8, d))
        found = max(acoustic(law, F, n / np.linalg.norm(n)) for n in N)
        assert found <= bound * (1.0 + 1e-6)
        ratios.append(bound / found)
    assert max(ratios) < 3.5
    unit = law.wave_modulus(flat(np.eye(d)))
    assert unit == pytest.approx(2.0 * MU + LAMBDA, rel=1e-14)


# a solid of them


def solid(**more):
    numbers = {"mu_e": MU, "lambda_e": LAMBDA, "kappa_e": 0.7, "m0": M0, "alpha": ALPHA}
    numbers |= {"p_ref": P_REF}
    return ElasticSolid(**numbers | more)


def law_in(d):
    """Its law; in three dimensions p_ref acts on faces, not in the stress."""
    return Log(MU, LAMBDA, P_REF if d < 3 else 0.0)


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
@pytest.mark.parametrize("d", [1, 2, 3])
def test_energy_and_temperature(d, heat):
    equations, v, T = solid(heat=heat).equations(d), (0.3, -0.2, 0.5)[:d], 1.7
    F = flat(strains(d, 1)[0])
    stored = law_in(d).energy(F) / M0 if heat == "elastic" else 0.0
    e = 0.5 * np.dot(v, v) + ALPHA * T + stored
    assert equations.temperature(v, e, F) == pytest.approx(T, rel=1e-13)
    assert solid().K == pytest.approx(2.0 * MU + LAMBDA)


@pytest.mark.parametrize("pressing", PRESSURES)
@pytest.mark.parametrize("d", [1, 2, 3])
def test_the_pressure_is_part_of_the_stress(d, pressing):
    F, T = strains(d, 1)[0], 1.2
    J = np.linalg.det(F)
    p = pressing.pressure(J, T, M0, ALPHA)
    wanted = tensor(law_in(d).stress(flat(F))) - p * J * np.linalg.inv(F).T
    found = tensor(solid(pressing=pressing).equations(d).stress_at(flat(F), T))
    assert np.abs(found - wanted).max() < 1e-13


@pytest.mark.parametrize("d", [1, 2, 3])
def test_heat_flows_along_the_gradient_in_space(d):
    """h = kappa J F^-1 F^-T grad T."""
    F = strains(d, 1)[0]
    gradient = np.array([0.3, -0.2, 0.5])[:d]
    inverse = np.linalg.inv(F)
    wanted = 0.7 * np.linalg.det(F) * inverse @ inverse.T @ gradient
    found = solid().equations(d).heat_flux(flat(F), tuple(gradient))
    assert np.abs(np.array(found) - wanted).max() < 1e-13


@pytest.mark.parametrize("pressing", [None, *PRESSURES])
@pytest.mark.parametrize("d", [1, 2, 3])
def test_no_wave_at_constant_entropy_is_faster_than_the_modulus_says(d, pressing):
    """On an adiabat alpha m0 dT = (P + W' heat) : dF, T follows from the work of all stresses."""
    made = solid(pressing=pressing, p_ref=0.0)
    equations, rng, T = made.equations(d), np.random.default_rng(5), 1.1
    for F in strains(d, 4, 0.15):
        P = tensor(equations.stress_at(flat(F), T))

        def adiabatic(G, F=F, P=P):
            warmer = T + (P * (G - F)).sum() / (M0 * ALPHA)
            return tensor(equations.stress_at(flat(G), warmer))

        A = slopes(adiabatic, F)
        bound = equations.wave_modulus_at(flat(F), T)
        for _ in range(6):
            N = rng.standard_normal(d)
            N /= np.linalg.norm(N)
            speeds = np.linalg.eigvals(np.einsum("iajb,a,b->ij", A, N, N)).real
            assert speeds.max() <= bound * (1.0 + 1e-4)


WRONG = {
    "law is 'rubber': expected 'log', 'neo-hookean', 'svk', 'linear'": {"law": "rubber"},
    "law is 3: expected what solid_law": {"law": 3},
    "heat is 'none': expected 'coupled' or 'elastic'": {"heat": "none"},
    "mu_e and lambda_e are 0": {"mu_e": 0.0, "lambda_e": 0.0},
    "kappa_e is nan": {"kappa_e": float("nan")},
    "pressing is 3: expected what pressure_law": {"pressing": 3},
    "force is": {"force": (1.0,) * 4},
}


@pytest.mark.parametrize("said", WRONG)
def test_what_is_no_solid(said):
    with pytest.raises(InputError, match=said):
        solid(**WRONG[said])
