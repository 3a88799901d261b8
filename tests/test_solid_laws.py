"""Laws of solids: the oracle's formulas, energies with many digits, bounds of waves, pressures."""

from decimal import Decimal, localcontext
from functools import partial

import numpy as np
import oracle_formulas as formulas
import pytest
from block_ledgers import Steps

from fsipetsc import Fluid
from fsipetsc.blocks.conditions import Free, NoSlip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.own import solid_law
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


@EACH_D
@pytest.mark.parametrize("name", LAWS)
def test_energy_and_stress(name, d):
    """Those of the oracle; the stress is the derivative of the energy; no energy at rest."""
    law, of_oracle = solid(law=name, p_ref=P_REF).solid_law, formulas.Solid(name, MU, LAMBDA)
    energy = partial(formulas.elastic_energy, of_oracle, p_ref=P_REF)
    assert law.energy(flat(np.eye(d))) == 0.0
    for F in strains(d):
        W, P = energy(formulas.three(F)), formulas.stress_of(energy, formulas.three(F))[:d, :d]
        assert law.energy(flat(F)) == pytest.approx(W, abs=1e-14)
        assert np.abs(np.reshape(law.stress(flat(F)), (d, d)) - P).max() < 1e-13
        assert np.abs(derivative(lambda G: law.energy(flat(G)), F) - P).max() < 1e-8


def det(A):
    minors = (np.delete(A[1:], j, axis=1) for j in range(len(A)))
    return sum((-1) ** j * A[0, j] * (det(m) if m.size else 1) for j, m in enumerate(minors))


def many_digits(name, F, p_ref):
    """W of a law as its file states it, in decimal numbers."""
    exact = np.vectorize(Decimal, otypes=[object])
    d, F, mu, lam, p = len(F), exact(F), *map(Decimal, (MU, LAMBDA, p_ref))
    C, unit, J = F.T @ F, exact(np.eye(d)), det(F)
    if name in ("svk", "linear"):
        E = (C - unit if name == "svk" else F + F.T - 2 * unit) / 2
        return lam / 2 * np.trace(E) ** 2 + mu * (E * E).sum() - p * (J - 1)
    ln = J.ln()
    shear = mu / 2 * (np.trace(C) - d - 2 * ln)
    if name == "neo-hookean":
        return shear + lam / 2 * ln**2 - p * (J - 1)
    return shear + (2 * mu + lam) * (J * ln - J + 1) - mu * ((J * J - 1) / 2 - ln) - p * (J - 1)


@EACH_D
@pytest.mark.parametrize("name", LAWS)
def test_energies_have_all_digits(name, d):
    """At strains of 1e-9, the same turned, and large ones; p_ref's part is of first order."""
    law, rng = solid(law=name).solid_law, np.random.default_rng(3)
    turned = np.linalg.qr(rng.standard_normal((d, d)))[0]
    turned[0] *= np.linalg.det(turned)
    small = (1e-9, np.eye(d), 1e-14, 1e-23), (1e-9, turned, 1e-5, 1e-15)
    for size, turn, relative, absolute in (*small, (0.2, turned, 1e-13, 1e-15)):
        for G in size * rng.uniform(-1.0, 1.0, (4, d, d)):
            F = turn @ (np.eye(d) + G)
            with localcontext() as digits:
                digits.prec = 60
                alone, pressed = (many_digits(name, F, p) for p in (0.0, P_REF))
                found = law.energy(flat(F)), law._replace(p_ref=P_REF).energy(flat(F))
                error, other = Decimal(float(found[0])) - alone, Decimal(float(found[1])) - pressed
            assert abs(error / alone) < relative and abs(other) < absolute * max(1.0, float(alone))


OWN = solid_law(stress=lambda F: solid(p_ref=P_REF).solid_law.stress(F))
#: laws, pressures, kinds of heat
MATERIALS = [
    *((name, None, "coupled") for name in LAWS),
    *(("log", p, heat) for p in PRESSURES for heat in ("coupled", "elastic")),
    (OWN, None, "coupled"),
]


def adiabatic_stiffness(equations, heat, F):
    """d P_ij / d F_kl where alpha m0 dT = P : dF; with heat 'elastic' pressure alone heats."""
    d = len(F)
    P = np.reshape(equations.stress_at(flat(F), T), (d, d))
    heats = P - (np.reshape(equations.law.stress(flat(F)), (d, d)) if heat == "elastic" else 0.0)

    def adiabatic(G):
        warmer = T + (heats * (G - F)).sum() / (M0 * ALPHA)
        return np.reshape(equations.stress_at(flat(G), warmer), (d, d))

    return derivative(adiabatic, F)


@EACH_D
@pytest.mark.parametrize(("law", "pressing", "heat"), MATERIALS)
def test_no_wave_is_faster_than_the_modulus_says(law, pressing, heat, d):
    equations, ratios = solid(law=law, pressing=pressing, heat=heat).equations(d), []
    rng = np.random.default_rng(5)
    for F in strains(d, 0.15 if pressing else 0.2):
        A, bound = adiabatic_stiffness(equations, heat, F), equations.wave_modulus_at(flat(F), T)
        N = rng.standard_normal((8, d))
        N /= np.linalg.norm(N, axis=1)[:, None]
        Q = np.einsum("iajb,na,nb->nij", A, N, N)
        found = np.linalg.eigvals(Q).real.max()
        assert found <= bound * (1.0 + 1e-4 if heat == "coupled" else 1.0 + 1e-9)
        ratios.append(bound / found)
        for n, exact in zip(N, Q):
            of_law = np.reshape(equations.acoustic_tensor(flat(F), T, tuple(n)), (d, d))
            assert np.abs(of_law - 0.5 * (exact + exact.T)).max() < 1e-8 * bound
    if not pressing:  # not far too large: steps would be far too short
        assert max(ratios) < (2.0 if law is OWN and d < 3 else 3.5)
    if law in LAWS and not pressing:
        unit = equations.wave_modulus_at(flat(np.eye(d)), T)
        assert unit == pytest.approx(2.0 * MU + LAMBDA, rel=1e-14)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize(
    ("law", "most"), [*((name, 1e-13) for name in LAWS if name != "linear"), (OWN, 1e-9)]
)
def test_an_impedance_turns_with_the_axes(law, most, d):
    rng = np.random.default_rng(8)
    equations = solid(law=law, p_ref=P_REF, pressing=PRESSURES[0]).equations(d)
    for F in strains(d):
        R, (N, v) = np.linalg.qr(rng.standard_normal((d, d)))[0], rng.standard_normal((2, d))
        N /= np.linalg.norm(N)
        of_axes = [
            equations.resistance(flat(S @ F @ S.T), T, flat(S @ N), flat(S @ v))
            for S in (np.eye(d), R)
        ]
        assert np.abs(R @ of_axes[0] - of_axes[1]).max() < most * np.linalg.norm(of_axes[0])


@pytest.mark.parametrize("law", ["log", solid_law(stress=lambda F: (5e6 * np.log(F[0]),))])
def test_stress_at_an_interface_has_p_ref(law):
    """A solid at rest under 1e5 Pa, as results have it at the last node of the solid."""
    solid = ElasticSolid(0.0, 5e6, 0.2, 1000.0, 1500.0, p_ref=1e5, law=law)
    gas, start = Fluid(1.8e-5, 0.026, 1.4, 287.0), (1e5 / 287.0 / 300.0, 0.0, 300.0)
    stack = (
        Layer("gas", gas, (0.0, 1.0), lambda X: start, cells=8),
        Layer("solid", solid, (1.0, 1.5), lambda X: (0.0, 300.0, X), cells=8),
    )
    with Steps(layers(*stack, lower=NoSlip(), upper=Free(1e5))) as run:
        run.step(1e-5)
        assert run.latest["sigma_interface"] == pytest.approx([-1e5], rel=1e-12)
