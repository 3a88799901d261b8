"""Small disturbances of blocks at rest: the scheme's own right-hand side, linearised.

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
"""

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI
from scipy.linalg import orth

from fsipetsc.analysis.spectra import CENTRAL, Complex, Real
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blocks.conditions import Condition
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.errors import InputError

#: least disturbance, as a fraction of what there is
NUDGE = 0.005
#: rates at rest and columns that differ by more than this fraction are no state at rest
AT_REST = 1e-9
#: how much a mode swings at least, over the largest |lambda|, and how rough it may be
SWINGING, ROUGH = 1e-6, 1.0
FORM = BlockForm()


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
        return Bench(state, 0, 1).modes()[0]


def radial_modes(problem: BlockProblem, order: int, n: int = 0, form: BlockForm = FORM) -> Complex:
    """Angular frequencies omega [1/s] of the modes of angular number n of rings around the origin,
    periodic along axis 1, or of shells in one dimension (n = 0), that swing, as exp(-i omega t),
    and are not rough, the slowest first.

    InputError where the initial data are not at rest, or the grid does not know n.
    """
    with BlockState(MPI.COMM_SELF, problem, order, form) as state:
        columns = state.layout.shapes[0][1] if problem.dimension > 1 else 1
        if n and not 0 <= 2 * n < columns:
            known = f"-ring_around {columns} knows angular numbers from 0 to {(columns - 1) // 2}"
            raise InputError(f"-ring_angular {n}: {known}")
        bench = Bench(state, 1, n)
        values, vectors = bench.modes()
    blocks = np.split(vectors, np.cumsum([rows * dof for rows, dof in bench.shapes])[:-1])
    parts = [part.reshape(*shape, -1) for part, shape in zip(blocks, bench.shapes, strict=True)]
    steps = [np.diff(part, axis=0) for part in parts]
    squares = [sum((np.abs(a) ** 2).sum(axis=(0, 1)) for a in of) for of in (steps, parts)]
    smooth = squares[0] < ROUGH * squares[1]
    omega = 1j * values[smooth & (values.imag < -SWINGING * np.abs(values).max())]
    return omega[np.argsort(omega.real)]


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


class Bench:
    """A state on which one unknown of column 0 after the other is disturbed.

    axis: of the blocks, along which all columns are alike: 0 for flat layers, 1 for rings.
    shapes: (rows, unknowns) of each block.
    """

    def __init__(self, state: BlockState, axis: int, n: int) -> None:
        self._state, self._axis, self._d = state, axis, state.problem.dimension
        state.compile(lambda text: None)
        state.set_initial()
        self._y = state.y.array.copy()
        self._f = np.empty_like(self._y)
        columns = state.layout.shapes[0][axis] if self._d > 1 else 1
        phi = 2.0 * np.pi * np.arange(columns) / columns
        self._part = np.exp(-1j * n * phi)
        #: of the frame of each column
        turning = axis == 1 and self._d > 1
        self._cos, self._sin = (np.cos(phi), np.sin(phi)) if turning else (1.0, 0.0)
        blocks = range(len(state.layout.shapes))
        found = [scales_of(state, k, self._block(k, self._y)[:, 0]) for k in blocks]
        self.shapes = [scales.shape for scales, _, _ in found]
        self._scales = np.concatenate([scales.ravel() for scales, _, _ in found])
        # velocities are disturbed by the same on both sides of interfaces
        slowest = min((scales[:, i] / mass).min() for scales, i, mass in found)
        for scales, i, mass in found:
            scales[:, i : i + self._d] = (slowest * mass)[:, None]
        self._nudges = np.concatenate([scales.ravel() for scales, _, _ in found])

    def modes(self) -> tuple[Complex, Complex]:
        """Eigenvalues [1/s], and (N, n) of the amplitudes of the N unknowns of a column of all
        blocks, over their scales. InputError where the state is not at rest."""
        size = len(self._scales)
        rates, projection = np.zeros((2, size, size), complex)
        shapes = enumerate(self.shapes)
        unknowns = [(k, *of_block) for k, shape in shapes for of_block in np.ndindex(*shape)]
        for i, unknown in enumerate(unknowns):
            step = NUDGE * self._nudges[i]
            for multiple, weight in enumerate(CENTRAL, 1):
                for sign in (1, -1):
                    f, y = self._disturbed(*unknown, sign * multiple * step)
                    rates[:, i] += sign * weight / step * f
                    projection[:, i] += sign * weight / step * y
        relative = self._scales / self._scales[:, None]
        rates, projection = rates * relative, projection.real * relative
        self._evaluate(self._y)
        rest, values = (self._whole(array) / self._scales for array in (self._f, self._y))
        moving = np.abs(rest @ projection.T).max() > AT_REST * np.abs(rates).max()
        if moving or np.ptp(values, axis=0).max() > AT_REST:
            raise InputError("the blocks are not at rest at first, or not the same in all columns")
        basis = orth(projection, rcond=1e-9)
        values, vectors = np.linalg.eig(basis.T @ (projection @ rates) @ basis)
        return values, basis @ vectors

    def _evaluate(self, y: Real) -> None:
        """Rates, and y projected in its place."""
        self._state.right_hand_side(y, self._f)
        self._state.project(y)
        if self._state.fault is not None:
            raise self._state.fault

    def _block(self, k: int, array: Real) -> Real:
        """(rows, columns, unknowns) of block k in a vector."""
        layout = self._state.layout
        nodes = layout.owned(k, array).reshape(*layout.shapes[k][::-1], layout.dofs[k])
        if self._d == 1:
            return nodes[:, None]
        return nodes if self._axis == 0 else nodes.swapaxes(0, 1)

    def _disturbed(self, k: int, j: int, c: int, size: float) -> tuple[Complex, Complex]:
        """(rates, projected unknowns), (N,), where unknown c of row j of block k is disturbed."""
        y = self._y.copy()
        self._block(k, y)[j, 0, c] += size
        self._evaluate(y)
        return self._part @ self._whole(self._f), self._part @ self._whole(y)

    def _whole(self, array: Real) -> Real:
        """(columns, N) of a vector; of a ring vectors along radius and angle."""
        found = []
        for k, layer in enumerate(self._state.problem.layers):
            nodes = self._block(k, array)
            turned = nodes.copy()
            for first in ((0, 2) if layer.kind == "solid" else (2,)) if self._d > 1 else ():
                a, b = nodes[..., first], nodes[..., first + 1]
                turned[..., first] = self._cos * a + self._sin * b
                turned[..., first + 1] = self._cos * b - self._sin * a
            found.append(turned.swapaxes(0, 1).reshape(turned.shape[1], -1))
        return np.concatenate(found, axis=1)
