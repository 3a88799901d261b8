"""Metric terms of blocks: identities, bits, patches."""

from __future__ import annotations

import numpy as np
import pytest
from block_grids import GAS, SOLID, box, closed, derivative, nodes_of, whole

from fsipetsc.blocks.block import Block, determinant
from fsipetsc.blocks.grid import GridMotion
from fsipetsc.blocks.metrics import check_positive, solid_metrics
from fsipetsc.errors import InputError

ORDERS = 2, 4, 6, 8
CELLS = {1: (17,), 2: (17, 19), 3: (16, 17, 18)}


def displaced(problem, k, order, nodes, where=None, t=0.3):
    """GridMotion and metrics of a block whose given nodes move by u(X) + t v(X)."""
    block = problem.blocks[k]
    X, d = problem.places(k, nodes), block.dimension
    u = np.stack([0.04 * np.sin(2.0 * X @ np.arange(1, d + 1) + c) for c in range(d)], axis=1)
    v = np.stack([0.05 * np.cos(1.5 * X @ np.arange(d, 0, -1) + 2 * c) for c in range(d)], axis=1)
    motion = GridMotion(problem, k, order, where or whole(block), nodes)
    motion.move(u + t * v)
    motion.velocities(v)
    return motion, motion.metrics


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
@pytest.mark.parametrize("d", (1, 2))
def test_J_t_is_the_rate_of_the_determinant(d, order):
    """det D x is a polynomial of degree d in t: a central difference has no error."""
    problem = closed(box("g", CELLS[d]))
    nodes = nodes_of(problem, 0)
    J = [displaced(problem, 0, order, nodes, t=t)[0].jacobian() for t in (-0.2, 0.8)]
    _, metrics = displaced(problem, 0, order, nodes)
    assert np.abs(metrics[-1]).max() > 0.04
    assert np.abs(metrics[-1] - (J[1] - J[0])).max() <= 1e-13


def test_J_below_zero_is_told_with_its_place():
    """The map is right-handed where a block samples it; the operator is not, on so few nodes."""

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


def test_skew_periods_belong_to_the_curl():
    """Of a linear map the curl form is the cofactors."""
    G = np.array([[1.0, 0.3, 0.1], [0.2, 1.0, -0.2], [-0.1, 0.4, 1.0]])  # D_k X, row by row

    def skew(xi):
        return tuple(sum(g * s for g, s in zip(column, xi)) for column in G.T)

    problem = closed(Block("g", GAS, skew, (8, 9, 10), lambda *X: X, periodic=(True, True, False)))
    _, metrics = displaced(problem, 0, 4, np.zeros(0, int))
    expected = np.linalg.det(G) * np.linalg.inv(G).T[..., None]
    assert np.abs(metrics[:9].reshape(3, 3, -1) - expected).max() <= 1e-14
