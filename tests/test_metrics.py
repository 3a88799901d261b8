"""Metric terms of blocks where the oracle (test_block_oracle.py) has none."""

from __future__ import annotations

import numpy as np
import pytest
from block_grids import GAS, SOLID, closed, whole

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.grid import GridMotion
from fsipetsc.blocks.metrics import check_positive, solid_metrics
from fsipetsc.errors import InputError


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


def test_skew_periods_belong_to_the_curl():
    """Of a linear map the curl form is the cofactors."""
    G = np.array([[1.0, 0.3, 0.1], [0.2, 1.0, -0.2], [-0.1, 0.4, 1.0]])  # D_k X, row by row

    def skew(xi):
        return tuple(sum(g * s for g, s in zip(column, xi)) for column in G.T)

    problem = closed(Block("g", GAS, skew, (8, 9, 10), lambda *X: X, periodic=(True, True, False)))
    motion = GridMotion(problem, 0, 4, whole(problem.blocks[0]), np.zeros(0, int))
    motion.move(np.zeros((0, 3)))
    expected = np.linalg.det(G) * np.linalg.inv(G).T[..., None]
    assert np.abs(motion.metrics[:9].reshape(3, 3, -1) - expected).max() <= 1e-14
