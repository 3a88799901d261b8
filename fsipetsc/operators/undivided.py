"""Undivided differences along the axes of a block, of which dissipation is made.

    (Delta_q f)_i = sum_m (-1)^(q - m) C(q, m) f_(i + m),    m = 0 … q,    of nodes in the block

Dissipation takes H^-1 Delta_q^T F from the rates, with F of each difference. The weights of a
difference add up to 0, so sums of the rates stay. Next to ends a difference counts as much as the
least norm of its nodes, or it would be as much stiffer there as that is small. Differences end
where a block does; a node of a join has those of both sides.
"""

from collections.abc import Callable, Sequence
from math import comb
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.equations.vectors import along, scale
from fsipetsc.operators.bands import Band

Array = NDArray[np.float64]
#: usual size of dissipation: differences of order q, half that of the scheme, count sigma / 4^q
SIGMA = 0.3


def sigma_of(option: float, joined: bool) -> float:
    """sigma of -fsi_dissipation: 0 is 1 where blocks are joined, below 0 is none even there."""
    return SIGMA * max(0.0, option if option != 0.0 else float(joined))


class Differences(NamedTuple):
    """Those of a patch, over its ghosted array of N nodes, axis 0 contiguous.

    weights: (q + 1) numbers of a difference. strides: of the axes in memory. norm: (axes, N) the
    least norm of the nodes of the difference that begins at a node, 0 where it does not fit.
    per_weight: (axes, N) 1 / weight of a node along the axis.
    """

    weights: tuple[float, ...]
    strides: Array
    norm: Array
    per_weight: Array

    def room(self, d: int) -> int:
        """Numbers of a component of all differences, after zeros for those before the first."""
        return self.norm.shape[1] + (len(self.weights) - 1) * int(self.strides[d - 1])


def differences(d: int, order: int, bands: Sequence[Band], cells: Sequence[int]) -> Differences:
    """Of half the order of the scheme. bands: three, cut to the ghosted array; cells: of the whole
    block, by axis.
    """
    q = order // 2
    shape = [len(band.weight) for band in bands]
    norm, per_weight = [], []
    for k in range(d):
        H, n = bands[k].weight * cells[k], shape[k]
        least = np.zeros(n)
        for i in range(n - q):
            least[i] = min(1.0, *H[i : i + q + 1])
        for found, line in ((norm, least), (per_weight, 1.0 / bands[k].weight)):
            axes = line.reshape([n if k == 2 - j else 1 for j in range(3)])
            found.append(np.broadcast_to(axes, shape[::-1]).ravel())
    weights = tuple(float((-1) ** (q - m) * comb(q, m)) for m in range(q + 1))
    strides = np.array([1, shape[0], shape[0] * shape[1]])
    return Differences(weights, strides, np.array(norm), np.array(per_weight))


def difference(read: Callable[[Any], Any], i: Any, stride: Any, weights: Any) -> Any:
    """sum_m weights_m f_(i + m stride); read: says the numbers f of a node."""
    found = scale(weights[0], read(i))
    for m in range(1, len(weights)):
        found = along(found, weights[m], read(i + m * stride))
    return found
