"""The scheme's own right-hand side, linearised about a steady state: derivatives, modes of blocks,
and the step of RK4.

``modes_near`` has the eigenvalues next to an expected one, of any blocks. The others have all, and
take less time, as columns are alike.

Columns of the blocks are alike: those along flat layers, those of a ring in the frame of radius and
angle; in one dimension there is one column. The derivative of the rates of column m by unknown j of
column 0 is found by central differences of order 8. Times exp(-i n phi), phi = 2 pi m / M, and
added up over the M columns, it is column j of a matrix A(n), by which what is proportional to
exp(i n phi) changes. What may be disturbed is what the projection P lets through: P A acts on its
range.

Central differences do not see what alternates from node to node. Modes that do so across the blocks
swing at frequencies of waves that are long. They are told by their roughness, the squares of the
differences of neighbours across the blocks over those of the values: 4 where signs alternate, 1 for
a wave of 6 nodes.

The classical Runge-Kutta method multiplies a mode exp(lambda t) by R(dt lambda) in a step, R(z) =
1 + z + z^2/2 + z^3/6 + z^4/24; the step limit is the largest dt with |R| <= 1 for all modes (one
that grows counts with its frequency alone).
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import orth
from scipy.optimize import brentq
from scipy.sparse.linalg import eigs

from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Condition
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.errors import InputError

Real, Complex = NDArray[np.float64], NDArray[np.complex128]
#: f' = sum_m c_m (f(x + m s) - f(x - m s)) / s with m = 1 ... 4, of order 8
CENTRAL = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
#: |z| at which each mode is amplified, and round-off of |R|
FARTHEST, ROUND_OFF = 3.2, 1e-12
#: least disturbance, as a fraction of what there is, of columns, and of single unknowns
NUDGE, TINY = 0.005, 2.0**-22
#: rates at rest and columns that differ by more than this fraction are no state at rest
AT_REST = 1e-9
#: how much a mode swings at least, over the largest |lambda|, and how rough it may be
SWINGING, ROUGH = 1e-6, 1.0
FORM = BlockForm()


def derivatives(f: Callable[[int, float], Any], steps: Sequence[float] | Real) -> Any:
    """(…, n) derivatives of an array by n numbers: f(i, change) is the array where number i is
    changed by so much. Central differences of order 8, with steps of these n sizes.
    """
    columns = []
    for i, step in enumerate(steps):
        total = 0.0
        for multiple, weight in enumerate(CENTRAL, 1):
            for sign in (1, -1):
                total = total + sign * weight / step * f(i, sign * multiple * step)
        columns.append(total)
    return np.stack(columns, axis=-1)


def step_limit(spectrum: Complex) -> float:
    """The largest dt [s] for which RK4 amplifies none of these modes: along each ray of Re z <= 0
    |R| <= 1 holds up to one point."""
    radius = float(np.abs(spectrum).max())
    modes = (np.minimum(spectrum.real, 0.0) + 1j * spectrum.imag) / radius

    def excess(x: float) -> float:
        z = x * modes
        return float(np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))).max()) - 1 - ROUND_OFF

    return float(brentq(excess, 0.0, FARTHEST)) / radius


def linearise(
    members: Sequence[Layer], ends: Sequence[Condition], order: int, columns: int, k: float
) -> Complex:
    """Eigenvalues [1/s] of the scheme of an order about the initial data of layers from below,
    which say their cells, between two ends, for disturbances proportional to exp(i k X), k [1/m]; a
    wave is so many columns long. InputError where the layers are not at rest, or not the same in
    all columns.
    """
    wave = {"along": ((0.0, 2.0 * np.pi / k),), "cells": (columns,)}
    problem = layers(*members, **wave, lower=ends[0], upper=ends[1])
    with BlockState(MPI.COMM_SELF, problem, order, FORM) as state:
        return linear_modes(state, 0, 1)[0]


def radial_modes(problem: BlockProblem, order: int, n: int = 0, form: BlockForm = FORM) -> Complex:
    """Angular frequencies omega [1/s] of the modes of angular number n of rings around the origin,
    periodic along axis 1, or of shells in one dimension (n = 0), that swing, as exp(-i omega t),
    and are not rough, the slowest first.

    InputError where the initial data are not at rest, or the grid does not know n.
    """
    with BlockState(MPI.COMM_SELF, problem, order, form) as state:
        columns = state.layout.shapes[0][1] if problem.dimension > 1 else 1
        if 2 * n >= columns:
            known = f"-ring_around {columns} knows angular numbers from 0 to {(columns - 1) // 2}"
            raise InputError(f"-ring_angular {n}: {known}")
        values, blocks = linear_modes(state, 1, n)
    steps = [np.diff(block, axis=0) for block in blocks]
    squares = [sum((np.abs(a) ** 2).sum(axis=(0, 1)) for a in of) for of in (steps, blocks)]
    smooth = squares[0] < ROUGH * squares[1]
    omega = 1j * values[smooth & (values.imag < -SWINGING * np.abs(values).max())]
    return omega[np.argsort(omega.real)]


def linear_modes(state: BlockState, axis: int, n: int) -> tuple[Complex, list[Complex]]:
    """Eigenvalues [1/s] of what is proportional to exp(-i n phi), and of each block the amplitudes
    of its unknowns over their scales, (rows, unknowns, eigenvalues). InputError where the state is
    not at rest.

    axis: of the blocks, along which all columns are alike: 0 for flat layers, 1 for rings.
    """
    d, layout = state.problem.dimension, state.layout
    state.set_initial()
    start = state.y.array.copy()
    f = np.empty_like(start)
    columns = layout.shapes[0][axis] if d > 1 else 1
    phi = 2.0 * np.pi * np.arange(columns) / columns
    part, cos, sin = np.exp(-1j * n * phi), np.cos(axis * phi), np.sin(axis * phi)

    def block(k: int, array: Real) -> Real:
        """Return a view (rows, columns, unknowns) of block k in a vector."""
        nodes = layout.owned(k, array).reshape(*layout.shapes[k][::-1], layout.dofs[k])
        if d == 1:
            return nodes[:, None]
        return nodes if axis == 0 else nodes.swapaxes(0, 1)

    def whole(array: Real) -> Real:
        """(columns, N) of a vector; of a ring vectors along radius and angle."""
        found = []
        for k, layer in enumerate(state.problem.layers):
            turned = block(k, array).copy()
            for first in ((0, 2) if layer.kind == "solid" else (2,)) if d > 1 else ():
                a, b = turned[..., first].copy(), turned[..., first + 1].copy()
                turned[..., first], turned[..., first + 1] = cos * a + sin * b, cos * b - sin * a
            found.append(turned.swapaxes(0, 1).reshape(columns, -1))
        return np.concatenate(found, axis=1)

    def evaluate(y: Real) -> Real:
        """Return rates and projected unknowns, (2, columns, N)."""
        state.right_hand_side(y, f)
        state.project(y)
        if state.fault is not None:
            raise state.fault
        return np.stack([whole(f), whole(y)])

    of_blocks = [scales_of(state, k, block(k, start)[:, 0]) for k in range(len(layout.shapes))]
    scales = np.concatenate([sizes.ravel() for sizes, _, _ in of_blocks])
    shapes = [sizes.shape for sizes, _, _ in of_blocks]
    # velocities are disturbed by the same on both sides of interfaces
    slowest = min((sizes[:, i] / mass).min() for sizes, i, mass in of_blocks)
    for sizes, i, mass in of_blocks:
        sizes[:, i : i + d] = (slowest * mass)[:, None]
    nudges = NUDGE * np.concatenate([sizes.ravel() for sizes, _, _ in of_blocks])
    unknowns = [(k, *at) for k, shape in enumerate(shapes) for at in np.ndindex(*shape)]

    def disturbed(i: int, change: float) -> Complex:
        """The same of all columns where unknown i of column 0 is changed, (2, N)."""
        y, (k, j, c) = start.copy(), unknowns[i]
        block(k, y)[j, 0, c] += change
        return part @ evaluate(y)

    found = derivatives(disturbed, nudges)
    rates, projection = (of * scales / scales[:, None] for of in (found[0], found[1].real))
    rest, values = evaluate(start) / scales
    moving = np.abs(rest @ projection.T).max() > AT_REST * np.abs(rates).max()
    if moving or np.ptp(values, axis=0).max() > AT_REST:
        raise InputError("the blocks are not at rest at first, or not the same in all columns")
    basis = orth(projection, rcond=1e-9)
    values, vectors = np.linalg.eig(basis.T @ (projection @ rates) @ basis)
    parts = np.split(basis @ vectors, np.cumsum([rows * dofs for rows, dofs in shapes])[:-1])
    return values, [part.reshape(*shape, -1) for part, shape in zip(parts, shapes, strict=True)]


def modes_near(state: BlockState, s: complex, count: int = 1) -> Complex:
    """So many eigenvalues [1/s] next to s. InputError where the state is not steady.

    They are those of P A, A the derivative of the rates by the unknowns as the projection P leaves
    them, by differences for one unknown after the other.
    """
    state.set_initial()
    start, layout = state.y.array.copy(), state.layout
    scales, f, n = np.ones_like(start), np.empty_like(start), start.size - layout.auxiliary
    for k in range(len(layout.shapes)):
        layout.owned(k, scales)[:] = scales_of(state, k, layout.owned(k, start))[0]

    def evaluate(y: Real) -> Real:
        state.right_hand_side(y, f)
        state.project(y)
        return np.stack([f, y])[:, :n] / scales[:n]

    rest = evaluate(start.copy())
    found: tuple[list[Any], list[Any]] = [], []
    for i in range(n):
        y = start.copy()
        y[i] += TINY * scales[i]
        for columns, change in zip(found, evaluate(y) - rest):
            at = np.flatnonzero(change)
            columns.append((change[at] / TINY, at))
    matrices = []
    for columns in found:
        values, places = map(np.concatenate, zip(*columns))
        ends = np.cumsum([0, *(len(at) for _, at in columns)])
        matrices.append(sparse.csc_matrix((values, places, ends), (n, n)))
    rates, projection = matrices
    if np.abs(rest[0]).max() > AT_REST * abs(rates).max():
        raise InputError("the blocks are not in a steady state at first")
    matrix = (projection @ rates).astype(complex)
    return eigs(matrix, count, sigma=s, v0=np.ones(n), return_eigenvectors=False)


def scales_of(state: BlockState, k: int, q: Real) -> tuple[Real, int, Real]:
    """(scales of the unknowns q (nodes, unknowns) of block k at rest: those of a gas, and with its
    speed of sound; first column of velocity or momentum; what it is of a velocity of 1).
    """
    block, d = state.problem.layers[k], state.problem.dimension
    one = np.ones(len(q))
    if block.kind == "fluid":
        w, mass = block.material.equations(d).primitive(tuple(q.T)), q[:, 1]
        c = np.sqrt(block.material.gas_law.sound_speed_squared(w[0], w[2]))
        return np.stack([q[:, 0], mass, *[mass * c] * d, mass * c**2], axis=1), 2, mass
    c = np.sqrt(block.material.K / block.material.m0)
    sizes = [*[state.h * one] * d, *[c * one] * d, np.abs(q[:, 2 * d]) + c**2]
    return np.stack(sizes, axis=1), d, one
