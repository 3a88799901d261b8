"""A constant force on a gas: rest and energy stay, and entropy; small motions do not grow."""

import numpy as np
import pytest
import test_block_oracle as flat
from block_ledgers import Steps, problem_of
from oracle_engine import Engine
from oracle_formulas import Gas, spread

from fsipetsc.blocks.conditions import Slip
from fsipetsc.materials.fluid import Fluid

FORCES = {1: (0.7,), 2: (0.3, -0.7), 3: (0.3, -0.7, 0.2)}
SMOOTH, DAMPED = {"dissipation": 0.3}, {"dissipation": 0.3, "shock": 0.7}
STIFFENED = {"gamma": 3.0, "R": 0.7, "p_inf": 2.0}
LINKED = {"shock": 1.0}


def oracle_of(shape, order, numbers, options):
    """Of gas alone in a shape, with the force of its dimension."""
    blocks = flat.SHAPES[shape](flat.NODES[order])
    force = FORCES[{"line": 1, "three": 3}.get(shape, 2)]
    return flat.made(blocks, Gas(force=force, **numbers), None, order, **options)


def at_rest(oracle):
    """A gas of uniform temperature at rest, with J of any size."""
    q, rng, T = {}, np.random.default_rng(1), 0.9
    for k, b in enumerate(oracle.blocks):
        m = b.material
        rho = 1.3 * np.exp(np.tensordot(m.force, b.X, 1) / (m.R * T))
        U = [1.0 + 0.0 * rho, rho, *(0.0 * b.X), rho * m.cv * T + m.p_inf]
        q[b.name] = oracle.start(k) * rng.uniform(0.8, 1.2, rho.shape) * np.array(U)
    return q


@pytest.mark.parametrize(
    ("shape", "order", "options", "numbers"),
    [
        *(("line", 2, {}, {}), ("line", 6, DAMPED, {}), ("disk", 8, DAMPED, {})),
        ("square", 4, LINKED, STIFFENED),
        ("ring", 4, DAMPED, {"mu": 0.02, "kappa": 0.03}),
        ("three", 2, DAMPED, STIFFENED),
    ],
)
def test_a_gas_of_one_temperature_stays_at_rest(shape, order, options, numbers):
    """Joined blocks, bent grids; also where the sensor of shocks sees steep gradients."""
    oracle = oracle_of(shape, order, numbers, options)
    for k, r in enumerate(Engine(oracle).rates(at_rest(oracle)).values()):
        assert np.abs(r[1:] / oracle.start(k)).max() < 1e-12 * flat.NODES[order]


@pytest.mark.parametrize(
    ("shape", "order", "numbers", "options"),
    [
        *(("line", 4, STIFFENED, options) for options in (SMOOTH, LINKED)),
        *(("line", 8, {}, {}), ("square", 4, {}, DAMPED), ("three", 2, STIFFENED, {})),
    ],
)
def test_energy_stays_with_potential_energy(shape, order, numbers, options):
    """At random states of a gas whose grid is at rest; entropy stays, or grows by dissipation."""
    oracle = oracle_of(shape, order, numbers, options)
    q = oracle.complete(oracle.random_state(np.random.default_rng(0)))
    rates = Engine(oracle).rates(q)
    found, size = flat.derivatives(oracle, q, rates)
    for k, (b, r) in enumerate(zip(oracle.blocks, rates.values())):
        height = (spread(b.material.force, oracle.d) * b.X).sum(axis=0)
        found["energy"] -= (oracle.W[k] * r[1] * height).sum()
    assert max(abs(found["mass"]), abs(found["energy"])) < 1e-13 * size
    if options:
        assert found["entropy"] > 1e-4 * size  # of what is far apart little diffuses: 1 + eta
    else:
        assert abs(found["entropy"]) < 1e-13 * size


@pytest.mark.parametrize("convection", ["entropy", "divergence"])
def test_ledgers(convection):
    """The series of a run have potential energy and the work of the force."""
    shape = flat.shapes.warped(flat.shapes.boxes(7, (0.0, 1.0, 2.0), (0.0, 1.0), None))
    gas = Fluid(0.0, 0.0, 1.4, 1.0, force=FORCES[2])
    problem = problem_of(shape, {"gas": Slip()}, gas, None)
    with Steps(problem, fsi_convection=convection, fsi_dissipation=1.0, fsi_shock=1.0) as run:
        before = run.latest.copy()
        run.step(2e-2, 10)
        after, work = run.latest, run.of_faces("force_work")[0]
    assert before["potential_energy"] == pytest.approx(-(0.3 * 1.0 - 0.7 * 0.5) * 2.05, rel=0.2)
    change = after["potential_energy"] - before["potential_energy"]
    assert abs(change) > 1e-3
    exact = 1e-13 * before["energy"]
    assert abs(after["energy"] - before["energy"] - work) < exact
    assert (abs(change + work) < exact) == (convection == "entropy")


@pytest.mark.parametrize("order", [2, 6])
def test_small_motions_do_not_grow(order):
    """In a column, whose force is made node by node by the divergence form, they do."""

    def fastest(form):
        shape = {"gas": flat.shapes.box((0.0,), (1.2,), 16)}
        oracle = flat.made(shape, Gas(force=FORCES[1]), None, order, form=form)
        engine, q = Engine(oracle), at_rest(oracle)["gas"]
        columns = []
        for k, n in np.ndindex(q[1:].shape):
            sides = [q.copy(), q.copy()]
            for sign, side in zip((1.0, -1.0), sides, strict=True):
                side[1 + k, n] += sign * 1e-5 * q[0, n]
            up, down = (engine.rates({"gas": side})["gas"][1:] for side in sides)
            columns.append((up - down).reshape(-1) / (2e-5 * q[0, n]))
        return np.linalg.eigvals(np.array(columns).T).real.max()

    assert fastest("entropy") < 1e-6
    assert order > 2 or fastest("divergence") > 1e-4
