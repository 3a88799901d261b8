"""Small disturbances of rings at rest at one angular number: the scheme's own rates, linearised.

Blocks are periodic along axis 1, around the origin, and look the same from it in all directions: in
the frame of radius and angle the rates of each column are those of any other. An unknown of one row
is disturbed by cos(n theta); the part of the answer in exp(i n theta) is a column of the matrix
A(n) (see fsipetsc.analysis.wave_modes, whose means are used).

Central differences do not see what alternates from node to node. Modes that do so across the blocks
swing around them at frequencies of waves that are long. They are told by their roughness, the
squares of the differences of neighbours along the radius over those of the values: 4 where signs
alternate, 1 for a wave of 6 nodes.
"""

from __future__ import annotations

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.analysis.spectra import Complex, Real
from fsipetsc.analysis.wave_modes import DOF, Bench
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.errors import InputError

#: how much a mode swings at least, over the largest |lambda|, and how rough it may be
SWINGING, ROUGH = 1e-6, 1.0


def ring_modes(
    problem: RunProblem, order: int, n: int, form: BlockForm = BlockForm()  # noqa: B008
) -> Complex:
    """Angular frequencies omega [1/s] of the modes of angular number n that swing, as
    exp(-i omega t), and are not rough, the slowest first; the scheme is that of an order and form.

    InputError where the initial data are not at rest, or the grid does not know n.
    """
    with BlockState(MPI.COMM_SELF, problem, order, form) as state:
        state.compile(lambda text: None)
        bench = _RingBench(state, n)
        values, vectors = bench.linear(1.0).modes(0.0)
        swinging = values.imag < -SWINGING * np.abs(values).max()
        omega = 1j * values[swinging & (bench.roughness(vectors) < ROUGH)]
    return omega[np.argsort(omega.real)]


class _RingBench(Bench):
    """Disturbances of all columns at once, in the frame of radius and angle."""

    along = 1
    number = np.complex128

    def __init__(self, state: BlockState, n: int) -> None:
        (columns,) = {shape[1] for shape in state.layout.shapes}
        if not 0 <= 2 * n < columns:
            known = f"-ring_around {columns} knows angular numbers from 0 to {(columns - 1) // 2}"
            raise InputError(f"-ring_angular {n}: {known}")
        angle = 2.0 * np.pi * np.arange(columns) / columns
        self._cos, self._sin = np.cos(angle), np.sin(angle)
        self._wave, self._part = np.cos(n * angle), np.exp(-1j * n * angle) / columns
        if n > 0:
            self._part *= 2.0
        super().__init__(state, 1)

    def roughness(self, vectors: Complex) -> Real:
        """(modes,) of amplitudes (N, modes)."""
        parts = (vectors / self._scales[:, None]).reshape(len(self._rows), DOF, -1)
        blocks = np.array([k for k, _ in self._rows])
        within = np.diff(parts, axis=0)[np.diff(blocks) == 0]
        squares = ((np.abs(array) ** 2).sum(axis=(0, 1)) for array in (within, parts))
        return np.divide(*squares)

    def _disturbed(self, which: NDArray[np.int64], sizes: Real) -> tuple[Complex, Real]:
        """(rates, projected unknowns), each (1, N, len(which)), of the wave; see ``Bench``."""
        answers = [self._answer(i, size) for i, size in zip(which, sizes, strict=True)]
        f, y = (np.stack(parts, axis=-1)[None] for parts in zip(*answers, strict=True))
        return f, y.real

    def _answer(self, i: int, size: float) -> tuple[Complex, Complex]:
        """(rates, projected unknowns), (N,), where unknown i is disturbed by size cos(n theta)."""
        (k, j), y = self._rows[i // DOF], self._y.copy()
        change = np.zeros((len(self._wave), DOF))
        change[:, i % DOF] = size * self._wave
        self._block(k, y)[j] += self._turned(k, change, -1.0)
        self._evaluate(y)
        return self._part @ self._whole(self._f), self._part @ self._whole(y)

    def _whole(self, array: Real) -> Real:
        """(columns, N) of a vector, vectors along radius and angle."""
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
