"""Small disturbances of blocks at rest that look alike in all columns: flat layers, and rings.

The scheme's own right-hand side is linearised. Blocks are periodic along one axis, and their
columns across it are alike at rest; those of a ring in the frame of radius and angle. Unknown j of
all columns is disturbed by cos(n phi), phi = 2 pi m / M in column m of M. The part of the rates in
exp(i n phi), found by central differences of order 8, is column j of a matrix A(n), by which what
is proportional to exp(i n phi) changes. What may be disturbed is what the projection P lets
through: P A acts on its range.

Central differences do not see what alternates from node to node. Modes of a ring that do so across
the blocks swing around them at frequencies of waves that are long. They are told by their
roughness, the squares of the differences of neighbours along the radius over those of the values: 4
where signs alternate, 1 for a wave of 6 nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from mpi4py import MPI

from fsipetsc.analysis.spectra import CENTRAL, Complex, Real, range_basis
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.blocks.conditions import Condition
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.errors import InputError

#: unknowns of a node of gas or solid in two dimensions
DOF = 5
#: least disturbance, as a fraction of what there is
NUDGE = 0.005
#: rates at rest and columns that differ by more than this fraction are no state at rest
AT_REST = 1e-9
#: how much a mode swings at least, over the largest |lambda|, and how rough it may be
SWINGING, ROUGH = 1e-6, 1.0
FORM = BlockForm()


class Stack(NamedTuple):
    """Layers (fsipetsc.blocks.layers) from below, which say their cells; what is at both ends."""

    layers: tuple[Layer, ...]
    lower: Condition
    upper: Condition


class Linear(NamedTuple):
    """A (N, N) [1/s] and P (N, N) of N unknowns, DOF x rows of all blocks, over their scales."""

    rates: Complex
    projection: Real
    scales: Real

    def matrix(self) -> tuple[Complex, Real]:
        """((n, n), dz/dt = A z of amplitudes; (N, n), basis of these)."""
        basis = range_basis(self.projection)
        return basis.T @ (self.projection @ self.rates) @ basis, basis

    def modes(self) -> tuple[Complex, Complex]:
        """(eigenvalues [1/s], (N, n) of the amplitudes of the unknowns)."""
        matrix, basis = self.matrix()
        values, vectors = np.linalg.eig(matrix)
        return values, self.scales[:, None] * (basis @ vectors)


def linearise(
    stack: Stack, order: int, columns: int, k: float, nudge: float = NUDGE, form: BlockForm = FORM
) -> Linear:
    """The scheme of an order and form about the initial data of layers, for disturbances
    proportional to exp(i k X), k [1/m]; a wave is so many columns long.

    InputError where the layers are not at rest, or not the same in all columns.
    """
    ends = {"lower": stack.lower, "upper": stack.upper}
    problem = layers(*stack.layers, along=((0.0, 2.0 * np.pi / k),), cells=(columns,), **ends)
    with BlockState(MPI.COMM_SELF, RunProblem(problem), order, form) as state:
        state.compile(lambda text: None)
        return Bench(state, 0, 1).linear(nudge)


def ring_modes(problem: RunProblem, order: int, n: int, form: BlockForm = FORM) -> Complex:
    """Angular frequencies omega [1/s] of the modes of angular number n of rings around the origin,
    periodic along axis 1, that swing, as exp(-i omega t), and are not rough, the slowest first.

    InputError where the initial data are not at rest, or the grid does not know n.
    """
    with BlockState(MPI.COMM_SELF, problem, order, form) as state:
        state.compile(lambda text: None)
        (columns,) = {shape[1] for shape in state.layout.shapes}
        if not 0 <= 2 * n < columns:
            known = f"-ring_around {columns} knows angular numbers from 0 to {(columns - 1) // 2}"
            raise InputError(f"-ring_angular {n}: {known}")
        bench = Bench(state, 1, n)
        values, vectors = bench.linear().modes()
        return swinging(values, bench.by_blocks(vectors))


def swinging(values: Complex, parts: Sequence[Complex]) -> Complex:
    """omega = i values of the modes that swing and are not rough, the slowest first.

    parts: of each block (nodes across it, unknowns, modes), over their scales.
    """
    steps = [np.diff(part, axis=0) for part in parts]
    squares = [sum((np.abs(a) ** 2).sum(axis=(0, 1)) for a in of) for of in (steps, parts)]
    smooth = squares[0] < ROUGH * squares[1]
    omega = 1j * values[smooth & (values.imag < -SWINGING * np.abs(values).max())]
    return omega[np.argsort(omega.real)]


def scales_of(state: BlockState, k: int, q: Real) -> Real:
    """Of the unknowns q (nodes, unknowns) of block k at rest: those of a gas, and with its speed of
    sound.
    """
    block, d = state.problem.layers[k], state.problem.dimension
    if block.kind == "fluid":
        w, mass = block.material.equations(d).primitive(tuple(q.T)), q[:, 1]
        c = np.sqrt(block.material.gas_law.sound_speed_squared(w[0], w[2]))
        return np.stack([q[:, 0], mass, *[mass * c] * d, mass * c**2], axis=1)
    c, one = np.sqrt(block.material.K / block.material.m0), np.ones(len(q))
    return np.stack([*[state.h * one] * d, *[c * one] * d, np.abs(q[:, 2 * d]) + c**2], axis=1)


class Bench:
    """A state on which one unknown after the other is disturbed by cos(n phi).

    axis: of the blocks, along which all columns are alike: 0 for flat layers, 1 for rings.
    """

    def __init__(self, state: BlockState, axis: int, n: int) -> None:
        self._state, self._axis = state, axis
        state.set_initial()
        self._y = state.y.array.copy()
        self._f = np.empty_like(self._y)
        columns = state.layout.shapes[0][axis]
        phi = 2.0 * np.pi * np.arange(columns) / columns
        self._wave = np.cos(n * phi)
        self._part = (2.0 if n > 0 else 1.0) * np.exp(-1j * n * phi) / columns
        #: of the frame of each column
        self._cos, self._sin = (np.cos(phi), np.sin(phi)) if axis == 1 else (1.0, 0.0)
        rows = [shape[1 - axis] for shape in state.layout.shapes]
        self._rows = [(k, j) for k, count in enumerate(rows) for j in range(count)]
        blocks = range(len(rows))
        scales = [scales_of(state, k, self._block(k, self._y)[:, 0]) for k in blocks]
        self._scales = np.concatenate(scales).ravel()

    def linear(self, nudge: float = NUDGE) -> Linear:
        """Disturb all unknowns. InputError where the state is not at rest."""
        size = len(self._scales)
        rates, projection = np.zeros((2, size, size), complex)
        for i, step in enumerate(self._nudges(nudge)):
            for multiple, weight in enumerate(CENTRAL, 1):
                for sign in (1, -1):
                    f, y = self._disturbed(i, sign * multiple * step)
                    rates[:, i] += sign * weight / step * f
                    projection[:, i] += sign * weight / step * y
        relative = self._scales / self._scales[:, None]
        linear = Linear(rates * relative, _rounded(projection.real * relative), self._scales)
        self._check(linear)
        return linear

    def by_blocks(self, vectors: Complex) -> list[Complex]:
        """Of each block (rows, DOF, modes) of amplitudes (N, modes), over their scales."""
        parts = (vectors / self._scales[:, None]).reshape(len(self._rows), DOF, -1)
        blocks = np.array([k for k, _ in self._rows])
        return np.split(parts, np.flatnonzero(np.diff(blocks)) + 1)

    def _check(self, linear: Linear) -> None:
        self._evaluate(self._y)
        rates, values = (self._whole(array) / self._scales for array in (self._f, self._y))
        moving = np.abs(rates @ linear.projection.T).max() > AT_REST * np.abs(linear.rates).max()
        if moving or np.ptp(values, axis=0).max() > AT_REST:
            raise InputError("the blocks are not at rest at first, or not the same in all columns")

    def _evaluate(self, y: Real) -> None:
        """Rates, and y projected in its place."""
        self._state.right_hand_side(y, self._f)
        self._state.project(y)
        if self._state.fault is not None:
            raise self._state.fault

    def _block(self, k: int, array: Real) -> Real:
        """(rows, columns, unknowns) of block k in a vector."""
        layout = self._state.layout
        nodes = layout.owned(k, array).reshape(*layout.shapes[k][::-1], DOF)
        return nodes if self._axis == 0 else nodes.swapaxes(0, 1)

    def _nudges(self, nudge: float) -> Real:
        """What each unknown is disturbed by; velocities by the same on both sides of interfaces."""
        sizes = self._scales.reshape(-1, DOF).copy()
        gas = np.array([self._state.problem.layers[k].kind == "fluid" for k, _ in self._rows])
        mass = np.where(gas, sizes[:, 1], 1.0)
        slowest = (sizes[:, 2] / mass).min()
        sizes[:, 2:4] = (slowest * mass)[:, None]
        return nudge * sizes.ravel()

    def _disturbed(self, i: int, size: float) -> tuple[Complex, Complex]:
        """(rates, projected unknowns), (N,), where unknown i is disturbed by size cos(n phi)."""
        (k, j), y = self._rows[i // DOF], self._y.copy()
        change = np.zeros((len(self._wave), DOF))
        change[:, i % DOF] = size * self._wave
        self._block(k, y)[j] += self._turned(k, change, -1.0)
        self._evaluate(y)
        return self._part @ self._whole(self._f), self._part @ self._whole(y)

    def _whole(self, array: Real) -> Real:
        """(columns, N) of a vector; of a ring vectors along radius and angle."""
        blocks = range(len(self._state.layout.shapes))
        rows = np.concatenate([self._turned(k, self._block(k, array), 1.0) for k in blocks])
        return rows.transpose(1, 0, 2).reshape(rows.shape[1], -1)

    def _turned(self, k: int, values: Real, sense: float) -> Real:
        """(…, columns, DOF) of block k: from x and y to radius and angle, or back with sense -1."""
        turned, sine = values.copy(), sense * self._sin
        solid = self._state.problem.layers[k].kind == "solid"
        for first in (0, 2) if solid else (2,):
            a, b = values[..., first], values[..., first + 1]
            turned[..., first] = self._cos * a + sine * b
            turned[..., first + 1] = self._cos * b - sine * a
        return turned


def _rounded(projection: Real) -> Real:
    """A projection whose rows that change nothing do so exactly."""
    same, none = np.eye(len(projection)), np.abs(projection) < 1e-11
    return np.where(np.abs(projection - same) < 1e-11, same, np.where(none, 0.0, projection))
