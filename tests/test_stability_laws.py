"""The linear theory of other laws: the linearised scheme is the derivative of the solver's right-hand side; cases as input."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("scipy")
pytest.importorskip("petsc4py")

from dataclasses import replace

import materials
from helpers import REPOSITORY, solve
from mpi4py import MPI
from paper_parts import conserved, primitive

from fsipetsc.analysis.spectra import CENTRAL
from fsipetsc.analysis.stability_linear import assemble, measure
from fsipetsc.analysis.stability_state import Constant, at_rest, of_problem
from fsipetsc.boundaries import Wall
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.own import gas_law
from fsipetsc.materials.solid_pressure import mie_gruneisen
from fsipetsc.operators import operator
from fsipetsc.paper.state import PaperState
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

#: points of a layer; those at the interface whose rates are compared, and those on which they may depend
N, ROWS, COLUMNS = 33, 8, 20
COUPLINGS = ("projection", "energy", "traditional")


def five_layers() -> Problem:
    """The materials of materials.py, at rest at one pressure and temperature."""
    return Problem(materials.fall().layers, Wall(0.0), Wall(5.0), units="none")


def built_in() -> Problem:
    """gas | solid | gas with viscosity; the solid has a pressure, is strained, and in balance."""
    gas, solid = Fluid(0.01, 0.03, 1.4, 1.0), Solid(3.0, 0.02, 2.0, 1.2, gruneisen=0.4)
    stress = solid.pressure(0.8, 1.1) - 1.2

    def air(X):
        return [1.5 + 0 * X, 0 * X, 0.8 + 0 * X]

    layers = (
        FluidLayer("left", gas, (0.0, 1.0), air),
        SolidLayer("bar", solid, (1.0, 2.0), lambda X: [0 * X, stress + 0 * X, 0.8 + 0 * X, 1 + 1.1 * (X - 1)]),
        FluidLayer("right", gas, (2.0, 3.0), air),
    )
    return Problem(layers, Wall(0.0), Wall(3.1), units="none")


def expected(state: Constant, order: int, coupling: str, narrow: bool) -> np.ndarray:
    """The derivative of the rates of what the conditions make of (rho, u, T; u, S, T), by the linear theory, (6, N, 6, N)."""
    h = 1 / (N - 1)
    linear = assemble(state, order, N, h, coupling, narrow)
    root = np.sqrt(h * np.outer(state.weights, operator(order).norm_weights(N))).ravel()
    found = (linear.raw + linear.heating) @ linear.projection
    return (found / root[:, None] * root).reshape(6, N, 6, N)


def solver_rates(state: PaperState, k: int, constant: Constant, order: int) -> Callable[[np.ndarray], np.ndarray]:
    """(6, N) changes of (rho, u, T) in gas k and (u, S, T) in solid k - 1 -> (6, N) rates of the same, by the solver."""
    start = state.solution.getArray().copy()
    gas, D = state.layers[k].law, operator(order).matrix(N, 1 / (N - 1))

    def rates(change: np.ndarray) -> np.ndarray:
        y, f = start.copy(), np.empty_like(start)
        solid, fluid = (state.layout.local(i, y) for i in (k - 1, k))
        fluid[:N] = conserved(gas, constant.rho + change[0], change[1], constant.T + change[2])
        solid[:, :3] += change[3:].T
        state.right_hand_side(y, f)
        solid_t, fluid_t = state.layout.local(k - 1, f), state.layout.local(k, f)[:N]
        rho, u, T = primitive(gas, state.layers[k].owned[:N])  # as the conditions have made it
        rho_t, m_t, E_t = fluid_t.T
        u_t, cv = (m_t - u * rho_t) / rho, constant.gas.cv
        T_t = ((E_t - (cv * T + 0.5 * u * u) * rho_t) / rho - u * u_t) / cv
        S_t = solid_t[:, 1] + constant.stiffness / constant.stretch * (D @ solid_t[:, 3])
        return np.array([rho_t, u_t, T_t, solid_t[:, 0], S_t, solid_t[:, 2]])

    return rates


def compare(problem: Problem, k: int, order: int, coupling: str, narrow: bool = False) -> None:
    """At the interface between solid k - 1 and gas k."""
    h = 1 / (N - 1)
    constant = of_problem(problem, problem.interfaces.index((k, k - 1)), h)
    wanted = expected(constant, order, coupling, narrow)
    unit = constant.scales[:, None, None, None] / constant.scales[:, None]  # of derivatives, where all are alike
    at = [np.arange(COLUMNS)] * 3 + [N - 1 - np.arange(COLUMNS)] * 3
    with PaperState(MPI.COMM_SELF, problem, order, h, coupling, "auto", 0, False, narrow) as state:
        state.set_initial()
        rates = solver_rates(state, k, constant, order)
        for c, j in ((row, j) for row in range(6) for j in at[row]):
            change = np.zeros((6, N))
            change[c, j] = 2.0**-8 * constant.scales[c]
            found = sum(w * (rates(m * change) - rates(-m * change)) for m, w in enumerate(CENTRAL, 1)) / change[c, j]
            wrong = (found - wanted[:, :, c, j]) / unit[:, :, c, 0]
            near = np.array([wrong[i, at[i][:ROWS]] for i in range(6)])
            assert np.abs(near).max() < 1e-8 * np.abs(wanted / unit).max(), (c, j, near)


@pytest.mark.parametrize(("order", "coupling"), list(zip((8, 6, 4), COUPLINGS)))
def test_the_linear_scheme_is_the_derivative_of_the_right_hand_side(order, coupling):
    """Of Mie's and Grüneisen's solid and Sutherland's gas."""
    gas, solid, air = five_layers().layers[:3]
    shifted = replace(air, X=(air.X[0], air.X[1]))
    compare(Problem((gas, solid, shifted), Wall(gas.X[0]), Wall(air.X[1]), units="none"), 2, order, coupling)


@pytest.mark.parametrize("narrow", [False, pytest.param(True, marks=pytest.mark.long)], ids=["wide", "narrow"])
@pytest.mark.parametrize(("order", "coupling"), [(4, "projection"), (6, "energy")])
def test_so_it_is_of_a_strained_solid_with_either_second_derivative(order, coupling, narrow):
    compare(built_in(), 2, order, coupling, narrow)


@pytest.mark.parametrize("order", [2, 4, 6, 8])
@pytest.mark.parametrize("k", [1, 3])
@pytest.mark.parametrize("coupling", ["energy", "conservative"])
def test_the_energy_never_grows_with_other_laws(order, coupling, k):
    """But for the heating by c T - p, which is the equations'."""
    result = measure(of_problem(five_layers(), k, 1 / 16), order, 16, 1 / 16, coupling)
    assert result.estimate and result.energy < 1e-12
    assert result.step_kept


def test_what_the_theory_is_not_about_is_said():
    gas, solid = Fluid(0.0, 0.0, 1.4, 1.0), Solid(1.0, 0.0, 1.0, 1.0)
    mie = replace(solid, pressing=mie_gruneisen(2.0, 1.3, 0.0, 1.0))
    apart = replace(gas, law=van_der_waals_without_its_energy())
    for make, words in (
        (lambda: at_rest(gas, replace(mie, K=0.1), 1.0, 1.0, 2.5), "x_X = 2.5: (K - x_X p_x) / x_X of the solid is "),
        (lambda: at_rest(apart, solid, 1.0, 1.0), "the law of the gas: rho^2 de/drho is 0 Pa and p - T dp/dT -0.1 Pa"),
        (lambda: of_problem(five_layers(), 4, 0.1), "-stability_interface 4: expected a number from 0 to 3"),
        (lambda: of_problem(Problem(five_layers().layers[:1], Wall(0.0), Wall(1.0)), 0, 0.1), "this case has none"),
    ):
        with pytest.raises(InputError) as found:
            make()
        assert words in str(found.value)


def van_der_waals_without_its_energy():
    """p = rho T - 0.1 rho^2, and an energy that does not belong to it."""
    return gas_law(
        temperature=lambda rho, e: e,
        internal_energy=lambda rho, T: T,
        pressure=lambda rho, T: rho * T - 0.1 * rho * rho,
        density=lambda p, T: p / T,
        temperature_of=lambda rho, p: p / rho + 0.1 * rho,
        heat_capacity=lambda rho, T: 1.0 + 0.0 * T,
        pressure_by_temperature=lambda rho, T: rho,
        bulk_modulus=lambda rho, T: rho * T - 0.2 * rho * rho,
    )


def test_the_command_takes_a_case(tmp_path):
    case = str(REPOSITORY / "tests" / "materials.py")
    words = ("-materials_state", "column", "-stability_interface", "2", "-stability_points", "16", "-fsi_h", "0.05")
    done = solve("stability", case, *words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "StiffenedPressure (1.5, 4, 3, 1)" in done.stdout and "Sutherland (8, 2, 2)" in done.stdout
    assert done.stdout.count("energy never grows") == 4 and "stability of conservative" in done.stdout
    assert "-stability_interface" in solve("stability", "box", "-help", cwd=tmp_path).stdout
    for words, said in (
        (("mms",), "layers 'left' and 'solid' begin with T = "),
        (("box", "-stability_interface", "7"), "-stability_interface 7: expected a number from 0 to"),
        (("box", "-solid_gamma", "1"), "-solid_gamma"),
    ):
        done = solve("stability", *words, cwd=tmp_path)
        assert done.returncode == 2 and said in done.stderr and done.stderr.count("\n") == 1, done.stderr
