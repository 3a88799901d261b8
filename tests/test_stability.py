"""The stability analysis: its operators are the derivative of the solver's right-hand side; Theorem
4.1 holds for `energy`; `traditional` fails; the command."""

from __future__ import annotations

import csv

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("scipy")
pytest.importorskip("petsc4py")

from helpers import message, solve
from mpi4py import MPI
from paper_parts import conserved, primitive

from fsipetsc.analysis.spectra import CENTRAL, step_limit
from fsipetsc.analysis.stability_linear import Constant, assemble, measure
from fsipetsc.boundaries import Wall
from fsipetsc.cases import load_case
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.operators import OPERATORS, operator
from fsipetsc.options import defaults
from fsipetsc.paper.state import PaperState
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

ORDERS = pytest.mark.parametrize("order", OPERATORS)
N = 16  # points of a layer, enough for all orders
#: of densities and stiffnesses
RATIOS = (1e-3, 1e2), (1e3, 1e-2), (1.0, 1.0)
INVISCID = {"mu": 0.0, "kappa": 0.0}


def constant(density=2.0, stiffness=3.0, eos="ideal", stretch=1.0, **gas):
    """A state of gas with p = 1.2, rho = 1.5; the heat capacity alpha m0 of the solid is 2.5, its
    stress 0 or -p."""
    fluid = Fluid(**{"mu": 0.01, "kappa": 0.03, "gamma": 1.4, "R": 1.0, **gas})
    p, m0, kappa_e = 1.2, density * 1.5, 0.02 if fluid.kappa else 0.0
    gruneisen = p * stretch / (2.5 * 0.8) if eos == "ideal" else 0.0
    solid = Solid(stiffness * p, kappa_e, m0, 2.5 / m0, 0.0, gruneisen)
    return Constant(fluid, solid, 1.5, 0.8, stretch)


# the linear scheme is the derivative of the solver's right-hand side

#: points of a layer; those at the interface whose rates are compared, and those that count for them
POINTS, ROWS, COLUMNS = 33, 8, 20


def built_in():
    """gas | solid | gas with viscosity; the solid has a pressure, is strained, and in balance."""
    gas, solid = Fluid(0.01, 0.03, 1.4, 1.0), Solid(3.0, 0.02, 2.0, 1.2, gruneisen=0.4)
    state = Constant(gas, solid, 1.5, 0.8, 1.1)

    def air(X):
        return [1.5 + 0 * X, 0 * X, 0.8 + 0 * X]

    def bar(X):
        return [0 * X, state.stress + 0 * X, 0.8 + 0 * X, 1 + 1.1 * (X - 1)]

    layers = (
        FluidLayer("left", gas, (0.0, 1.0), air),
        SolidLayer("bar", solid, (1.0, 2.0), bar),
        FluidLayer("right", gas, (2.0, 3.0), air),
    )
    return Problem(layers, Wall(0.0), Wall(3.1), units="none"), state


def D_of(order):
    return operator(order).matrix(POINTS, 1 / (POINTS - 1))


def expected(state, order, coupling, narrow):
    """The derivative of the rates of what the conditions make of (rho, u, T; u, S, T), by the
    linear theory, (6, POINTS, 6, POINTS)."""
    h = 1 / (POINTS - 1)
    raw, projection, _ = assemble(state, order, POINTS, h, coupling, narrow)
    norm = operator(order).norm_weights(POINTS)
    root = np.sqrt(h * np.outer(state.weights, norm)).ravel()
    raw = raw / root[:, None] * root
    heat = state.solid.alpha * state.solid.m0  # and what the stress sets free
    raw[5 * POINTS :, 3 * POINTS : 4 * POINTS] += state.stress / heat * D_of(order)
    found = raw @ (projection / root[:, None] * root)
    return found.reshape(6, POINTS, 6, POINTS)


def solver_rates(state, constant, order):
    """(6, POINTS) changes of (rho, u, T) in gas 2 and (u, S, T) in solid 1 -> rates of the same, by
    the solver."""
    start = state.solution.getArray().copy()
    gas, D = state.layers[2].law, D_of(order)
    stiffness = constant.modulus - constant.solid.K / constant.stretch

    def rates(change):
        y, f = start.copy(), np.empty_like(start)
        solid, fluid = (state.layers[i].of(y) for i in (1, 2))
        changed = constant.rho + change[0], change[1], constant.T + change[2]
        fluid[:POINTS] = conserved(gas, *changed)
        solid[:, :3] += change[3:].T
        state.right_hand_side(y, f)
        solid_t, fluid_t = state.layers[1].of(f), state.layers[2].of(f)[:POINTS]
        rho, u, T = primitive(gas, state.layers[2].owned[:POINTS])  # as the conditions made it
        rho_t, m_t, E_t = fluid_t.T
        u_t, cv = (m_t - u * rho_t) / rho, constant.gas.cv
        T_t = ((E_t - (cv * T + 0.5 * u * u) * rho_t) / rho - u * u_t) / cv
        S_t = solid_t[:, 1] + stiffness * (D @ solid_t[:, 3])
        return np.array([rho_t, u_t, T_t, solid_t[:, 0], S_t, solid_t[:, 2]])

    return rates


@pytest.mark.parametrize(
    ("order", "coupling", "narrow"),
    [
        (8, "projection", False),
        (6, "energy", False),
        (4, "traditional", False),
        (4, "projection", False),
        pytest.param(6, "energy", True, marks=pytest.mark.long),
    ],
)
def test_the_linear_scheme_is_the_derivative_of_the_right_hand_side(order, coupling, narrow):
    (problem, constant), h = built_in(), 1 / (POINTS - 1)
    wanted = expected(constant, order, coupling, narrow)
    unit = constant.scales[:, None, None, None] / constant.scales[:, None]  # where all are alike
    at = [np.arange(COLUMNS)] * 3 + [POINTS - 1 - np.arange(COLUMNS)] * 3
    opt = {**defaults(load_case("rod")), "fsi_order": order, "fsi_h": h, "fsi_coupling": coupling}
    opt["fsi_viscous"] = "narrow" if narrow else "wide"
    with PaperState(MPI.COMM_SELF, problem, opt) as state:
        state.set_initial()
        rates = solver_rates(state, constant, order)
        for c, j in ((row, j) for row in range(6) for j in at[row]):
            change = np.zeros((6, POINTS))
            change[c, j] = 2.0**-8 * constant.scales[c]
            pairs = [rates(m * change) - rates(-m * change) for m in range(1, 5)]
            found = np.tensordot(CENTRAL, pairs, 1) / change[c, j]
            wrong = (found - wanted[:, :, c, j]) / unit[:, :, c, 0]
            near = np.array([wrong[i, at[i][:ROWS]] for i in range(6)])
            assert np.abs(near).max() < 1e-8 * np.abs(wanted / unit).max(), (c, j, near)


# what follows


@ORDERS
@pytest.mark.parametrize("narrow", [False, True], ids=["wide", "narrow"])
@pytest.mark.parametrize("state", [{"stretch": 0.7}, {"eos": "elastic"}, INVISCID])
def test_theorem_4_1_holds_to_round_off(order, state, narrow):
    for density, stiffness in RATIOS:
        gas = constant(density, stiffness, **state)
        result = measure(gas, order, N, 1 / N, "energy", narrow)
        assert result.estimate and result.stable and result.step_kept
        assert result.energy < 1e-12
        assert narrow or state is INVISCID or 0.99 < result.step_ratio < 1.01


@ORDERS
def test_projection_and_traditional(order):
    """The one has no growing mode for an elastic solid, but its energy may grow; the other fails
    for a light solid."""
    for density, stiffness in RATIOS:
        state = constant(density, stiffness, "elastic")
        result = measure(state, order, 2 * N, 0.5 / N, "projection")
        assert result.energy > 1e-4
        assert result.stable and result.step_kept
    light, heavy = (
        measure(constant(density, 1.0), order, N, 1 / N, "traditional") for density in (1e-3, 1e3)
    )
    assert light.energy > 1.0 and light.step_ratio < 0.4
    assert heavy.step_kept


@ORDERS
def test_conservative(order):
    for density, stiffness in RATIOS:
        result = measure(constant(density, stiffness), order, N, 1 / N, "conservative")
        assert result.estimate and result.energy < 1e-12
        assert result.stable and result.step_kept


def test_step_limit_of_known_spectra():
    assert step_limit(np.array([3j, -3j])) == pytest.approx(2 * 2**0.5 / 3)
    assert step_limit(np.array([-2.0 + 0j])) == pytest.approx(2.785293563 / 2)
    assert step_limit(np.array([1e-13 + 1j])) == pytest.approx(2 * 2**0.5)


# the command

NAMES = ("2/1", "4/2", "6/3", "8/4")
SMALL = (
    *("-sweep", "-stability_points", 16),
    *("-density_ratios", "1e-3,1", "-stiffness_ratios", "0.01,100"),
)


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_command_for_one_material(tmp_path):
    done = solve("stability", "-solid_density", 0.1, "-solid_modulus", 5, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    for name in NAMES:
        words = next(line for line in lines if line.strip().startswith(name)).split()
        assert [words[k] for k in (1, 2, 4, 6)] == ["1"] * 4 and float(words[8]) > 0.0
    assert "solid  p 1 Pa, sigma 0 Pa" in done.stdout


@pytest.mark.mpi
def test_sweep_with_energy_holds_everywhere_on_any_ranks(tmp_path):
    for ranks in (1, 2):
        name = f"sweep{ranks}"
        done = solve("stability", *SMALL, "-fsi_output", name, cwd=tmp_path, ranks=ranks)
        assert (done.returncode, done.stderr) == (0, "")
    rows = rows_of(tmp_path / "sweep1.csv")
    assert len(rows) == 4 * 4 and rows == rows_of(tmp_path / "sweep2.csv")
    assert all(row[n] == "True" for row in rows for n in ("estimate", "stable", "step_kept"))
    counts = [line.split() for line in done.stdout.splitlines() if line.strip().startswith(NAMES)]
    assert [(words[1], words[2], words[4], words[6]) for words in counts] == [("4",) * 4] * 4


def test_sweep_with_traditional_ends_with_status_3(tmp_path):
    more = "-fsi_coupling", "traditional", "-fsi_output", "old", "-fsi_quiet"
    done = solve("stability", *SMALL, *more, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (3, "")
    assert "traditional fails in" in done.stderr and "Traceback" not in done.stderr
    light = [row for row in rows_of(tmp_path / "old.csv") if float(row["density_ratio"]) < 0.01]
    assert len(light) == 4 * 2
    assert sum("False" in (row["stable"], row["step_kept"]) for row in light) >= 7


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-solid_densty 3", ("-solid_density",)),
        ("-fsi_orders 5", ("-fsi_orders", "2,4,6,8")),
        ("-stability_points 10", ("-stability_points 10", "6/3", "12")),
    ],
)
def test_bad_input_to_the_command(words, said, tmp_path):
    message(solve("stability", *words.split(), cwd=tmp_path), 2, *said)
