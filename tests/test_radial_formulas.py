"""The scheme with an axis or a centre, as the oracle has it: what holds at any state and order."""

from __future__ import annotations

import block_shapes as shapes
import numpy as np
import pytest
from oracle_formulas import Block, Clamped, Gas, Problem, Slip, Solid
from oracle_radial import Radial
from test_block_oracle import NODES, SLIPPING, STICKING, derivatives

ORDERS = pytest.mark.parametrize("order", [2, 4, 6, 8])
KAPPA = pytest.mark.parametrize("kappa", [0, 1, 2])


def shell(n, centre):
    """A shell in gas, with gas inside to the centre, or from 0.4."""
    inside = shapes.box((-1.0,), (1.0,), 2 * n) if centre else shapes.box((0.4,), (1.0,), n)
    outer = {"solid": shapes.box((1.0,), (1.3,), n), "gas around": shapes.box((1.3,), (2.0,), n)}
    if not centre:
        return {"gas inside": inside, **outer}
    mirrored = {
        "solid mirrored": shapes.box((-1.3,), (-1.0,), n),
        "gas mirrored": shapes.box((-2.0,), (-1.3,), n),
    }
    return {"gas inside": inside, **outer, **mirrored}


def radial(shape, gas, solid, order, kappa, **options):
    """The oracle of a shape, closed."""
    blocks = [
        Block(name, gas if name.startswith("gas") else solid, X, periods)
        for name, (X, periods) in shape.items()
    ]
    closed = lambda owner: Clamped() if owner[0].startswith("solid") else Slip()  # noqa: E731
    return Radial(Problem(tuple(blocks), closed, order, **options), kappa)


def mirrored(oracle, q):
    """q with the states of r > 0 at -r: densities and energies are even, velocities are odd."""
    places = {
        "gas inside": "gas inside",
        "gas mirrored": "gas around",
        "solid mirrored": "solid",
    }
    found = dict(q)
    for name, of in places.items():
        odd = np.array([-1.0, -1.0, 1.0] if of == "solid" else [1.0, 1.0, -1.0, 1.0])
        image = odd[:, None] * q[of][:, ::-1]
        half = q[of].shape[1] // 2
        found[name] = (
            np.concatenate([image[:, :half], q[of][:, half:]], axis=1) if name == of else image
        )
    return found


def sums(oracle, centre):
    """Rates of mass, energy and entropy over the size of the energy's parts, at a random state."""
    q = oracle.random_state(np.random.default_rng(oracle.problem.order))
    if centre:
        q = mirrored(oracle, q)
    q = oracle.complete(q)
    found, size = derivatives(oracle, q, oracle.rates(q))
    assert size > 0.1  # or it would be no test
    return [found[key] / size for key in ("mass", "energy", "entropy")]


@ORDERS
@KAPPA
@pytest.mark.parametrize("centre", [False, True])
def test_sums_of_rates_at_random_states(order, kappa, centre):
    """Mass, energy, entropy of the inviscid gas; the entropy of the viscous gas grows."""
    shape = shell(NODES[order], centre)
    kept = sums(radial(shape, *SLIPPING, order, kappa), centre)
    assert np.abs(kept).max() < 1e-14
    *kept, grown = sums(radial(shape, *STICKING, order, kappa), centre)
    assert np.abs(kept).max() < 1e-14
    assert grown > 1e-3


@ORDERS
@KAPPA
def test_viscous_entropy_is_a_sum_of_squares(order, kappa):
    """Stresses times rates over T, of the radius and the hoops, and heat times its gradient."""
    mu, c = 0.02, 0.03
    shape = {"gas": shapes.box((0.4,), (2.0,), NODES[order])}
    oracle = radial(shape, Gas(mu=mu, kappa=c), None, order, kappa)
    q = oracle.complete(oracle.random_state(np.random.default_rng(order)))
    found, size = derivatives(oracle, q, oracle.rates(q))
    V, u = q["gas"][0], q["gas"][2] / q["gas"][1]
    T = (q["gas"][3] / q["gas"][1] - 0.5 * u * u) / oracle.blocks[0].material.cv
    a, (D, _, W) = oracle.blocks[0].X[0] ** kappa, oracle.axes[0][0]
    w = a / V * (D @ (-1.0 / T))
    rates = [T * (a / V * (D @ (u / T)) + u * w)]
    rates += [u / V * (D @ a) / kappa for _ in range(kappa)]
    squares = 2.0 * mu * (sum(e * e for e in rates) - sum(rates) ** 2 / 3.0) / T + c * (T * w) ** 2
    produced = (W * V * squares).sum()
    assert produced > 1e-3 * size
    assert abs(found["entropy"] - produced) < 1e-14 * size


@ORDERS
@KAPPA
@pytest.mark.parametrize("form", ["entropy", "divergence"])
def test_gas_at_rest_stays_on_any_moving_grid(order, kappa, form):
    """Of uniform pressure, with random volumes and velocities of the grid."""
    n, rng = NODES[order] + 2, np.random.default_rng(order)
    shape = {"gas": shapes.box((0.4,), (2.0,), n)}
    oracle = radial(shape, Gas(mu=0.1), None, order, kappa, form=form)
    q = oracle.uniform(1.3, 0.0, 0.9, rng)
    v = rng.uniform(-1.0, 1.0, (1, n))
    v[:, [0, -1]] = 0.0
    rates = oracle.rates(q, grid={"gas": (0.0 * v, v)})["gas"]
    U = q["gas"][1:] / q["gas"][0]
    assert np.abs(rates[0]).max() > 1.0
    assert np.abs(rates[1:] - U * rates[0]).max() < 1e-14 * np.abs(rates).max()


@ORDERS
@KAPPA
def test_solid_stretched_uniformly_is_balanced(order, kappa):
    """The stress of x = 1.2 X is uniform, and the traction at the ends holds it. D R^2 is 2 R at
    all nodes from order 4 on; with 2/1 it is not at the ends.
    """
    oracle = radial(
        {"solid": shapes.box((1.0,), (1.3,), NODES[order])}, None, Solid("svk"), order, kappa
    )
    X = oracle.blocks[0].X
    q = np.array([0.2 * X[0], 0.0 * X[0], 1.0 + 0.0 * X[0]])
    grid = oracle.grids({"solid": q}, 0.0)[0]
    _, force, *_ = oracle.solid_terms(0, q, grid, 0.0)
    pull = oracle.elastic(0, grid.x)[1][0, 0] * oracle.solids[0][0][0, 0]
    assert pull.min() > 0.5
    force[0, 0] -= pull[0]
    force[0, -1] += pull[-1]
    left = np.abs(force).max() / np.abs(pull).max()
    # round-off of places over spacings: 1.3e-13 without a weight; the defect of 2/1: 7e-4
    assert left > 5e-4 if (order, kappa) == (2, 2) else left < 1e-12
