"""Fused steps in two dimensions against the classical Runge-Kutta method written out, with the rates of PETSc's methods."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from fsipetsc.boundaries.plane import Clamped, NoSlip, Open, Outflow, Slip
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.plane.grids import make_grids, share_out
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.plane.layer import GAINED
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer
from fsipetsc.scheme.plane.equations import USUAL, equations_of
from fsipetsc.stepping.plane import fused
from fsipetsc.stepping.plane.state import PlaneState

STEPS, DT = 3, 2e-3


def sticking(X, Y):
    return 1 + 0.1 * np.sin(2 * np.pi * X + Y), 0.2 * Y * (1 - Y), 0.1 * np.sin(2 * np.pi * X), 1 + 0.1 * Y


def periodic(slips):
    """gas | solid, between a wall and where the solid is clamped."""
    gas = Fluid(0.0, 0.0, 1.4, 1.0) if slips else Fluid(0.02, 0.03, 1.4, 1.0)
    solid = PlaneSolid(1.0, 2.0, 0.05, 2.0, 1.5, p_ref=1.0)
    layers = (
        PlaneFluidLayer("gas", gas, (0.0, 1.0), sticking),
        PlaneSolidLayer("solid", solid, (1.0, 2.0), lambda X, Y: (0 * X, 0.1 * np.sin(2 * np.pi * X), 1 + 0 * X, X, Y)),
    )
    return PlaneProblem(layers, (0.0, 1.0), NoSlip(T=1.1) if not slips else Slip(), Clamped(), units="none")


def panel():
    """A flow over a panel in a wall."""
    gas, solid = Fluid(0.0, 0.0, 1.4, 1.0), PlaneSolid(5.0, 10.0, 0.0, 3.0, 1.0, p_ref=1.0, heat="elastic")
    outside = Open(1.0, 2.5, 0.0, 1.0)
    layers = (
        PlaneSolidLayer(
            *("panel", solid, (-0.5, 0.0), lambda X, Y: (0 * X, 0.1 * np.sin(np.pi * X), 1 + 0 * X, X, Y)),
            **{"X": (0.0, 1.0), "left": Clamped(), "right": Clamped()},
        ),
        PlaneFluidLayer(
            *("gas", gas, (0.0, 1.0), lambda X, Y: (1 + 0 * X, 2.5 + 0 * X, 0 * X, 1 + 0 * X)),
            **{"left": outside, "right": Outflow(), "beside": Slip()},
        ),
    )
    return PlaneProblem(layers, (-0.5, 1.5), Clamped(), outside, units="none")


def classical(state, y, dt):
    """A step of y, completed."""
    path, k, total = state.path, np.empty_like(y), y.copy()
    stage = y
    for a, b in ((0.5, 1 / 6), (0.5, 1 / 3), (1.0, 1 / 3), (0.0, 1 / 6)):
        path.rates(stage, k, 0.0)
        total, stage = total + b * dt * k, y + a * dt * k
    path.project(total, 0.0)
    total[path.gains[:, None] + np.arange(GAINED)] = 0.0  # what layers have gained has been taken
    return total


def test_a_solid_in_which_no_heat_is_made_or_goes():
    """Its own equations leave the heat out; with a conductivity that changes nothing it is as all others."""
    problem = panel()
    found = []
    for kappa_e in (0.0, 1e-300):
        layer = replace(problem.layers[0], material=replace(problem.layers[0].material, kappa_e=kappa_e))
        with PlaneState(MPI.COMM_SELF, replace(problem, layers=(layer, problem.layers[1])), 4, 1 / 12) as state:
            state.set_initial()
            state.finish()
            state.step(0.0, DT, True)
            found.append(state.layout.local(0, state.solution.getArray()).copy())
    assert len(equations_of(layer, USUAL).fluxes) == 3 and len(equations_of(problem.layers[0], USUAL).fluxes) == 2
    assert np.abs(found[0] - found[1]).max() < 1e-14
    assert 0.0 < np.abs(found[0][..., 4] - 1.0).max() < 1e-9  # what the step would have lost of the energy


@pytest.mark.parametrize(
    ("h", "mode", "ranks"),
    [(1 / 128, "auto", [(0, 1), (0, 1)]), (1 / 32, "auto", [(1,), (0,)]), (1 / 32, "balanced", [(0, 1), (0, 1)])],
)
def test_shares(h, mode, ranks):
    """Of two ranks; those of large grids have as much of each layer."""
    grids = make_grids(panel(), OPERATORS[4], h)
    shares = share_out(grids, ["solid", "fluid"], OPERATORS[4], 2, mode)
    assert [share.ranks for share in shares] in (ranks, ranks[::-1])
    for share, grid in zip(shares, grids, strict=True):
        sizes = [(b - a) * (d - c) for a, b, c, d in map(share.block, share.ranks)]
        assert sum(sizes) == grid.nx * grid.ny and max(sizes) - min(sizes) <= max(grid.nx, grid.ny)


def test_too_many_ranks_for_even_shares():
    with pytest.raises(InputError, match=r"balanced: 4000 ranks .* \d+ is the largest"):
        share_out(make_grids(panel(), OPERATORS[4], 1 / 32), ["solid", "fluid"], OPERATORS[4], 4000, "balanced")


@pytest.mark.parametrize("problem", [periodic(False), periodic(True), panel()], ids=["sticks", "slips", "panel"])
def test_a_fused_step_is_the_classical_method(problem):
    """But for what the temperature of the solid gets of the energy that this one loses."""
    with PlaneState(MPI.COMM_SELF, problem, 4, 1 / 12) as state:
        state.set_initial()
        state.finish()
        expected = state.solution.getArray().copy()
        for _ in range(STEPS):
            expected = classical(state, expected, DT)
        state.set_initial()
        state.finish()
        before = state.solution.getArray().copy()
        for step in range(STEPS):
            state.step(step * DT, DT, True)
        found, heat = state.solution.getArray().copy(), 0.0
        for k, layer in enumerate(problem.layers):
            if layer.kind == "solid":
                T, other = (state.layout.local(k, of)[..., 4] for of in (found, expected))
                heat, T[:] = np.abs(T - other).max(), other
        assert 0.0 < heat < 1e-9
        assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()
        assert np.abs(found - before).max() > 1e-3  # or it would be no test
        assert state.evaluations == 4 * STEPS


@pytest.mark.parametrize("problem", [periodic(False), periodic(True)], ids=["sticks", "slips"])
def test_a_program_makes_the_steps_that_python_makes(problem, monkeypatch):
    """From the second one on, with the same bits."""
    found = []
    for warm in (1, 1000):
        monkeypatch.setattr(fused, "WARM", warm)
        with PlaneState(MPI.COMM_SELF, problem, 4, 1 / 12) as state:
            state.set_initial()
            state.finish()
            for step in range(4):
                state.step(step * DT, DT * (1 + step / 7), True)
            found.append(state.solution.getArray().copy())
    assert np.array_equal(*found)
