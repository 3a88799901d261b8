"""Laws that cases bring as plain functions or classes, and what a Fluid says of itself."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from helpers import REPOSITORY, compute, solve
from own_gas import NobleAbel

import fsipetsc
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.own import gas_law, solid_law, transport_law
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.materials.sutherland import sutherland

R, CV = 287.0, 717.5
GAS = {
    "pressure": lambda rho, T: R * rho * T,
    "internal_energy": lambda rho, T: CV * T,
    "temperature": lambda rho, e: e / CV,
    "density": lambda p, T: p / (R * T),
    "temperature_of": lambda rho, p: p / (R * rho),
}
SOLID = {"mu_e": 1.3, "lambda_e": 2.1, "kappa_e": 0.0, "m0": 1.7, "alpha": 0.6}


def log_stress(F):
    """That of the law "log" in two dimensions."""
    mu, K = 1.3, 4.7
    J = F[0] * F[3] - F[1] * F[2]
    pull = K * np.log(J) - mu * J
    return (
        mu * F[0] + pull * F[3],
        mu * F[1] - pull * F[2],
        mu * F[2] - pull * F[1],
        mu * F[3] + pull * F[0],
    )


def log_energy(F):
    mu, K = 1.3, 4.7
    J = F[0] * F[3] - F[1] * F[2]
    shear = 0.5 * mu * (F[0] ** 2 + F[1] ** 2 + F[2] ** 2 + F[3] ** 2 - 1.0 - J * J)
    return shear + K * (J * np.log(J) - J + 1.0)


def test_what_follows_from_the_needed_formulas_of_a_gas():
    own, built_in = Fluid(0.0, 0.0, 1.4, R, law=gas_law(**GAS)).gas_law, PerfectGas(1.4, R)
    rho, T = 1.3, 310.0
    for name in ("energy_density", "heat_capacity", "bulk_modulus", "pressure_by_temperature"):
        wanted = getattr(built_in, name)(rho, T)
        assert getattr(own, name)(rho, T) == pytest.approx(wanted, rel=1e-9)
    assert own.sound_speed_squared(rho, T) == pytest.approx(1.4 * R * T, rel=1e-9)
    assert np.isnan(own.entropy(rho, T))


def test_a_law_may_have_numbers_of_its_own():
    law = Fluid(0.0, 0.0, 1.4, R, law=NobleAbel(1.4, R, 0.1)).gas_law
    room = 1.0 - 0.1 * 1.3
    assert law.sound_speed_squared(1.3, 310.0) == pytest.approx(1.4 * R * 310.0 / room**2, rel=1e-8)


def test_what_a_fluid_says():
    air = Fluid(1.8e-5, 0.026, 1.4, R, transport=sutherland(273.0, 111.0, 194.0))
    assert air.cv == pytest.approx(CV)
    assert air.sound_speed(300.0) == pytest.approx(np.sqrt(1.4 * R * 300.0), rel=1e-14)
    assert air.internal_energy(1.2, 300.0) == pytest.approx(CV * 300.0)
    assert air.transport_law.conductivity(273.0) == pytest.approx(1.0)
    water = Fluid(1e-3, 0.6, 4.4, 1.0, law=stiffened_gas(4.4, 1000.0, 6e8))
    p = water.gas_law.pressure(1000.0, 300.0)
    assert water.sound_speed(300.0, 1000.0) == pytest.approx(np.sqrt(4.4 * (p + 6e8) / 1000.0))
    assert water.internal_energy(1000.0, 300.0) == pytest.approx(1000.0 * 300.0 + 6e8 / 1000.0)


def test_an_own_stress_is_that_of_the_built_in_law():
    own = ElasticSolid(**SOLID, law=solid_law(stress=log_stress, energy=log_energy), heat="elastic")
    built_in = ElasticSolid(**SOLID, heat="elastic")
    for F in (1.0, 0.0, 0.0, 1.0), (1.1, 0.05, -0.08, 0.95), (0.7, -0.3, 0.2, 1.3):
        laws = own.solid_law, built_in.solid_law
        assert laws[0].stress(F) == pytest.approx(laws[1].stress(F), abs=1e-13)
        assert laws[0].energy(F) == pytest.approx(laws[1].energy(F), abs=1e-13)
        assert laws[0].wave_modulus(F) >= 0.99 * laws[1].wave_modulus(F) / 2.0


def elastic(stress, energy):
    law = solid_law(stress=stress, energy=energy)
    return ElasticSolid(**SOLID, law=law, heat="elastic").equations(2)


WRONG = {
    r"gas_law: the formula internal_energy\(rho, T\) is missing": lambda: gas_law(
        pressure=GAS["pressure"]
    ),
    "no formula 'viscosity'": lambda: gas_law(**GAS, viscosity=GAS["pressure"]),
    r"density\(p\): expected density\(p, T\)": lambda: gas_law(**GAS | {"density": lambda p: p}),
    "gas_law: density cannot be compiled": lambda: gas_law(
        **GAS | {"density": lambda p, T: T.nowhere}
    ),
    "density returns a value of the type": lambda: gas_law(
        **GAS | {"density": lambda p, T: (p, T)}
    ),
    "viscosity is 3: expected a function": lambda: transport_law(3),
    r"expected what transport_law\(…\) returns": lambda: Fluid(
        1.0, 1.0, 1.4, R, transport=lambda T: T
    ),
    r"Fluid: law is 3: expected what gas_law\(…\) returns": lambda: Fluid(1.0, 1.0, 1.4, R, law=3),
    r"no formula energy\(F\), which heat='elastic' needs": lambda: ElasticSolid(
        **SOLID, law=solid_law(stress=log_stress), heat="elastic"
    ),
    "stress is not the derivative of energy": lambda: elastic(
        log_stress, lambda F: 1.001 * log_energy(F)
    ),
    "expected a tuple of 4 numbers": lambda: elastic(lambda F: F[:3], log_energy),
}


@pytest.mark.parametrize("said", WRONG)
def test_what_is_wrong_with_a_law(said):
    with pytest.raises(InputError, match=said):
        WRONG[said]()


def test_a_run_with_a_wrong_law_ends_with_status_2(tmp_path):
    text = (REPOSITORY / "runs" / "sutherland.py").read_text()
    (tmp_path / "wrong.py").write_text(text.replace("/ (T + S))\n", "/ (T + S)).wrong\n"))
    done = solve("wrong.py", "-fsi_coupling", "energy", cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert "transport_law" in done.stderr, done.stderr


@pytest.mark.long
def test_a_perfect_gas_written_by_hand_has_the_bits_of_the_built_in_one(tmp_path):
    """Another gas, as dense as bρ = 0.02 makes it, moves the solid by a part of 3e-5 more."""
    own, short = str(REPOSITORY / "tests" / "own_gas.py"), "-fsi_h 0.05 -ts_max_time 0.5"
    other = f"{short} -fluid_gamma 1.5"
    listed = {"built_in": ("box", short), "by_hand": (own, short)}
    found = compute(1, tmp_path, listed | {"perfect": ("box", other), "noble": (own, other)})
    runs = {name: fsipetsc.open_run(path) for name, path in found.items()}
    for name in ("mass", "energy", "momentum_x", "x_interface"):
        assert np.array_equal(runs["built_in"].series[name], runs["by_hand"].series[name]), name
    moved, more = (
        np.ptp(runs[name].series["x_interface"], axis=0) for name in ("perfect", "noble")
    )
    assert np.all(np.abs(more / moved - 1.0) > 1e-5)
