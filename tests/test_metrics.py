"""Metric terms of blocks: identities, bits, patches."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from block_grids import GAS, SOLID, box, closed, derivative, joins, nodes_of, whole

from fsipetsc.blocks.block import Block, determinant
from fsipetsc.blocks.grid import GridMotion
from fsipetsc.blocks.metrics import check_positive, cofactors, differentiate, solid_metrics
from fsipetsc.errors import InputError
from fsipetsc.operators.bands import band

ORDERS = 2, 4, 6, 8
CELLS = {1: (17,), 2: (17, 19), 3: (16, 17, 18)}


def displaced(problem, k, order, nodes, where=None, t=0.3):
    """GridMotion and metrics of a block whose given nodes move by u(X) + t v(X)."""
    block = problem.blocks[k]
    X, d = problem.places(k, nodes), block.dimension
    u = np.stack([0.04 * np.sin(2.0 * X @ np.arange(1, d + 1) + c) for c in range(d)], axis=1)
    v = np.stack([0.05 * np.cos(1.5 * X @ np.arange(d, 0, -1) + 2 * c) for c in range(d)], axis=1)
    motion = GridMotion(problem, k, order, where or whole(block), nodes)
    metrics = np.zeros((d * d + d + 1, int(np.prod([b - a for a, b in where or whole(block)]))))
    motion.move(u + t * v, metrics)
    motion.velocities(v, metrics)
    return motion, metrics


@pytest.mark.parametrize("order", ORDERS)
def test_differentiate_is_D_along_every_axis(order):
    sizes = (17, 18, 19)
    f = np.random.default_rng(1).random(int(np.prod(sizes)))
    for axis, n in enumerate(sizes):
        b = band(order, n - 1)
        out = np.empty_like(f)
        differentiate(out, f, b.S, b.weight, int(np.prod(sizes[:axis])))
        along = 2 - axis
        expected = np.moveaxis(
            np.tensordot(b.matrix(), f.reshape(sizes[::-1]), (1, along)), 0, along
        )
        assert np.abs(out - expected.ravel()).max() <= 1e-12


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("d", (1, 2, 3))
def test_a_solid_at_rest_has_no_strain(d, order):
    problem = closed(box("s", CELLS[d], SOLID))
    block = problem.blocks[0]
    metrics = solid_metrics(problem, 0, order, whole(block))
    A, J = metrics[:-1].reshape(d, d, -1), metrics[-1]
    X = problem.positions(0, whole(block))
    G = np.array([derivative(block, order, k, X) for k in range(d)])
    Q = np.linalg.qr(np.random.default_rng(2).random((d, d)))[0]
    for turn in (np.eye(d), Q):
        F = np.einsum("ab,kbn,kcn->acn", turn, G, A) / J
        assert np.abs(F - turn[..., None]).max() <= 2e-14
    assert np.abs(J - determinant(G)).max() <= 3e-14


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("d", (2, 3))
def test_metrics_of_a_moving_gas_are_free_of_divergence(d, order):
    for periodic in product((False, True), repeat=d):
        problem = closed(box("g", CELLS[d], periodic=periodic))
        block = problem.blocks[0]
        _, metrics = displaced(problem, 0, order, nodes_of(problem, 0))
        a = metrics[: d * d].reshape(d, d, -1)
        parts = [derivative(block, order, k, a[k]) for k in range(d)]
        assert max(np.abs(part).max() for part in parts) > 1e-2
        assert np.abs(sum(parts)).max() <= 1e-13


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("d", (1, 2, 3))
def test_metrics_and_determinant_are_those_of_the_positions(d, order):
    problem = closed(box("g", CELLS[d]))
    block = problem.blocks[0]
    motion, metrics = displaced(problem, 0, order, nodes_of(problem, 0))
    x = motion.positions()
    G = np.array([derivative(block, order, k, x) for k in range(d)])
    assert np.abs(motion.jacobian() - determinant(G)).max() <= 1e-13
    a, A = metrics[: d * d], cofactors(G).reshape(d * d, -1)
    if d == 3:  # the curl form differs by the error of the scheme
        A = curl_form(block, order, x).reshape(9, -1)
        assert 1e-4 < np.abs(a - cofactors(G).reshape(9, -1)).max() < 1e-1
    assert np.abs(a - A).max() <= 1e-12


def curl_form(block, order, x):
    """(a^i)_n = 1/2 eps_ijk D_j (x_m D_k x_l - x_l D_k x_m), written as in SCHEME-BLOCKS.md."""
    D = lambda k, f: derivative(block, order, k, f)  # noqa: E731
    a = np.zeros((3, *x.shape))
    signs = {(0, 1, 2): 1, (1, 2, 0): 1, (2, 0, 1): 1, (0, 2, 1): -1, (2, 1, 0): -1, (1, 0, 2): -1}
    for (i, j, k), sign in signs.items():
        for n, m, l in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            a[i, n] += 0.5 * sign * D(j, x[m] * D(k, x[l]) - x[l] * D(k, x[m]))
    return a


def test_skew_periods_belong_to_the_curl():
    """Of a linear map the curl form is the cofactors."""
    G = np.array([[1.0, 0.3, 0.1], [0.2, 1.0, -0.2], [-0.1, 0.4, 1.0]])  # D_k X, row by row

    def skew(xi):
        return tuple(sum(g * s for g, s in zip(column, xi)) for column in G.T)

    problem = closed(Block("g", GAS, skew, (8, 9, 10), lambda *X: X, periodic=(True, True, False)))
    _, metrics = displaced(problem, 0, 4, np.zeros(0, int))
    expected = cofactors(G[..., None])
    assert np.abs(metrics[:9].reshape(3, 3, -1) - expected).max() <= 1e-14


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("d", (1, 2))
def test_J_t_is_the_rate_of_the_determinant(d, order):
    """det D x is a polynomial of degree d in t: a central difference has no error."""
    problem = closed(box("g", CELLS[d]))
    nodes = nodes_of(problem, 0)
    J = [displaced(problem, 0, order, nodes, t=t)[0].jacobian() for t in (-0.2, 0.8)]
    _, metrics = displaced(problem, 0, order, nodes)
    assert np.abs(metrics[-1]).max() > 0.04
    assert np.abs(metrics[-1] - (J[1] - J[0])).max() <= 1e-13


def test_J_t_in_three_dimensions_is_so_to_the_order_of_the_scheme():
    wrong = []
    for n in (12, 24):
        problem = closed(box("g", (n, n, n)))
        nodes = nodes_of(problem, 0)
        J = [displaced(problem, 0, 4, nodes, t=0.3 + e)[0].jacobian() for e in (-1e-3, 1e-3)]
        _, metrics = displaced(problem, 0, 4, nodes)
        wrong.append(np.sqrt(np.mean((metrics[-1] - (J[1] - J[0]) / 2e-3) ** 2)))
    assert np.log2(wrong[0] / wrong[1]) > 2.4 and wrong[1] < 2e-3


#: how the second block is turned
TURNS = (
    *(((0, 1), (False, False)), ((1, 0), (True, False))),
    *(((1, 0), (False, True)), ((0, 1), (True, True))),
    *(((0, 1, 2), (False, False, False)), ((1, 2, 0), (True, False, True))),
    *(((2, 1, 0), (True, False, False)), ((0, 2, 1), (True, True, True))),
)


@pytest.mark.parametrize("order", (2, 4, 8))
@pytest.mark.parametrize("axes, flips", TURNS)
def test_both_sides_of_a_join_have_the_same_area_vectors(axes, flips, order):
    d = len(axes)
    other = box("b", (16,) * d, lower=(1.0, 0.0, 0.0)[:d], axes=axes, flips=flips)
    check_join(order, box("a", (16,) * d), other)


def check_join(order, *blocks):
    """Area vectors +-a^k and velocities at the common face are the same bits, if a face that both
    touch is known.
    """
    problem = closed(*blocks)
    (((axis, side), met),) = joins(problem, 0)
    d, found = problem.dimension, []
    for k in (0, 1):
        X = problem.places(k, np.arange(int(np.prod(blocks[k].shape))))
        hull = nodes_of(problem, k)
        low = box("low", blocks[0].cells, lower=(0.0, -1.0, 0.0)[:d])
        touching = {tuple(x) for x in np.round(low.face_positions(1, 1).T, 9)}
        beside = box("beside", blocks[0].cells, lower=(1.0, -1.0, 0.0)[:d])
        touching |= {tuple(x) for x in np.round(beside.face_positions(1, 1).T, 9)}
        nodes = np.array([n for n in hull if tuple(np.round(X[n], 9)) in touching])
        assert len(nodes) == np.prod(blocks[k].shape[1:])
        motion, metrics = displaced(problem, k, order, nodes)
        found.append((metrics, motion.positions()))
    mine = problem.face_nodes(0, axis, side)
    others = problem.face_nodes(1, met.axis, met.side)[met.order]
    (a, x), (b, y) = found
    sign = (1 if side else -1) * (-1 if met.side else 1)
    assert np.array_equal(x[:, mine], y[:, others])
    assert np.array_equal(a[d * d : d * d + d, mine], b[d * d : d * d + d, others])
    assert np.abs(a[d * d : d * d + d, mine]).max() > 0.01
    n, m = a[d * axis : d * axis + d, mine], sign * b[d * met.axis : d * met.axis + d, others]
    assert np.abs(n).max() > 0.5 and np.array_equal(n, m)


@pytest.mark.parametrize("order", (4, 8))
@pytest.mark.parametrize("material", (GAS, SOLID))
def test_metrics_of_a_patch_are_those_of_the_block(material, order):
    for periodic in ((False, False), (True, False), (False, True), (True, False, False)):
        d = len(periodic)
        problem = closed(box("g", CELLS[d], material, periodic=periodic))
        block = problem.blocks[0]
        reach = 2 * max(periodic)
        full = [(-reach, n + reach) if turns else (0, n) for n, turns in zip(block.shape, periodic)]
        all_of = metrics_on(problem, order, full)
        for axis, (begin, end) in enumerate(full):
            for cut in ((begin, begin + 7), (begin + 5, end - 2), (end - 6, end)):
                where = [cut if k == axis else ends for k, ends in enumerate(full)]
                pairs = zip(where[::-1], full[::-1])
                inner = tuple(slice(a - b, c - b) for (a, c), (b, _) in pairs)
                part = metrics_on(problem, order, where)
                shape = [b - a for a, b in full][::-1]
                expected = all_of.reshape(-1, *shape)[(slice(None), *inner)].reshape(len(part), -1)
                assert np.array_equal(part, expected)


def metrics_on(problem, order, where):
    if problem.blocks[0].kind == "solid":
        return solid_metrics(problem, 0, order, where)
    motion, metrics = displaced(problem, 0, order, nodes_of(problem, 0), where)
    return np.concatenate([metrics, motion.jacobian()[None], motion.positions()])


def test_J_below_zero_is_told_with_its_place():
    """The map is right-handed where a block looks; the operator is not, on so few nodes."""

    def steep(xi):
        s = xi[0]
        return (np.tanh(60.0 * (s - 0.03)) + 0.05 * s, xi[1])

    block = Block("steep", SOLID, steep, (24, 24), lambda *X: X)
    problem = closed(block)
    words = r"block 'steep': J = -.* at \(X, Y\) = .*: expected J > 0"
    with pytest.raises(InputError, match=words) as caught:
        solid_metrics(problem, 0, 8, whole(block))
    assert not caught.value.collective
    with pytest.raises(InputError, match="J = nan"):
        check_positive(block, np.array([np.nan]), np.zeros((2, 1)))
