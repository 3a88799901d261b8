"""A step that sweeps and `advance` share is that of the plain rates, node by node."""

import numpy as np
import pytest
import test_block_oracle as flat
import test_radial as radial
from block_ledgers import complete, rates
from oracle_engine import Engine
from oracle_formulas import Free, Gas, Solid

from fsipetsc.parallel.block_layout import BlockVector

#: as fractions of a step: where stages are, the weights of their rates
STAGES = (0.0, 1 / 6), (0.5, 1 / 3), (0.5, 1 / 3), (1.0, 1 / 6)
DT = 1e-4
FORCED = Gas(mu=0.02, force=(0.3, -0.2)), Solid("log", kappa=0.05, force=(0.3, -0.2))
PRESTRESSED = flat.ELASTIC[0], Solid("log", kappa=0.4, heat="elastic", force=(0.3, -0.7))


def flat_engine(shape, both, faces=flat.closed, n=9, **options):
    oracle = flat.made(flat.SHAPES[shape](n), *both, 4, faces, **options)
    return Engine(oracle), oracle.random_state(np.random.default_rng(n))


def radial_engine(d, kappa, centre):
    oracle = radial.radial(radial.shell(d, 12, centre), *flat.STICKING, 4, kappa)
    q = oracle.complete(radial.mirrored(oracle, oracle.random_state(np.random.default_rng(d))))
    return radial.engine_of(oracle, kappa, centre), radial.half_of(q, centre)


def on_faces(name):
    kinds = flat.FACES[name]
    return flat_engine("walls", flat.ELASTIC, lambda of: kinds.get(of, kinds.get(of[0])))


#: kind of problem -> engine and state, whether all nodes have something added to their rates
KINDS = {
    "line": (lambda: flat_engine("line", flat.STICKING), False),
    "periodic": (lambda: flat_engine("cell of three", flat.STICKING), False),
    "rings": (lambda: flat_engine("ring", flat.SLIPPING, n=15), False),
    "three": (lambda: flat_engine("skew", flat.SLIPPING, n=15), False),
    "free": (lambda: flat_engine("disk", (None, flat.ELASTIC[1]), lambda of: Free(0.3)), False),
    "prestress": (lambda: flat_engine("periodic", PRESTRESSED, stress=flat.prestress), False),
    "open": (lambda: on_faces("open"), False),
    "moving": (lambda: on_faces("moving"), False),
    "forced": (lambda: flat_engine("periodic", FORCED), False),
    "damped": (lambda: flat_engine("panel", flat.STICKING, **flat.DAMPED), True),
    "axis": (lambda: radial_engine(2, 1, "gas"), False),
    "centre": (lambda: radial_engine(1, 2, "solid"), False),
}


def by_rates(state, t):
    """The solution after a step from the completed one, by rates of all nodes."""
    y, k, at, total = state.y.array, 0.0, BlockVector(state.layout), 0.0
    for where, weight in STAGES:
        at.array[:] = y + where * DT * k
        if where > 0.0:
            complete(state, t + where * DT, at)
        k = np.full_like(y, np.nan)
        rates(state, t + where * DT, at, k)
        total = total + weight * k
    at.array[:] = y + DT * total
    complete(state, t + DT, at)
    return at.array


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_is_that_of_the_plain_rates(kind, t=0.3):
    (engine, q), all_added = KINDS[kind][0](), KINDS[kind][1]
    engine.complete(q, t)
    state, parts = engine.state, engine.state.parts.values()
    assert any(part.free_nodes.any() for part in parts) != all_added
    before, expected = state.y.array.copy(), by_rates(state, t)
    for part in parts:
        if part.part.has_halo and not part.reads_ghosted:
            part.part.local[:, part.owned] = np.nan
    state.step(t, DT)
    found, came_in = state.y.array.copy(), state.latest_numbers[-state.layout.auxiliary :]
    found[-came_in.size :] += came_in  # it has moved into the record of the step
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected - before).max()
