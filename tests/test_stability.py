"""The stability analysis: it is the derivative of the right-hand side; Theorem 4.1; the command."""

from itertools import product

import numpy as np
import pytest
from helpers import rows_of, solve
from mpi4py import MPI

from fsipetsc import FluidLayer, Problem, SolidLayer, Wall
from fsipetsc.cases import load_case
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import Solid
from fsipetsc.operators.sbp import OPERATORS, operator
from fsipetsc.options import defaults
from fsipetsc.paper.paper_state import PaperState
from fsipetsc.studies.spectra import CENTRAL
from fsipetsc.studies.stability_linear import Constant, assemble, measure

ORDERS = pytest.mark.parametrize("order", OPERATORS)
N = 16  # points of a layer, enough for all orders
#: of densities and stiffnesses
RATIOS = (1e-3, 1e2), (1e3, 1e-2), (1.0, 1.0)
INVISCID = {"mu": 0.0, "kappa": 0.0}


def constant(density=2.0, stiffness=3.0, eos="ideal", stretch=1.0, **gas):
    """Gas with p = 1.2, rho = 1.5; a solid of heat capacity alpha m0 = 2.5, its stress 0 or -p."""
    fluid = Fluid(**{"mu": 0.01, "kappa": 0.03, "gamma": 1.4, "R": 1.0, **gas})
    p, m0, kappa_e = 1.2, density * 1.5, 0.02 if fluid.kappa else 0.0
    gruneisen = p * stretch / (2.5 * 0.8) if eos == "ideal" else 0.0
    solid = Solid(stiffness * p, kappa_e, m0, 2.5 / m0, 0.0, gruneisen)
    return Constant(fluid, solid, 1.5, 0.8, stretch)


#: points of a layer; those at the interface that change, and those whose rates are compared
POINTS, COLUMNS, ROWS = 33, 20, 8


def sandwich(state):
    """Gas | solid | gas between walls, in a constant state."""

    def gas(X):
        one = np.ones(X.shape)
        return [state.rho * one, 0.0 * X, state.T * one]

    def solid(X):
        one = np.ones(X.shape)
        return [0.0 * X, state.stress * one, state.T * one, 1.0 + state.stretch * (X - 1.0)]

    layers = (
        FluidLayer("left", state.gas, (0.0, 1.0), gas),
        SolidLayer("solid", state.solid, (1.0, 2.0), solid),
        FluidLayer("right", state.gas, (2.0, 3.0), gas),
    )
    return Problem(layers, Wall(0.0), Wall(2.0 + state.stretch), units="none")


def theory(raw, projection, state, order, change):
    """Rates of what the conditions make of a change of (rho, u, T; u, S, T), (6, POINTS)."""
    h, op = 1 / (POINTS - 1), operator(order)
    root = np.sqrt(h * np.outer(state.weights, op.norm_weights(POINTS))).ravel()
    made = projection @ (root * change.ravel()) / root
    rates = (raw @ (root * made) / root).reshape(6, POINTS)
    heat = state.solid.alpha * state.solid.m0  # and what the stress sets free
    rates[5] += state.stress / heat * op.matrix(POINTS, h) @ made.reshape(6, POINTS)[3]
    return rates


def solver_rates(state, constant, order):
    """The solver's rates of changes (rho, u, T; u, S, T), (6, POINTS), in gas 2 and solid 1."""
    start, cv = state.solution.getArray().copy(), constant.gas.cv
    D = operator(order).matrix(POINTS, 1 / (POINTS - 1))
    stiffness = constant.modulus - constant.solid.K / constant.stretch

    def rates(change):
        y, f = start.copy(), np.empty_like(start)
        solid, fluid = (state.layers[i].of(y) for i in (1, 2))
        rho, u, T = constant.rho + change[0], change[1], constant.T + change[2]
        fluid[:POINTS] = np.stack([rho, rho * u, rho * (cv * T + 0.5 * u * u)], axis=-1)
        solid[:, :3] += change[3:].T
        state.right_hand_side(y, f)
        solid_t, fluid_t = state.layers[1].of(f), state.layers[2].of(f)[:POINTS]
        rho, m, E = state.layers[2].owned[:POINTS].T  # as the conditions made it
        rho_t, m_t, E_t = fluid_t.T
        u, u_t = m / rho, (m_t - m / rho * rho_t) / rho
        T_t = ((E_t - E / rho * rho_t) / rho - u * u_t) / cv
        S_t = solid_t[:, 1] + stiffness * (D @ solid_t[:, 3])
        return np.array([rho_t, u_t, T_t, solid_t[:, 0], S_t, solid_t[:, 2]])

    return rates


@pytest.mark.parametrize(
    ("order", "coupling", "narrow"),
    [
        (8, "projection", False),
        (6, "energy", False),
        (4, "traditional", False),
        pytest.param(6, "energy", True, marks=pytest.mark.long),
    ],
)
def test_the_linear_scheme_is_the_derivative_of_the_right_hand_side(order, coupling, narrow):
    """For each unknown, near the interface; the solid has a pressure, is strained, in balance."""
    gas, solid = Fluid(0.01, 0.03, 1.4, 1.0), Solid(3.0, 0.02, 2.0, 1.2, gruneisen=0.4)
    constant, h = Constant(gas, solid, 1.5, 0.8, 1.1), 1 / (POINTS - 1)
    opt = {**defaults(load_case("rod")), "fsi_order": order, "fsi_h": h, "fsi_coupling": coupling}
    opt["fsi_viscous"] = "narrow" if narrow else "wide"
    raw, projection, _ = assemble(constant, order, POINTS, h, coupling, narrow)
    random, size = np.random.default_rng(order), constant.scales[:, None]
    with PaperState(MPI.COMM_SELF, sandwich(constant), opt) as state:
        state.set_initial()
        rates = solver_rates(state, constant, order)
        for c, begin in product(range(6), range(0, COLUMNS, 4)):
            change = np.zeros((6, POINTS))
            change[c, begin : begin + 4] = 2.0**-8 * size[c] * random.uniform(0.3, 1, 4)
            if c >= 3:
                change = change[:, ::-1]
            pairs = [rates(m * change) - rates(-m * change) for m in range(1, 5)]
            wanted = theory(raw, projection, constant, order, change) / size
            wrong = np.tensordot(CENTRAL, pairs, 1) / size - wanted
            near = np.array([*wrong[:3, :ROWS], *wrong[3:, -ROWS:]])
            assert np.abs(near).max() < 1e-8 * np.abs(wanted).max(), (c, begin, near)


@ORDERS
@pytest.mark.parametrize("state", [{"stretch": 0.7}, {"eos": "elastic"}, INVISCID])
def test_theorem_4_1_holds_to_round_off(order, state):
    kinds = ("energy", False), ("energy", True), ("conservative", False)
    for (coupling, narrow), (density, stiffness) in product(kinds, RATIOS):
        result = measure(constant(density, stiffness, **state), order, N, 1 / N, coupling, narrow)
        assert result.estimate and result.stable and result.step_kept
        assert result.energy < 1e-12
        if (coupling, narrow) == ("energy", False) and state is not INVISCID:
            assert 0.99 < result.step_ratio < 1.01


@ORDERS
def test_projection_and_traditional(order):
    """The one has no growing mode, though energy may grow; the other fails for light solids."""
    for density, stiffness in RATIOS:
        state = constant(density, stiffness, "elastic")
        result = measure(state, order, 2 * N, 0.5 / N, "projection")
        assert result.energy > 1e-4 and result.stable and result.step_kept
    light, heavy = (
        measure(constant(density, 1.0), order, N, 1 / N, "traditional") for density in (1e-3, 1e3)
    )
    assert light.energy > 1.0 and light.step_ratio < 0.4 and heavy.step_kept


NAMES = ("2/1", "4/2", "6/3", "8/4")
SMALL = "-sweep -stability_points 16 -density_ratios 1e-3,1 -stiffness_ratios 0.01,100".split()


def counts(done):
    """Of each order, the numbers of combinations in which a promise is kept."""
    assert (done.returncode, done.stderr) == (0, "")
    lines = [line.split() for line in done.stdout.splitlines()]
    return [[words[k] for k in (1, 2, 4, 6)] for words in lines if words and words[0] in NAMES]


def test_sweep_with_energy_holds_everywhere_on_any_ranks(tmp_path):
    for ranks in (1, 2):
        done = solve("stability", *SMALL, "-fsi_output", ranks, cwd=tmp_path, ranks=ranks)
        assert counts(done) == [["4"] * 4] * 4
    rows = rows_of(tmp_path / "1.csv")
    assert len(rows) == 4 * 4 and rows == rows_of(tmp_path / "2.csv")
    assert all(row[n] == "True" for row in rows for n in ("estimate", "stable", "step_kept"))
