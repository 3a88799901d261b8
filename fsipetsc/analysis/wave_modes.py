"""Small disturbances of layers at rest in two dimensions, by wave number along them.

The scheme's own right-hand side is linearised. Layers that are periodic in X and at rest are given
a few columns. One unknown of one column is disturbed at a time; the rates of that column and its
neighbours, R_m at m columns from it, are found by central differences of order 8, and what is
proportional to exp(i k X) then changes by the matrix

    A(k) = sum_m R_m exp(-i k m h_x),

for all wave numbers k at once. What may be disturbed is what the projection lets through: A acts on
its range. Derivatives along X are all those of D, twice where there are two of them, so that A
depends on k by the symbol kappa = i^-1 sum_m D_m exp(i k m h_x) alone: k h_x up to pi is kappa from
0 up to its greatest value, and back to 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.analysis.spectra import CENTRAL, Complex, Real, bisect, range_basis
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.blocks.conditions import Condition
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import OPERATORS

#: unknowns of a node of gas or solid in two dimensions
DOF = 5
#: least disturbance, as a fraction of what there is
NUDGE = 0.005
#: rates at rest and columns that differ by more than this fraction are no state at rest
AT_REST = 1e-9


class Stack(NamedTuple):
    """Layers (fsipetsc.blocks.layers) from below, which say their cells; what is at both ends."""

    layers: tuple[Layer, ...]
    lower: Condition
    upper: Condition


@dataclass(frozen=True)
class WaveLinear:
    """Rates and projection of small disturbances of N unknowns, DOF x rows of all layers.

    rates: (2 m + 1, N, N), [m + l, i, j] of unknown i, l columns from where unknown j is disturbed
    [1/s]; projection: (N, N), within a column; scales: (N,) of the unknowns, over which both are
    taken; h_x: distance of the columns [m].
    """

    rates: Real
    projection: Real
    scales: Real
    h_x: float

    def matrix(self, k: float) -> tuple[Complex, Real]:
        """((n, n), dz/dt = A z of amplitudes at wave number k [1/m]; (N, n), basis of these)."""
        reach = len(self.rates) // 2
        phases = np.exp(-1j * k * self.h_x * np.arange(-reach, reach + 1))
        basis = range_basis(self.projection)
        rates = np.tensordot(phases, self.rates, 1)
        return basis.T @ (self.projection @ rates) @ basis, basis

    def modes(self, k: float) -> tuple[Complex, Complex]:
        """(eigenvalues [1/s], (N, n) of the amplitudes of the unknowns)."""
        matrix, basis = self.matrix(k)
        values, vectors = np.linalg.eig(matrix)
        return values, self.scales[:, None] * (basis @ vectors)


def symbol(order: int, h: float, k: float | Real) -> float | Real:
    """kappa of the interior formula of D at wave number k, both in 1/m."""
    weights = OPERATORS[order].interior
    return sum(2.0 * float(weight) * np.sin(m * k * h) for m, weight in enumerate(weights, 1)) / h


def most(order: int, h: float) -> tuple[float, float]:
    """(k, kappa) where the symbol is greatest, 1/m."""
    angles = np.linspace(0.0, np.pi, 4001)
    top = angles[np.argmax(symbol(order, 1.0, angles))] / h
    return float(top), float(symbol(order, h, top))


def wave_number(order: int, h: float, kappa: float) -> float:
    """The least k whose symbol is kappa. InputError where no wave on the grid has it."""
    high, greatest = most(order, h)
    if not 0 <= kappa <= greatest:
        raise InputError(f"wave number {kappa:g}: waves on this grid go up to {greatest:g}")
    return bisect(lambda k: symbol(order, h, k) >= kappa, 0.0, high) if kappa > 0.0 else 0.0


def linearise(
    stack: Stack, order: int, h_x: float, nudge: float = NUDGE, form: BlockForm = BlockForm()  # noqa: B008
) -> WaveLinear:
    """The scheme of an order and form, columns h_x apart [m], about the initial data of layers.

    InputError where these are not at rest, or not the same in all columns.
    """
    width = 4 * OPERATORS[order].p + 1
    columns = DOF * width
    ends = {"lower": stack.lower, "upper": stack.upper}
    problem = layers(*stack.layers, along=((0.0, columns * h_x),), cells=(columns,), **ends)
    with BlockState(MPI.COMM_SELF, RunProblem(problem), order, form) as state:
        state.compile(lambda text: None)
        return Bench(state, width).linear(h_x, nudge)


class Bench:
    """A state on which one unknown after the other is disturbed.

    Those of a row are disturbed side by side, ``width`` columns apart.
    """

    #: axis of the blocks along which all columns are alike
    along = 0
    number: type = np.float64

    def __init__(self, state: BlockState, width: int) -> None:
        self._state, self._width = state, width
        state.set_initial()
        self._y = state.y.array.copy()
        self._f = np.empty_like(self._y)
        rows = [shape[1 - self.along] for shape in state.layout.shapes]
        self._rows = [(k, j) for k, n in enumerate(rows) for j in range(n)]
        self._scales = self._find_scales()

    def linear(self, h_x: float, nudge: float = NUDGE) -> WaveLinear:
        """Disturb all, the unknowns of a row at once. InputError where the state is not at rest."""
        size, width = len(self._scales), self._width
        rates, projection = np.zeros((width, size, size), self.number), np.zeros((size, size))
        sizes = self._nudges(nudge)
        for first in range(0, size, DOF):
            which = np.arange(first, first + DOF)
            for steps, weight in enumerate(CENTRAL, 1):
                for sign in (1, -1):
                    f, y = self._disturbed(which, sign * steps * sizes[which])
                    rates[:, :, which] += sign * weight * f
                    projection[:, which] += sign * weight * y[width // 2]
            rates[:, :, which] /= sizes[which]
            projection[:, which] /= sizes[which]
        relative = self._scales[None, :] / self._scales[:, None]
        linear = WaveLinear(rates * relative, _rounded(projection * relative), self._scales, h_x)
        self._check(linear)
        return linear

    def _check(self, linear: WaveLinear) -> None:
        self._evaluate(self._y)
        rates, values = (self._whole(array) / self._scales for array in (self._f, self._y))
        moving = np.abs(rates @ linear.projection.T).max() > AT_REST * np.abs(linear.rates).max()
        if moving or np.ptp(values, axis=0).max() > AT_REST:
            raise InputError("the layers are not at rest at first, or not the same for all X")

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
        return nodes if self.along == 0 else nodes.swapaxes(0, 1)

    def _find_scales(self) -> Real:
        """Of the unknowns of each row: those at rest of a gas, and with its speed of sound."""
        found = []
        for k, block in enumerate(self._state.problem.layers):
            q, material = self._block(k, self._y)[:, 0], block.material
            if block.kind == "fluid":
                w, mass = material.equations(2).primitive(tuple(q.T)), q[:, 1]
                c = np.sqrt(material.gas_law.sound_speed_squared(w[0], w[2]))
                rows = [q[:, 0], mass, mass * c, mass * c, mass * c**2]
            else:
                c, one = np.sqrt(material.K / material.m0), np.ones(len(q))
                near = self._state.h * one
                rows = [near, near, c * one, c * one, np.abs(q[:, 4]) + c**2]
            found.append(np.stack(rows, axis=1))
        return np.concatenate(found).ravel()

    def _nudges(self, nudge: float) -> Real:
        """What each unknown is disturbed by; velocities by the same on both sides of interfaces."""
        sizes = self._scales.reshape(-1, DOF).copy()
        gas = np.array([self._state.problem.layers[k].kind == "fluid" for k, _ in self._rows])
        mass = np.where(gas, sizes[:, 1], 1.0)
        slowest = (sizes[:, 2] / mass).min()
        sizes[:, 2:4] = (slowest * mass)[:, None]
        return nudge * sizes.ravel()

    def _disturbed(self, which: NDArray[np.int64], sizes: Real) -> tuple[Real, Real]:
        """(rates, projected unknowns), each (columns, N, len(which)), where each of these unknowns
        is disturbed by its size.
        """
        width, y = self._width, self._y.copy()
        for n, (i, size) in enumerate(zip(which, sizes, strict=True)):
            k, j = self._rows[i // DOF]
            self._block(k, y)[j, n * width + width // 2, i % DOF] += size
        self._evaluate(y)
        both = (self._whole(array).reshape(DOF, width, -1) for array in (self._f, y))
        return tuple(np.moveaxis(array, 0, 2) for array in both)

    def _whole(self, array: Real) -> Real:
        """(columns, N) of a vector."""
        blocks = range(len(self._state.layout.shapes))
        rows = np.concatenate([self._block(k, array) for k in blocks])
        return rows.transpose(1, 0, 2).reshape(rows.shape[1], -1)


def _rounded(projection: Real) -> Real:
    """A projection whose rows that change nothing do so exactly."""
    same, none = np.eye(len(projection)), np.abs(projection) < 1e-11
    return np.where(np.abs(projection - same) < 1e-11, same, np.where(none, 0.0, projection))
