"""The stability analysis: its operators are the solver's; Theorem 4.1 holds for `energy`; `traditional` fails."""

from __future__ import annotations

import csv
import itertools
import json

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("scipy")

from helpers import REPOSITORY, run, solve
from paper_parts import conserved, elastic_rates, gas_rates, gas_record, operator_of, solid_record

from fsipetsc.analysis.spectra import CENTRAL, range_basis, step_limit
from fsipetsc.analysis.stability_linear import assemble, interface_jacobian, measure, rates
from fsipetsc.analysis.stability_state import Constant, at_rest
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.operators import OPERATORS
from fsipetsc.paper import rates as loops
from fsipetsc.paper.laws import law_of

ORDERS = pytest.mark.parametrize("order", OPERATORS)
#: (order, state): each order, each state
PAIRS = (2, "ideal"), (4, "elastic"), (6, "stretched"), (8, "inviscid"), (8, "ideal")
EACH = pytest.mark.parametrize(("order", "state"), PAIRS)
N = 16  # points of a layer, enough for all orders
RATIOS = [*itertools.product((1e-3, 1e3), (1e-2, 1e2)), (1.0, 1.0)]


def constant(density: float = 2.0, stiffness: float = 3.0, eos: str = "ideal", stretch: float = 1.0, **gas) -> Constant:
    """A state of gas with p = 1.2, rho = 1.5; the heat capacity alpha m0 of the solid is 2.5, its stress 0 or -p."""
    fluid = Fluid(**{"mu": 0.01, "kappa": 0.03, "gamma": 1.4, "R": 1.0, **gas})
    p, m0, kappa_e = 1.2, density * 1.5, 0.02 if fluid.kappa else 0.0
    gruneisen = p * stretch / (2.5 * 0.8) if eos == "ideal" else 0.0
    return at_rest(fluid, Solid(stiffness * p, kappa_e, m0, 2.5 / m0, 0.0, gruneisen), 1.5, 0.8, stretch)


STATES = {
    "ideal": constant(),
    "elastic": constant(eos="elastic"),
    "stretched": constant(stretch=1.3),
    "inviscid": constant(mu=0.0, kappa=0.0),
}


def kernel_rates(kernel, law, layer: np.void, order: int, q: np.ndarray) -> np.ndarray:
    """The compiled right-hand side, (N, unknowns), at the state q."""
    q, out = np.ascontiguousarray(q), np.zeros(q.shape)
    scratch = np.zeros((loops.ROWS, len(q) + loops.MORE))
    kernel(operator_of(order), law, layer, q, np.zeros((0, q.shape[1])), scratch, out)
    return out


def differentiated(function, step: float, size: int) -> np.ndarray:
    """Derivative, (m, size), of a function of `size` small numbers at zero."""
    columns = []
    for e in np.eye(size) * step:
        columns.append(sum(c * (function(k * e) - function(-k * e)) for k, c in enumerate(CENTRAL, 1)) / step)
    return np.array(columns).T


@EACH
def test_rates_of_the_gas_are_those_of_the_kernel(order, state):
    state = STATES[state]
    h, gas, rest = 0.1, state.gas, np.array([[state.rho], [0.0], [state.T]])
    layer, law = gas_record(N, h=h), law_of(gas)
    layer["s"], layer["end_kind"][0] = 0.0, 0

    def primitive_rates(change: np.ndarray) -> np.ndarray:
        rho, u, T = rest + change.reshape(3, N)
        f = kernel_rates(gas_rates, law, layer, order, conserved(law, rho, u, T)).T
        u_t = (f[1] - u * f[0]) / rho
        return np.concatenate([f[0], u_t, ((f[2] - (gas.cv * T + u * u / 2) * f[0]) / rho - u * u_t) / gas.cv])

    D = OPERATORS[order].matrix(N, h)
    raw, heating = rates(state, D, (D, D), (D @ D, D @ D))
    expected = differentiated(primitive_rates, 1e-2, 3 * N)
    np.testing.assert_allclose(raw[: 3 * N, : 3 * N], expected, atol=1e-9 * np.abs(expected).max())
    assert not (heating[: 3 * N].any() or raw[: 3 * N, 3 * N :].any() or raw[3 * N :, : 3 * N].any())


@EACH
def test_rates_of_the_solid_are_those_of_the_kernel(order, state):
    """With S = sigma + p_s x_X'/x_X; positions act through S alone."""
    state = STATES[state]
    h, solid = 0.1, state.solid
    D = OPERATORS[order].matrix(N, h)
    rest = np.outer([0.0, state.stress, state.T, 0.0], np.ones(N))
    rest[3] = state.stretch * h * np.arange(N)
    layer = solid_record(N)
    layer["h"] = h

    def all_rates(change: np.ndarray) -> np.ndarray:
        f = kernel_rates(elastic_rates, solid.elastic, layer, order, (rest + change.reshape(4, N)).T).T
        S_t = f[1] + state.solid_pressure / state.stretch * (D @ f[3])
        return np.concatenate([f[0], S_t, f[2]])

    raw, heating = rates(state, D, (D, D), (D @ D, D @ D))
    expected = (raw + heating)[3 * N :, 3 * N :]
    got = differentiated(all_rates, 1e-3, 4 * N)
    close = {"atol": 1e-9 * np.abs(expected).max()}
    np.testing.assert_allclose(got[:, : 3 * N], expected, **close)
    of_strain = expected[:, N : 2 * N] @ (state.solid_pressure / state.stretch * D)
    np.testing.assert_allclose(got[:, 3 * N :], of_strain, atol=1e-9 * np.abs(of_strain).max() + 1e-12)


@EACH
@pytest.mark.parametrize("coupling", ["energy", "projection", "traditional"])
def test_linearised_treatments_are_projections_and_energy_an_orthogonal_one(order, state, coupling):
    state = STATES[state]
    P = assemble(state, order, N, 0.1, coupling).projection
    size = np.abs(P).max()
    assert np.abs(P @ P - P).max() < 1e-11 * size**2
    asymmetry = np.abs(P - P.T).max()
    assert (asymmetry < 1e-12) if coupling == "energy" else (asymmetry > 1e-3)
    basis = range_basis(P)
    np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-13)
    np.testing.assert_allclose(P @ basis, basis, atol=1e-11 * size)
    # 2 or 4 conditions at the interface, u = 0 at both ends, T = 0 there if heat is conducted
    assert basis.shape[1] == 6 * N - (4 if state.gas.kappa == 0 else 8)


def test_the_derivative_of_the_treatment_does_not_depend_on_the_step(monkeypatch):
    fine = interface_jacobian(STATES["ideal"], 4, 0.1, "energy")
    monkeypatch.setattr("fsipetsc.analysis.stability_linear.STEP", 2.0**-5)
    np.testing.assert_allclose(interface_jacobian(STATES["ideal"], 4, 0.1, "energy"), fine, atol=1e-10)


INVISCID = {"mu": 0.0, "kappa": 0.0}


@ORDERS
@pytest.mark.parametrize("state", [{"stretch": 0.7}, {"eos": "elastic"}, INVISCID], ids=["ideal", "elastic", "inviscid"])
def test_theorem_4_1_holds_to_round_off(order, state):
    for density, stiffness in RATIOS:
        result = measure(constant(density, stiffness, **state), order, N, 1 / N, "energy")
        assert result.estimate and result.stable and result.step_kept
        assert result.energy < 1e-12
        assert state is INVISCID or 0.99 < result.step_ratio < 1.01


@pytest.mark.long
@ORDERS
@pytest.mark.parametrize("coupling", ["energy", "projection"])
def test_narrow_second_derivatives_take_energy_and_give_none(order, coupling):
    """Their boundary derivative is the closure row, which the treatments take: what holds for D twice, holds for them."""
    for density, stiffness in RATIOS:
        for eos in ("ideal", "elastic"):
            wide, narrow = (measure(constant(density, stiffness, eos), order, N, 1 / N, coupling, on) for on in (False, True))
            assert narrow.step_kept and narrow.growth <= max(wide.growth, 1e-12)
            if coupling == "energy":
                assert narrow.estimate and narrow.energy < 1e-12


@ORDERS
def test_the_projection_has_no_growing_mode_for_an_elastic_solid_but_its_energy_may_grow(order):
    for density, stiffness in RATIOS:
        result = measure(constant(density, stiffness, "elastic"), order, 2 * N, 0.5 / N, "projection")
        assert result.energy > 1e-4
        assert result.stable
        assert result.step_kept


@ORDERS
def test_traditional_fails_for_a_light_solid(order):
    light, heavy = (measure(constant(d, 1.0), order, N, 1 / N, "traditional") for d in (1e-3, 1e3))
    assert light.energy > 1.0
    assert light.step_ratio < 0.4
    assert heavy.step_kept


def test_heating_by_the_stress_at_rest_makes_soft_solids_grow_whatever_the_grid():
    found = [measure(constant(1.0, 0.01, "elastic"), 4, n, 1 / n, "energy") for n in (16, 32, 48)]
    growths = [one.heated * one.radius for one in found]
    assert growths[-1] > 1e-4
    assert abs(growths[-1] / growths[-2] - 1) < 0.05


def test_step_limit_of_known_spectra():
    assert step_limit(np.array([3j, -3j])) == pytest.approx(2 * 2**0.5 / 3)
    assert step_limit(np.array([-2.0 + 0j])) == pytest.approx(2.785293563 / 2)
    assert step_limit(np.array([1e-13 + 1j])) == pytest.approx(2 * 2**0.5)


# the command


@pytest.fixture
def command(tmp_path):
    pytest.importorskip("petsc4py")
    return lambda *args: solve("stability", *args, cwd=tmp_path)


NAMES = ("2/1", "4/2", "6/3", "8/4")
SMALL = ("-sweep", "-stability_points", 16, "-density_ratios", "1e-3,1", "-stiffness_ratios", "0.01,100")


def test_command_for_one_material(command):
    done = command("-solid_density", 0.1, "-solid_modulus", 5)
    assert (done.returncode, done.stderr) == (0, "")
    for name in NAMES:
        words = next(line for line in done.stdout.splitlines() if line.strip().startswith(name)).split()
        assert words[1:3] == ["0.1", "5"] and words[-3:] == ["energy", "never", "grows"]


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """(folder, what was said) of a sweep on one rank."""
    pytest.importorskip("petsc4py")
    where = tmp_path_factory.mktemp("swept")
    return where, solve("stability", *SMALL, cwd=where)


def test_sweep_with_energy_holds_everywhere(swept):
    where, done = swept
    assert (done.returncode, done.stderr) == (0, "")
    with open(where / "stability-energy.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 4 * 4
    assert all(row[name] == "True" for row in rows for name in ("estimate", "stable", "step_kept"))
    counts = [line.split() for line in done.stdout.splitlines() if line.strip().startswith(NAMES)]
    assert [(words[1], words[2], words[4], words[6]) for words in counts] == [("4",) * 4] * 4
    pytest.importorskip("matplotlib")
    assert (where / "stability-energy.png").read_bytes().startswith(b"\x89PNG")


def test_sweep_with_traditional_ends_with_status_3(command, tmp_path):
    done = command(*SMALL, "-fsi_coupling", "traditional", "-fsi_output", "old", "-fsi_quiet")
    assert (done.returncode, done.stdout) == (3, "")
    assert "traditional fails in" in done.stderr
    assert "Traceback" not in done.stderr
    with open(tmp_path / "old.csv", newline="") as file:
        light = [row for row in csv.DictReader(file) if float(row["density_ratio"]) < 0.01]
    assert len(light) == 4 * 2
    assert sum(row["stable"] == "False" or row["step_kept"] == "False" for row in light) >= 7


@pytest.mark.mpi
def test_ranks_share_a_sweep(swept, tmp_path):
    done = solve("stability", *SMALL, "-fsi_output", "two", cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    assert (swept[0] / "stability-energy.csv").read_text() == (tmp_path / "two.csv").read_text()


def test_options_of_the_command(command, tmp_path):
    text = command("-help").stdout
    for word in ("-solid_eos", "-density_ratios", "-sweep", "-fsi_coupling", "1 kg/m3", "-options_file"):
        assert word in text
    refused = {
        ("-solid_densty", "3"): ("-solid_density",),
        ("-fsi_order", "5"): ("-fsi_order", "2, 4, 6, 8"),
        ("-fsi_orders", "4,5"): ("2,4,6,8",),
        ("-stability_points", "10"): ("-stability_points 10", "6/3", "12"),
        ("-solid_stress", "-2"): ("-solid_stress",),
        ("-solid_eos", "elastic", "-solid_stress", "1"): ("-solid_eos elastic",),
        ("-solid_gruneisen", "1", "-solid_stress", "1"): ("-solid_gruneisen",),
    }
    (tmp_path / "runs.json").write_text(json.dumps([[2, " ".join(("stability", *args))] for args in refused]))
    done = run(REPOSITORY / "tests" / "many_runs_program.py", "runs.json", cwd=tmp_path)
    answers = json.loads(done.stdout)
    assert (done.stderr, answers["wrong"]) == ("", [])
    for said, words in zip(answers["said"], refused.values(), strict=True):
        assert all(word in said for word in words), said
