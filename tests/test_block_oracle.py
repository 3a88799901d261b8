"""Completion and rates at random states are the oracle's (block_oracle.py), and keep sums.

Where members have one temperature, only the sum of their energies' rates counts."""

from itertools import product

import block_shapes as shapes
import numpy as np
import oracle_formulas as formulas
import pytest
from block_oracle import Oracle
from helpers import recorded
from oracle_engine import Engine
from oracle_formulas import Clamped, Free, Gas, Given, NoSlip, Open, Roller, Slip, Solid

from fsipetsc.particles.constraints import eliminate
from fsipetsc.scheme import gas_sweep, solid_sweep

#: inviscid gas that slips along solids with an energy of their own; what sticks and conducts
SLIPPING = Gas(), Solid("log", heat="elastic")
STICKING = Gas(mu=0.02, kappa=0.03, powers=(0.7, 0.9)), Solid("log", kappa=0.05)
ELASTIC = Gas(mu=0.02, kappa=0.03), Solid("log", kappa=0.05, heat="elastic")
DAMPED = {"dissipation": 0.3, "shock": 0.7}
SHAPES = {
    "line": lambda n: shapes.line(),
    "periodic": lambda n: shapes.layers(n, True),
    "walls": lambda n: shapes.layers(n, False),
    **{of.__name__: of for of in (shapes.ring, shapes.square, shapes.disk, shapes.panel)},
    **{of.__name__: of for of in (shapes.flush, shapes.three, shapes.skew)},
    "cell of three": lambda n: shapes.cell(n, 3),
}
NODES = {2: 7, 4: 9, 6: 12, 8: 16}


def closed(owner):
    return Clamped() if owner[0].startswith("solid") else Slip()


def made(shape, gas, solid, order, faces=closed, stress=None, kappa=0, **options):
    """The oracle of a shape, without blocks of what is None; stress: prestress of solids."""
    blocks, gases = [], gas if isinstance(gas, dict) else dict.fromkeys(shape, gas)
    for name, of in shape.items():
        if name.startswith("gas") and gas:
            blocks.append(formulas.Block(name, gases[name], *of))
        elif name.startswith("solid") and solid:
            blocks.append(formulas.Block(name, solid, *of, stress))
    return Oracle(formulas.Problem(tuple(blocks), faces, order, **options), kappa)


def derivatives(oracle, q, rates, t=0.0):
    """Of the integrals, by a step into the complex plane; size: of the parts of the energy's."""
    stepped = {name: q[name] + 1j * formulas.TINY * rates[name] for name in q}
    values = oracle.integrals(stepped, t).items()
    found = {key: np.imag(value) / formulas.TINY for key, value in values}
    weights = dict(zip(oracle.names, oracle.W))
    size = sum(np.abs(weights[name] * r[-1]).sum() for name, r in rates.items())
    return found, size


def with_sums(oracle, rates):
    """Rates; sums of the energy's where temperatures are shared, none of what is given."""
    found = {name: value.copy() for name, value in rates.items()}
    for p in oracle.particles:
        warm = oracle.prescribed_T(p, 0.0)
        for i, (kind, members) in enumerate((("gas", p.gas), ("solid", p.solid))):
            given = oracle.given(p, kind) is not None
            for k, node in members:
                if given or warm[i] is not None:
                    found[oracle.names[k]][(slice(0 if given else -1, None), *node)] = 0.0
        if oracle.conducts(p) or len(p.solid) > 1:
            weights = [oracle.W[k][i] for k, i in p.gas] + [oracle.mass(*of) for of in p.solid]
            members = [(oracle.names[k], (-1, *i)) for k, i in p.gas + p.solid]
            total = sum(w * rates[name][i] for w, (name, i) in zip(weights, members))
            for name, i in members:
                found[name][i] = total
    return found


def check_integrals(engine, expected):
    """Those that are recorded after a step, with the angular momentum about the origin."""
    engine.state.complete()
    latest, d = engine.state.latest, engine.problem.dimension
    for name, value in expected.items():
        if name == "momentum" or (name == "angular" and d == 3):
            recorded = f"{name}_momentum" if name == "angular" else name
            found = [latest[f"{recorded}_{x}"] for x in "xyz"[:d]]
        else:
            found = np.sum(latest["angular_momentum" if name == "angular" else name])
        np.testing.assert_allclose(found, value, rtol=1e-11, atol=1e-13, err_msg=name)


def check(shape, both, order, faces=closed, t=0.0, most=3e-13, size=0.5, **options):
    """Compare both at a random state that obeys nothing: (oracle, completed state, rates)."""
    oracle = made(SHAPES[shape](NODES[order]), *both, order, faces, **options)
    engine = Engine(oracle)
    raw = {
        b.name: oracle.random_block(k, np.random.default_rng(k), size)
        for k, b in enumerate(oracle.blocks)
    }
    for k in oracle.solids:  # the oracle moves what rolls back into its plane
        raw[oracle.names[k]][: oracle.d] = oracle.complete(raw, t)[oracle.names[k]][: oracle.d]
    q, found = oracle.complete(raw, t), engine.complete(raw, t)
    joined = len(q) > 1
    assert not joined or max(np.abs(q[name] - raw[name]).max() for name in q) > 2e-3 * size
    for name in q:
        assert np.abs(found[name] - q[name]).max() < 1e-12, name
    check_integrals(engine, oracle.integrals(q, t))
    own = engine.rates(q, t)
    expected, found = with_sums(oracle, oracle.rates(q, t)), with_sums(oracle, own)
    size = np.max([np.abs(r).max() for r in expected.values()])
    for name in q:
        assert np.abs(found[name] - expected[name]).max() < most * size, name
    return oracle, q, own


def check_sums(oracle, q, rates, both):
    """Mass, energy, and the entropy of the inviscid gas stay; of the viscous one it grows."""
    found, size = derivatives(oracle, q, rates)
    assert size > 0.1  # or it would be no test
    assert max(abs(found["mass"]), abs(found["energy"])) < 1e-13 * size
    if both is SLIPPING and oracle.problem.dissipation == 0.0:
        assert abs(found["entropy"]) < 1e-13 * size
    elif oracle.problem.form == "entropy":
        assert found["entropy"] > 1e-3 * size


@pytest.mark.parametrize(
    ("both", "shape"),
    [
        *((SLIPPING, shape) for shape in SHAPES if shape not in ("periodic", "walls")),
        *((STICKING, shape) for shape in ("periodic", "panel", "skew")),
        *((ELASTIC, shape) for shape in ("line", "ring", "three")),
    ],
)
def test_at_order_four(shape, both):
    check_sums(*check(shape, both, 4), both)


@pytest.mark.parametrize("damping", [{"dissipation": 0.3}, DAMPED], ids=["smooth", "shocks"])
@pytest.mark.parametrize("shape", ["ring", "panel"])
def test_dissipation(shape, damping):
    check_sums(*check(shape, SLIPPING, 4, **damping), SLIPPING)


@pytest.mark.parametrize("order", [2, 4, pytest.param(6, marks=pytest.mark.long)])
def test_shocks_of_a_gas(order):
    """In part of the fluxes; with dissipation beside them, or alone."""
    for damping in (DAMPED, {"shock": 1.0}):
        check("line", SLIPPING, order, size=0.1, **damping)


@pytest.mark.parametrize(
    ("shape", "heat", "damping", "order"),
    [
        *(("disk", "coupled", DAMPED, 4), ("three", "coupled", DAMPED, 4)),
        *(("disk", "elastic", {}, 4), ("three", "elastic", {}, 4)),
        ("periodic", "elastic", DAMPED, 4),
        *(
            pytest.param(shape, "coupled", DAMPED, order, marks=pytest.mark.long)
            for shape, order in product(("disk", "periodic"), (2, 6, 8))
        ),
    ],
)
def test_a_free_solid(shape, heat, damping, order):
    """P F^T = F P^T keeps the angular momentum, dissipation does not; it makes heat."""
    material = Solid("log", kappa=0.05, heat=heat)
    checked = check(shape, (None, material), order, lambda owner: Free(), **damping)
    found, size = derivatives(*checked)
    around = ["angular"] if shape != "periodic" and not damping else []
    for key in ("momentum", "energy", *around):
        assert np.abs(found[key]).max() < 1e-13 * size


def prestress(X):
    x, y = X
    return np.array([0.3 * np.cos(2 * np.pi * x), 0.1 + 0 * x, -0.2 * y, 0.4 + 0 * x])


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_prestress(heat, monkeypatch):
    monkeypatch.setattr(solid_sweep, "TILES", ((7, 1), (6, 1), (6, 5)))
    both = Gas(mu=0.02, kappa=0.03), Solid("log", kappa=0.4, heat=heat, force=(0.3, -0.7))
    check("periodic", both, 4, stress=prestress)


@pytest.mark.parametrize(
    ("shape", "both", "damping"),
    [("line", STICKING, {}), ("panel", SLIPPING, DAMPED), ("three", ELASTIC, {})],
)
def test_tiles(shape, both, damping, monkeypatch):
    """The same bits where each block is cut along all axes."""
    oracle, q, whole = check(shape, both, 4, **damping)
    cut = 8 if shape == "line" else 4
    monkeypatch.setattr(gas_sweep, "TILES", ((cut, 1), (cut, 1), (cut, 2)))
    monkeypatch.setattr(solid_sweep, "TILES", ((7, 1), (5, 1), (5, 4)))
    np.testing.assert_equal(Engine(oracle).rates(q), whole)


def wobbling(X, t):
    """A wall that goes to and fro in its plane and across it, with the period 1."""
    angle = 2 * np.pi * t + 0.2 + 3 * X[0]
    return X + 0.03 * np.array([np.sin(angle), np.cos(angle)])


def bent(X, t):
    bump = 0.1 * np.sin(2.0 * t) * X[0] * (1.0 - X[1])
    return X + bump * np.array([1.0 + X[1], 1.0 + X[0]])


def gas_values(X, t):
    return 1.1 + 0.1 * np.sin(t + X[0]), 0.2 * t, 0.1 + 0 * t, 1 + 0.2 * np.sin(2 * t)


def solid_values(X, t):
    return 0.05 * np.cos(t), 0.1 + 0 * t, 1 + 0.1 * t, X[0] + 0.05 * np.sin(t), X[1] + 0.1 * t


#: conditions of a gas that a solid lies on, by face or for the other faces of a block
FACES = {
    "open": {
        ("gas", 0, 0): Open(0.9, (0.5, -0.2), 1.1),
        ("gas", 0, 1): formulas.Outflow(0.8),
        "gas": Slip(),
        ("solid", 1, 1): Free(0.7),
        ("solid", 0, 1): Roller(),
        "solid": Clamped(),
    },
    "fast": {
        ("gas", 0, 0): Open(0.9, (2.5, 0.1), 1.1),
        ("gas", 0, 1): Open(1.1, (0.6, 0.1), 1.0),
        "gas": Open(1.2, (0.3, -0.8), 0.9),
        "solid": Free(0.7),
    },
    "moving": {
        ("gas", 1, 0): NoSlip(T=lambda X, t: 1.1 + 0.1 * np.sin(t + X[0]), motion=wobbling),
        ("gas", 0, 0): Slip(motion=wobbling),
        ("gas", 0, 1): NoSlip(heat_flux=0.2, motion=wobbling),
        ("solid", 1, 1): Free(0.2, T=1.2),
        "solid": Clamped(wobbling, heat_flux=0.3),
    },
    "bending": {("gas", 0, 0): Slip(), "gas": Slip(motion=bent), "solid": Free(0.3)},
    "rolling": {
        ("gas", 0, 0): Slip(),
        ("solid", 0, 0): Roller(),
        "gas": Slip(motion=bent),
        "solid": Free(0.3),
    },
    "given": {
        ("gas", 1, 0): Given(gas_values),
        "gas": Slip(),
        ("solid", 1, 1): Given(solid_values),
        "solid": Free(),
    },
}


@pytest.mark.parametrize("both", [SLIPPING, STICKING], ids=["slip", "stick"])
@pytest.mark.parametrize("faces", FACES)
def test_conditions(faces, both):
    kinds = FACES[faces]
    # accelerations of walls are differences of their velocities
    most = 1e-8 if faces in ("moving", "bending", "rolling") else 3e-13
    check("walls", both, 4, lambda owner: kinds.get(owner, kinds.get(owner[0])), 0.3, most)


def test_a_temperature_that_is_given_is_that_of_all_solids_there():
    faces = lambda owner: Free(T=1.2) if owner[0] == "solid 1" else Free()  # noqa: E731
    check("disk", (None, SLIPPING[1]), 4, faces)


@pytest.mark.parametrize("form", ["entropy", "divergence"])
def test_a_stiffened_gas(form):
    gas = Gas(1.6, 0.8, 0.02, 0.03, 0.4)
    ends = {0: Open(0.9, (0.5,), 1.1), 1: formulas.Outflow(0.5)}
    damping = DAMPED if form == "divergence" else {}
    check("line", (gas, STICKING[1]), 4, lambda owner: ends[owner[2]], form=form, **damping)


@pytest.mark.parametrize(
    "end",
    [Slip(), NoSlip(T=1.2), Given(lambda X, t: (1.1 + 0 * t, 0.2 * t, 1.3 + 0.1 * t))],
    ids=["closed", "warm", "given"],
)
def test_two_gases(end):
    """A perfect and a stiffened one, with a solid between them that conducts heat."""
    first, second = STICKING[0], Gas(1.6, 0.8, 0.02, 0.03, 0.4, powers=(0.7, 0.9))
    gases = dict.fromkeys(shapes.line(), second) | {"gas left": first}
    check("line", (gases, STICKING[1]), 4, lambda owner: end)


@pytest.mark.parametrize(("shape", "order"), [("disk", 2), ("disk", 8), ("square", 6), ("ring", 4)])
def test_a_uniform_flow_stays(shape, order):
    """On turned, joined, moving grids, with random volumes, viscosity and dissipation."""
    flow, X = (1.2, 0.7, -0.3, 0.9), SHAPES[shape](NODES[order])
    gas, rng = Gas(mu=0.02, kappa=0.03), np.random.default_rng(order)
    around = Given(lambda X, t: [c + 0.0 * X[0] for c in flow], wobbling)
    blocks = {f"gas {name}": value for name, value in X.items()}
    oracle = made(blocks, gas, None, order, lambda owner: around, dissipation=0.3)
    engine, U = Engine(oracle), formulas.conserved(gas, flow[0], np.array(flow[1:3]), flow[3])
    U, q = np.array([1.0, *U])[:, None, None], {}
    for k, name in enumerate(oracle.names):
        q[name] = U * oracle.start(k) * rng.uniform(0.9, 1.1, oracle.W[k].shape)
    rates = engine.rates(q, 0.3)
    for f in (f for p in oracle.particles for f in p.outer):  # there all is given
        rates[oracle.names[f.block]][(slice(None), *f.node)] = 0.0
    assert max(np.abs(r).max() for r in rates.values()) > 1e-3
    assert np.max([np.abs(r - U * r[0]).max() for r in rates.values()]) < 1e-10


@pytest.mark.parametrize("form", ["entropy", "divergence"])
def test_other_terms(form):
    gas = Gas(1.8, 0.7, mu=0.02, force=(0.3, -0.2) if form == "divergence" else ())
    solid = Solid("log", 1.0, 2.0, 3.0, 1.5, 0.05, 0.7, "coupled", (0.3, -0.2))
    check("disk", (gas, solid), 4, form=form)


def test_pressures_of_solids():
    check("three", (Gas(mu=0.02), Solid("log", 1.0, 2.0, 3.0, 1.5, 0.05, 0.7)), 4)
    check("line", (STICKING[0], Solid("log", kappa=0.05, gruneisen=1.2)), 4)


def test_constraints_that_others_imply_get_no_force():
    def solve(A, x, size):
        eliminate(x.shape[0], A, x, size)

    n = np.array([[1.0, 0.0], [0.6, 0.8], [0.3, 0.4 + 1e-12]])
    A, x = n @ n.T, n @ np.array([2.0, 3.0])
    found = x.copy()
    recorded(solve, A.copy(), found, np.zeros(3))()
    assert found[2] == 0.0 and np.abs(found).max() < 10.0
    assert np.allclose(A @ found, x, rtol=0.0, atol=1e-9)
