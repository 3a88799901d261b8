"""Motion of the gas's grid: blends of what faces, edges and vertices do."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from block_grids import box, closed, nodes_of, whole

from fsipetsc.blocks.grid import GridMotion

CELLS = {1: (8,), 2: (8, 10), 3: (8, 9, 10)}


def moved(problem, nodes, values, where=None, order=4):
    """Displacement (d, N) and metrics where the given nodes move by values (M, d), which are
    velocities, too.
    """
    block = problem.blocks[0]
    where = where or whole(block)
    motion = GridMotion(problem, 0, order, where, nodes)
    motion.move(values)
    motion.velocities(values)
    return motion.positions() - problem.positions(0, where), motion.metrics


def logical(block):
    """xi (d, N) of the nodes."""
    grids = np.meshgrid(
        *(np.arange(n) / c for n, c in zip(block.shape[::-1], block.cells[::-1])), indexing="ij"
    )
    return np.array([g.ravel() for g in grids[::-1]])


@pytest.mark.parametrize("d", (1, 2, 3))
def test_faces_have_what_is_given_to_the_bit(d):
    problem = closed(box("g", CELLS[d]))
    nodes = nodes_of(problem, 0)
    values = np.random.default_rng(2).standard_normal((len(nodes), d)) * 1e-3
    shuffled = np.random.default_rng(3).permutation(len(nodes))
    motion = GridMotion(problem, 0, 4, whole(problem.blocks[0]), nodes[shuffled])
    motion.move(values[shuffled])
    motion.velocities(values[shuffled])
    assert np.array_equal(motion.metrics[d * d : d * d + d, nodes], values.T)
    assert np.array_equal(motion.positions()[:, nodes], problem.places(0, nodes).T + values.T)


@pytest.mark.parametrize("d", (2, 3))
def test_the_blend_is_the_Boolean_sum_of_the_faces(d):
    problem = closed(box("g", CELLS[d]))
    block, nodes = problem.blocks[0], nodes_of(problem, 0)
    u = np.zeros((d, int(np.prod(block.shape))))
    u[:, nodes] = np.random.default_rng(4).standard_normal((d, len(nodes))) * 1e-3
    array = u.reshape(d, *block.shape[::-1])
    rest = array.copy()
    xi = logical(block).reshape(array.shape)
    for k in range(d):  # (1 - P_1) (1 - P_2) … u: what is between is left out on both sides
        ends = [np.take(rest, [i], axis=d - k) for i in (0, -1)]
        rest = rest - (1 - xi[k]) * ends[0] - xi[k] * ends[1]
    found, metrics = moved(problem, nodes, u[:, nodes].T)
    inside = np.setdiff1d(np.arange(u.shape[1]), nodes)
    expected = (array - rest).reshape(d, -1)[:, inside]
    assert np.abs(expected).max() > 1e-4
    assert np.abs(found[:, inside] - expected).max() <= 1e-15
    assert np.abs(metrics[d * d : d * d + d, inside] - expected).max() <= 1e-15


@pytest.mark.parametrize("d", (1, 2, 3))
def test_faces_that_are_not_given_follow_from_their_vertices(d):
    """Given vertices move, the others do not; all that lies between is linear along each axis."""
    problem = closed(box("g", CELLS[d]))
    block = problem.blocks[0]
    xi = logical(block)
    chosen = [corner for corner in product((0, 1), repeat=d) if sum(corner) != 1]
    values = np.random.default_rng(5).random((len(chosen), d))
    index = np.array(chosen) * (np.array(block.shape) - 1)
    nodes = np.ravel_multi_index(index.T[::-1], block.shape[::-1])
    weights = [np.prod([x if s else 1 - x for s, x in zip(c, xi)], axis=0) for c in chosen]
    found, metrics = moved(problem, nodes, values)
    expected = sum(np.multiply.outer(v, w) for v, w in zip(values, weights))
    assert np.abs(found - expected).max() <= 1e-15
    assert np.abs(metrics[d * d : d * d + d] - expected).max() <= 1e-15


@pytest.mark.parametrize(
    "periodic",
    ((True, False), (False, True), (True, False, False), (True, True, False), (True, True)),
)
def test_along_periodic_axes_nothing_is_blended(periodic):
    d = len(periodic)
    problem = closed(box("g", (10, 12, 11)[:d], periodic=periodic))
    block = problem.blocks[0]
    xi = logical(block)
    bend = 0.01 * np.sin(2 * np.pi * xi[periodic.index(True)])
    if all(periodic):
        found, metrics = moved(problem, [], np.zeros((0, d)))
        assert not found.any() and not metrics[d * d :].any()
        return
    axis = d - 1 if not periodic[-1] else 0
    nodes = problem.face_nodes(0, axis, 1)
    pairs = zip(block.shape, periodic)
    where = [(-2, n + 2) if closed_axis else (0, n) for n, closed_axis in pairs]
    found, metrics = moved(problem, nodes, np.outer(bend[nodes], np.ones(d)), where)
    inner = tuple(slice(2, -2) if closed_axis else slice(None) for closed_axis in periodic[::-1])
    sizes = [b - a for a, b in where][::-1]
    for values in (found, metrics[d * d : d * d + d]):
        array = values.reshape(d, *sizes)
        got = array[(slice(None), *inner)].reshape(d, -1)
        assert np.abs(got - bend * xi[axis]).max() <= 2e-15
        along = d - periodic.index(True)
        ends = np.take(array, [0, 1], axis=along), np.take(array, [-4, -3], axis=along)
        assert np.abs(ends[0] - ends[1]).max() <= 2e-15


def test_a_grid_may_be_moved_again():
    """Nothing is left of the displacement before."""
    problem = closed(box("g", CELLS[3]))
    nodes = nodes_of(problem, 0)
    motion = GridMotion(problem, 0, 4, whole(problem.blocks[0]), nodes)
    values, found = 0.01 * np.random.default_rng(7).random((len(nodes), 3)), []
    for times in ((1.0,), (-2.0, 1.0)):
        for factor in times:
            motion.move(factor * values)
            motion.velocities(factor * values)
        found.append(motion.metrics.copy())
    assert np.array_equal(*found)
