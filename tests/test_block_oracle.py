"""The engine's completion and rates at random states are those of the oracle (block_oracle.py), to
round-off, and keep what SCHEME-BLOCKS.md, section 10, says: mass, energy, entropy.

Where members have one temperature, only the sum of their energies' rates is compared: how it is
divided between them is no matter, for completion shares it.
"""

from __future__ import annotations

from itertools import product

import block_shapes as shapes
import numpy as np
import pytest
from block_oracle import Oracle
from oracle_formulas import (
    Block,
    Clamped,
    Free,
    Gas,
    Given,
    Motion,
    NoSlip,
    Open,
    Outflow,
    Problem,
    Roller,
    Slip,
    Solid,
    conserved,
    det,
)

pytest.importorskip("petsc4py")

from oracle_engine import Engine

from fsipetsc.scheme import solid_work

TINY = 1e-30
#: inviscid gas that slips along solids with an energy of their own; viscous, conducting gas and
#: solid
SLIPPING = Gas(), Solid("log", heat="elastic")
STICKING = Gas(mu=0.02, kappa=0.03), Solid("log", kappa=0.05)
LINE = {
    "gas left": shapes.box((0.0,), (1.0,), 17),
    "solid": shapes.box((1.0,), (1.5,), 17),
    "gas right": shapes.box((1.5,), (2.0,), 17),
    "gas beyond": shapes.box((2.0,), (4.0,), 17),
}
SHAPES = {
    "line": lambda n: LINE,
    "periodic": lambda n: shapes.layers(n, True),
    "walls": lambda n: shapes.layers(n, False),
    "ring": shapes.ring,
    "square": shapes.square,
    "disk": shapes.disk,
    "panel": shapes.panel,
    "three": shapes.three,
    "tube": shapes.tube,
}
ELASTIC = Gas(mu=0.02, kappa=0.03), Solid("log", kappa=0.05, heat="elastic")
NODES = {2: 7, 4: 9, 6: 12, 8: 16}


def closed(owner):
    """Walls and clamps."""
    return Clamped() if owner[0].startswith("solid") else Slip()


def made(shape, gas, solid, order, faces=closed, stress=None, **options):
    """The oracle of a shape. stress: prestress of solids."""
    blocks = [
        Block(name, *((gas, *of) if name.startswith("gas") else (solid, *of, stress)))
        for name, of in shape.items()
    ]
    return Oracle(Problem(tuple(blocks), faces, order, **options))


def derivatives(oracle, q, rates, t=0.0):
    """Of the integrals, by a step into the complex plane; size: of the parts of the energy's."""
    stepped = {name: q[name] + 1j * TINY * rates[name] for name in q}
    found = {key: np.imag(value) / TINY for key, value in oracle.integrals(stepped, t).items()}
    weights = dict(zip(oracle.names, oracle.W))
    size = sum(np.abs(weights[name] * r[-1]).sum() for name, r in rates.items())
    return found, size


def with_sums(oracle, rates):
    """Rates, with the sum of those of the energy where temperatures are shared; none of what is
    given, nor of energies where temperatures are.
    """
    found = {name: value.copy() for name, value in rates.items()}
    for p in oracle.particles:
        warm = oracle._prescribed_T(p, 0.0)
        for i, (kind, members) in enumerate((("gas", p.gas), ("solid", p.solid))):
            given = oracle._given(p, kind) is not None
            for k, node in members:
                if given or warm[i] is not None:
                    found[oracle.names[k]][(slice(0 if given else -1, None), *node)] = 0.0
        if oracle._conducts(p) or len(p.solid) > 1:
            total = sum(oracle.W[k][i] * rates[oracle.names[k]][(-1, *i)] for k, i in p.gas)
            for k, i in p.solid:
                M = (oracle.W[k] * oracle.solids[k][1])[i] * oracle.blocks[k].material.m0
                total += M * rates[oracle.names[k]][(-1, *i)]
            for k, i in p.gas + p.solid:
                found[oracle.names[k]][(-1, *i)] = total
    return found


def check(shape, both, order, faces=closed, t=0.0, most=1e-11, **options):
    """Compare both at a state that obeys nothing before; most: of the rates' differences. Returns
    the oracle, the completed state and the engine's rates.
    """
    oracle = made(SHAPES[shape](NODES[order]), *both, order, faces, **options)
    engine = Engine(oracle)
    raw = {
        b.name: oracle.random_block(k, np.random.default_rng(k), 0.5)
        for k, b in enumerate(oracle.blocks)
    }
    for k in oracle.solids:  # the oracle moves what rolls back into its plane
        raw[oracle.names[k]][: oracle.d] = oracle.complete(raw, t)[oracle.names[k]][: oracle.d]
    q, found = oracle.complete(raw, t), engine.complete(raw, t)
    assert max(np.abs(q[name] - raw[name]).max() for name in q) > 1e-3
    for name in q:
        assert np.abs(found[name] - q[name]).max() < 1e-12, name
    expected, found = with_sums(oracle, oracle.rates(q, t)), with_sums(oracle, engine.rates(q, t))
    size = max(np.abs(r).max() for r in expected.values())
    for name in q:
        assert np.abs(found[name] - expected[name]).max() < most * size, name
    return oracle, q, engine.rates(q, t)


def check_sums(oracle, q, rates, both):
    """Mass, energy, and the entropy of the inviscid gas stay; of the viscous one it grows."""
    found, size = derivatives(oracle, q, rates)
    assert size > 0.1  # or it would be no test
    assert abs(found["mass"]) < 1e-13 * size
    assert abs(found["energy"]) < 1e-13 * size
    if both is SLIPPING and oracle.problem.dissipation == 0.0:
        assert abs(found["entropy"]) < 1e-13 * size
    else:
        assert found["entropy"] > 1e-3 * size


@pytest.mark.parametrize(
    ("both", "shape"),
    [
        *((SLIPPING, shape) for shape in SHAPES),
        *((STICKING, shape) for shape in ("line", "periodic", "panel", "disk", "tube")),
        *((ELASTIC, shape) for shape in ("line", "ring", "square", "three")),
    ],
)
def test_at_order_four(shape, both):
    check_sums(*check(shape, both, 4), both)


@pytest.mark.long
@pytest.mark.parametrize("order", [2, 6, 8])
@pytest.mark.parametrize("both", [SLIPPING, STICKING], ids=["slip", "stick"])
@pytest.mark.parametrize("shape", ["line", "walls", "ring", "square", "panel", "disk"])
def test_at_other_orders(shape, both, order):
    check_sums(*check(shape, both, order), both)


@pytest.mark.parametrize("shape", ["ring", "panel"])
def test_dissipation(shape):
    check_sums(*check(shape, SLIPPING, 4, dissipation=0.3), SLIPPING)


DAMPED = {"dissipation": 0.3, "shock": 0.7}


@pytest.mark.parametrize(
    ("shape", "heat", "damping", "order"),
    [
        *product(("disk", "layers", "three"), ("coupled", "elastic"), ({}, DAMPED), (4,)),
        *(
            pytest.param(shape, "coupled", DAMPED, order, marks=pytest.mark.long)
            for shape, order in product(("disk", "layers"), (2, 6, 8))
        ),
    ],
)
def test_a_free_solid(shape, heat, damping, order):
    """Rates and momenta, also the angular one, which P F^T = F P^T keeps, but dissipation does not.
    Motion that is damped becomes heat.
    """
    n = NODES[order]
    found = {"disk": shapes.disk(n, False), "layers": shapes.layers(n, True)}
    found |= {"three": shapes.three(8)}
    blocks = {name: X for name, X in found[shape].items() if name.startswith("solid")}
    material = Solid("log", kappa=0.05, heat=heat)
    oracle = made(blocks, None, material, order, lambda owner: Free(), **damping)
    q = oracle.random_state(np.random.default_rng(5))
    rates, expected = Engine(oracle).rates(q), with_sums(oracle, oracle.rates(q))
    found, size = with_sums(oracle, rates), max(np.abs(r).max() for r in expected.values())
    for name in q:
        assert np.abs(found[name] - expected[name]).max() < 1e-11 * size, name
    found, size = derivatives(oracle, q, rates)
    for key in ("momentum", "energy", *(["angular"] if shape != "layers" and not damping else [])):
        assert np.abs(found[key]).max() < 1e-13 * size


def prestress(X):
    x, y = X
    return np.array([0.3 * np.cos(2 * np.pi * x), 0.1 + 0 * x, -0.2 * y, 0.4 + 0 * x])


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_prestress(heat, monkeypatch):
    """Also in many tiles."""
    monkeypatch.setattr(solid_work, "TILES", ((7, 1), (6, 1), (6, 5)))
    both = Gas(mu=0.02, kappa=0.03), Solid("log", kappa=0.4, heat=heat, force=(0.3, -0.7))
    check("periodic", both, 4, stress=prestress)
    check("three", ELASTIC, 4)


def test_pressure_of_a_solid():
    check("line", (STICKING[0], Solid("log", kappa=0.05, gruneisen=1.2)), 4)


def open_faces(owner):
    """Flow in, out, a free solid."""
    if owner[0].startswith("solid"):
        return {(1, 1): Free(0.7), (0, 1): Roller()}.get(owner[1:], Clamped())
    kinds = {(0, 0): Open(0.9, (0.5, -0.2), 1.1), (0, 1): Outflow(0.8), (1, 0): Slip()}
    return kinds.get(owner[1:], Open(1.2, (0.3, 0.4), 0.9))


def fast_faces(owner):
    """Open all around: flow in faster than sound, out slower than it and against a pressure."""
    if owner[0].startswith("solid"):
        return Free(0.7)
    kinds = {(0, 0): Open(0.9, (2.5, 0.1), 1.1), (0, 1): Open(1.1, (0.6, 0.1), 1.0)}
    return kinds.get(owner[1:], Open(1.2, (0.3, -0.8), 0.9))


def moving_faces(owner):
    """Walls and clamps that move, temperatures that are held, heat that comes in."""
    name, axis, side = owner
    if name.startswith("solid"):
        return Clamped(wobbling(0.03, 0.2), heat_flux=0.3) if axis == 0 else Free(0.2, T=1.2)
    kinds = {
        (1, 0): NoSlip(T=lambda X, t: 1.1 + 0.1 * np.sin(t + X[0]), motion=wobbling(0.03, 0.2)),
        (0, 0): Slip(motion=wobbling(0.03, 0.2)),
        (0, 1): NoSlip(heat_flux=0.2, motion=wobbling(0.03, 0.2)),
    }
    return kinds.get((axis, side), Slip())


def wobbling(size, phase):
    """A wall that goes to and fro in its plane and across it, with the period 1."""
    w = 2 * np.pi

    def derived(order):
        def place(X, t):
            angle = w * t + phase + 3 * X[0] + 0.5 * np.pi * order  # a derivative turns the phase
            return size * w**order * np.array([np.sin(angle), np.cos(angle)]) + X * (order == 0)

        return place

    return Motion(derived(0), derived(1), derived(2))


def bending_faces(owner):
    """Walls along which gas slips, and which bend; the solid is free."""
    if owner[0] == "solid":
        return Free(0.3)
    return Slip(motion=BENDING) if owner[1:] in ((1, 0), (0, 1)) else Slip()


def bent(rate):
    """A place that moves, derived so often in time."""

    def function(X, t):
        wave = (np.sin(2.0 * t), 2.0 * np.cos(2.0 * t), -4.0 * np.sin(2.0 * t))[rate]
        bump = X[0] * (1.0 - X[1])
        return X * (rate == 0) + 0.1 * wave * np.array([bump * (1.0 + X[1]), bump * (1.0 + X[0])])

    return function


BENDING = Motion(bent(0), bent(1), bent(2))


def given_faces(owner):
    """Unknowns that are given; slip beside."""
    if owner[0] == "solid":
        return Given(solid_values) if owner[1:] == (1, 1) else Free()
    return Given(gas_values) if owner[1:] == (1, 0) else Slip()


def gas_values(X, t):
    return 1.1 + 0.1 * np.sin(t + X[0]), 0.2 * t, 0.1 + 0 * t, 1 + 0.2 * np.sin(2 * t)


def solid_values(X, t):
    return 0.05 * np.cos(t), 0.1 + 0 * t, 1 + 0.1 * t, X[0] + 0.05 * np.sin(t), X[1] + 0.1 * t


@pytest.mark.parametrize("order", NODES)
@pytest.mark.parametrize("shape", ["ring", "square", "panel", "disk"])
def test_a_uniform_flow_stays(shape, order):
    """Through all blocks of a shape, turned, joined by three and four, on grids that move, with
    random volumes, viscosity and dissipation.
    """
    flow, X = (1.2, 0.7, -0.3, 0.9), SHAPES[shape](NODES[order])
    gas, rng = Gas(mu=0.02, kappa=0.03), np.random.default_rng(order)
    around = Given(lambda X, t: [c + 0.0 * X[0] for c in flow], wobbling(0.03, 0.2))
    blocks = {f"gas {name}": value for name, value in X.items()}
    oracle = made(blocks, gas, None, order, lambda owner: around, dissipation=0.3)
    engine, U = Engine(oracle), conserved(gas, flow[0], np.array(flow[1:3]), flow[3])
    U, q = np.array([1.0, *U])[:, None, None], {}
    for k, name in enumerate(oracle.names):
        J = det(np.swapaxes(oracle.slopes(k, oracle.blocks[k].X), 0, 1))
        q[name] = U * J * rng.uniform(0.9, 1.1, J.shape)
    rates, seen = engine.rates(q, 0.3), 0.0
    for k, name in enumerate(oracle.names):
        inner = np.ones(rates[name][0].size, bool)
        outer = [f for f in engine.problem.outer_faces if f[0] == k]
        for face in outer:  # there all is given
            inner[engine.problem.face_nodes(*face)] = False
        apart = (rates[name] - U * rates[name][0]).reshape(len(U), -1, order="F")
        seen = max(seen, np.abs(rates[name]).max())
        assert np.abs(apart[:, inner]).max() < 1e-10, name
    assert seen > 1e-3


FACES = open_faces, fast_faces, moving_faces, bending_faces, given_faces


@pytest.mark.parametrize("both", [SLIPPING, STICKING], ids=["slip", "stick"])
@pytest.mark.parametrize("faces", FACES)
def test_conditions(faces, both):
    # accelerations of walls are differences of their velocities
    moved = faces in (moving_faces, bending_faces)
    check("walls", both, 4, faces, t=0.3, most=1e-8 if moved else 1e-11)


@pytest.mark.parametrize("form", ["entropy", "divergence"])
def test_other_terms(form):
    """Body forces, p_ref, either form of convection."""
    gas = Gas(1.8, 0.7, mu=0.02, force=(0.3, -0.2))
    solid = Solid("log", 1.0, 2.0, 3.0, 1.5, 0.05, 0.7, "coupled", (0.3, -0.2))
    check("disk", (gas, solid), 4, form=form)


def test_pressure_of_reference_in_three_dimensions():
    gas = Gas(mu=0.02)
    check("three", (gas, Solid("log", 1.0, 2.0, 3.0, 1.5, 0.05, 0.7)), 4)
