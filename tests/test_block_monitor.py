"""What is seen of blocks after a step: bounds, the plan, losses of solids, a bad state."""

import block_shapes as shapes
import numpy as np
import pytest
from block_ledgers import CLOSED, N, Steps, complete, gas, problem_of, rates, solid

from fsipetsc.blocks.conditions import Free
from fsipetsc.operators.sbp import STIFFNESS_OF_WIDE
from fsipetsc.scheme import plan
from fsipetsc.scheme.observables import INTEGRAL, SERIES
from fsipetsc.stepping.notes import first_bad


def warped(mu):
    """Gas whose grid moves and a solid, on a shape that is warped."""
    shape = shapes.warped(shapes.layers(N + 1, False), 0.03)
    return problem_of(shape, CLOSED, gas(mu=mu), solid(heat="coupled" if mu else "elastic"))


def bounds_of(run, k):
    """The largest rates of convection and diffusion of a block, by formulas on whole arrays."""
    part, q, d = run.parts[k], run.owned(k), run.problem.dimension
    metrics, equations, cells = part.metrics[:, part.owned], part.laws, part.block.cells
    areas = metrics[: d * d].reshape(d, d, -1) * np.reshape(cells, (d, 1, 1))
    squares = (areas**2).sum(axis=1)
    if run.problem.blocks[k].kind == "solid":
        F, v = tuple(part.F), tuple(q[:, d : 2 * d].T)
        T = equations.temperature(v, q[:, 2 * d], F)
        nodes = zip(zip(*F), T, strict=True)
        c2 = np.array([equations.wave_modulus_at(*node) for node in nodes]) / equations.m0
        spread = squares.sum(axis=0) / metrics[d * d] ** 2
        nu = equations.kappa / (equations.m0 * equations.alpha)
        return np.sqrt((c2 * spread).max()), STIFFNESS_OF_WIDE * nu * spread.max()
    w, J = equations.primitive(tuple(q.T)), q[:, 0]
    relative = np.array(equations.velocity(w)) - metrics[d * d : d * d + d]
    across = np.abs((areas * relative).sum(axis=1))
    waves = (across + equations.speed_of_sound(w) * np.sqrt(squares)).sum(axis=0) / J
    nu = 4.0 / 3.0 * equations.mu / w[0], equations.kappa / equations.law.heat_capacity(w[0], w[2])
    nu = np.maximum(nu[0], nu[1] / w[0])
    return waves.max(), (STIFFNESS_OF_WIDE * nu * squares.sum(axis=0) / J**2).max()


@pytest.mark.parametrize("shock", [0.0, 2.0])
def test_what_bounds_a_step(shock):
    with Steps(warped(0.02), fsi_shock=shock) as run:
        run.step(2e-3, 2)
        expected = np.array([bounds_of(run, k) for k in range(2)]) * [shock or 1.0, 1.0]
        np.testing.assert_allclose(run.bounds, expected, rtol=1e-12)
        assert run.results[plan.RATE] == pytest.approx((run.bounds.max(axis=0) ** 4).sum() ** 0.25)
        assert run.results[plan.BAD] == 0.0 and run.bounds.min() > 0.0
        part = run.parts[0]
        least = (run.owned(0)[:, 0] / part.reference).min()
        assert run.latest["least_J"][0] == pytest.approx(least, rel=1e-14)
        assert np.abs(part.metrics[4:6]).max() > 0.01  # its grid moves
        run.owned(0)[5] *= 0.9  # its J departs from the grid, its density does not
        run.complete()
        assert run.latest["J_error"][0] == pytest.approx(0.1, rel=1e-6)


def test_each_integral_has_its_formula():
    """One without would be 0 without a word."""
    with Steps(warped(0.0)) as run:
        texts = "".join(part.code.text for part in run.parts.values())
        names = {n for n in run.latest.dtype.names if SERIES[n].kind == INTEGRAL}
        assert names == {n for n in names if f"found_latest[part_columns_{n}] =" in texts} != set()


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_what_is_saved_of_a_solid_with_prestress(heat):
    """v, T and x; the stress is (P + S) F^T / J; e has the energy of both with heat 'elastic'."""
    more = {
        "initial": lambda X, Y: (0.1, -0.2, 1.5 + 0.0 * X, 1.1 * X, 0.9 * Y),
        "prestress": lambda X, Y: (0.3 * X, 0.1, -0.2 * Y, 0.4),
    }
    plate, shape = solid(heat=heat), {"solid": shapes.box((0, 0), (1, 2), 9, 10)}
    with Steps(problem_of(shape, {"solid": Free()}, None, plate, solid=more), 4) as run:
        found, latest, (X, Y) = run.saved(0), run.latest, run.parts[0].X
    assert np.abs(found[:, :3] - [0.1, -0.2, 1.5]).max() < 1e-12
    assert np.abs(found[:, -2:] - np.array([1.1 * X, 0.9 * Y]).T).max() < 1e-13
    F, S = np.diag([1.1, 0.9]), np.array([[0.3 * X, 0.1 + 0 * X], [-0.2 * Y, 0.4 + 0 * X]])
    law = plate.solid_law
    P = np.array(law.stress(tuple(F.ravel()))).reshape(2, 2, 1) + S
    cauchy = np.einsum("ijn,kj->ikn", P, F) / 0.99
    assert np.abs(found[:, 3:6].T - [*cauchy[0], cauchy[1, 1]]).max() < 1e-12
    mechanical = 2.0 * plate.m0 * 0.025
    if heat == "elastic":  # with the integrals of W and of S : (F - 1)
        mechanical += 2.0 * law.energy(tuple(F.ravel())) + 0.03 - 0.08
        assert latest["solid_energy"] == pytest.approx(mechanical, rel=1e-12)
    warmth = 2.0 * plate.m0 * plate.alpha * 1.5
    assert latest["energy"] == pytest.approx(warmth + mechanical, rel=1e-12)


def swung(dt):
    """A solid that swings: its energy at first, what is lost of it, change of all energy."""
    shape = {"solid": shapes.box((0, 0), (1, 1), 11, 11)}
    with Steps(problem_of(shape, CLOSED, None, solid()), 4) as run:
        first, energy = float(run.latest["solid_energy"]), run.integrals()[-1]
        run.step(dt, round(1.0 / dt))
        assert run.lost() == pytest.approx(first - float(run.latest["solid_energy"]), abs=1e-14)
        return first, run.lost(), run.integrals()[-1] / energy - 1.0


def test_what_steps_lose_falls_with_their_order():
    """By the fifth power of the step; all of the energy stays."""
    first, coarse, change = swung(0.01)
    _, fine, _ = swung(0.005)
    assert abs(change) < 1e-14 and 1e-10 * first < fine < coarse
    assert 4.5 < np.log2(coarse / fine) < 5.5


def test_a_bad_state_leaves_nothing_behind(viscosity=0.02):
    """After a step that fails, rates have the bits that they had before."""
    with Steps(warped(viscosity), fsi_dissipation=1.0, fsi_shock=1.0) as run:
        good, found = run.y.copy(), np.zeros((3, run.y.size))
        for k, f in enumerate(found):
            run.y[:] = good
            complete(run, 0.0, run.y)
            rates(run, 0.0, run.y, f)
            if k < 2:  # one block is enough
                run.owned(k)[:] = np.nan
                run.finish()
                assert run.results[plan.BAD] == 1.0 or np.isnan(run.results[plan.RATE])
                rates(run, 0.0, run.y, np.zeros_like(f))
                run.begin()
    for f in found:
        np.testing.assert_array_equal(f, found[0])
    assert np.isfinite(found).all() and found.any()


def test_a_batch_ends_with_a_bad_step_whose_first_bad_stage_is_found():
    """Steps in one call also hand on what a rank says of stopping."""
    shape = {"gas": shapes.box((0.0,), (1.0,), 21)}
    with Steps(problem_of(shape, CLOSED, gas(1), None)) as run:
        run.results[plan.SAID_STOP] = 2.0
        run.step(1e-3)
        assert run.results[plan.STOP] == 2.0 and run.results[plan.BAD] == 0.0
        start = run.y.copy()
        run.step(1e3)
        assert run.results[plan.BAD] == 1.0
        run.go_back()
        assert np.array_equal(run.y, start)
        found = run.repeat(lambda: first_bad(run))
        assert found.startswith(("rho = -", "T = -")) and "in layer 'gas' at x = " in found
