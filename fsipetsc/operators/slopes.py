"""Derivatives along an axis in kernels (fsipetsc.kernels.kernel): one formula for gases, solids and
grids. Of the nodes i of an axis, with the weights S_il of fsipetsc.operators.sbp,

    D f   = sum_m [ahead_m (f_(i+m) - f_i) - behind_m (f_(i-m) - f_i)]
    D° f  = sum_m [ahead_m (f_(i+m) + f_i) - behind_m (f_(i-m) + f_i)]    without flux through ends

    ahead_m = S_i(i+m) / (2 weight_i),    behind_m = S_(i-m)i / (2 weight_i),    m = 1 … reach

Inside of a block both weights are the same up to half the order of the operator, and 0 beyond:

    D f = D° f = sum_m ahead_m (f_(i+m) - f_(i-m))

Such a sum, if exact (fsipetsc.kernels.symbols), has the same bits whichever way an axis runs.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations.vectors import add, along, choose, scale, sub
from fsipetsc.kernels.kernel import SHARED, Kernel
from fsipetsc.kernels.loops import each, otherwise, pick, when
from fsipetsc.operators.sbp import OPERATORS, Array, Band


class Stencil(NamedTuple):
    """Which neighbours a kernel takes. pairs: half the order of the operator in a kernel of nodes
    inside, else 0; reach: largest m.
    """

    pairs: int
    reach: int

    def kernel(self, name: str, says: str) -> Kernel:
        """A kernel of any nodes, which are those near ends, and few; or of nodes inside."""
        return Kernel(name + "_inside" * (self.pairs > 0), says, few=not self.pairs)

    @property
    def both(self) -> tuple["Stencil", "Stencil"]:
        """Those of kernels of any nodes and of nodes inside, from the latter."""
        return Stencil(0, self.reach), self


class Axis(NamedTuple):
    """The neighbours of the n nodes of an axis.

    weights: (n, 2 reach) ahead and behind. far: (n, 2 reach) how far nodes ahead and behind are in
    memory. columns: (2 reach, n), the weights where neighbours lie side by side, else (0, 0).
    inside: first node and first beyond of those that are inside.
    """

    weights: Array
    far: Any
    columns: Array
    inside: tuple[int, int]

    def given(self, number: int, i: Any) -> dict[str, Any]:
        """What kernels take of the axis of this number for the node i, or those from i on."""
        found = {f"far_{number}": self.far[i], f"inner_{number}": self.weights[self.inside[0]]}
        if number:
            return found | {f"w_{number}": self.weights[i]}
        return found | {"w_0": self.columns[0, i:], "row": self.weights.shape[0]}


def axis_of(band: Band, stencil: Stencil, places: Any = None) -> Axis:
    """The neighbours of the nodes of an axis; stencil: of nodes inside. places: where the nodes are
    in memory, (n,); None: they lie side by side.
    """
    pairs, reach = stencil
    n, m = len(band.weight), np.arange(1, reach + 1)
    i, S = np.arange(n)[:, None], np.zeros((1 + reach, n + reach))
    S[: 1 + band.reach, reach:] = band.S[: 1 + reach]
    ahead, behind = S[m, reach + i] * (i + m < n), S[m, reach + i - m]
    weights = np.concatenate([ahead, behind], axis=1) / (2.0 * band.weight[:, None])
    jumps = np.concatenate([m + 0 * i, -m + 0 * i], axis=1)
    if places is None:
        far, columns = jumps, weights.T.copy()
    else:  # a node that is not there is the node itself
        to = np.where(weights != 0.0, i + jumps, i)
        far, columns = places[to] - places[i], np.zeros((0, 0))
    interior = np.zeros(reach)
    interior[:pairs] = 2.0 * np.array(OPERATORS[2 * pairs].interior, float)
    even = np.flatnonzero(((ahead == interior) & (behind == interior)).all(axis=1))
    # beside an axis are nodes that are not even, and beyond them images that are
    longest = max(np.split(even, 1 + np.flatnonzero(np.diff(even) > 1)), key=len)
    inside = (int(longest[0]), int(longest[-1]) + 1) if longest.size else (0, 0)
    return Axis(weights, far, columns, inside)


def slope(kernel, f, layout, axis, stencil, count=1, first=0, free=False, apart=""):
    """D of so many numbers f along the axis of a number, or D° if it is free. In a kernel of nodes
    that are not all inside, weights along axis 0 differ from node to node, and what is beyond the
    end of a row is read, but does not count. apart: of other axes, what ``far`` is multiplied by.
    """
    pairs, reach = stencil
    here, found = () if pairs else kernel.read(f, layout, count, first), (0.0,) * count
    for m in range(pairs or reach):
        far = (f"far_{axis}[{number}]" + (apart if axis else "") for number in (m, reach + m))
        ends = (f"{layout} + {kernel.offset(text)}" for text in far)
        ahead, behind = (kernel.read(f, end, count, first) for end in ends)
        if pairs:
            (w,) = kernel.read(f"inner_{axis}", SHARED, 1, m)
            found = along(found, w, sub(ahead, behind))
            continue
        both = []
        for number, there in (m, ahead), (reach + m, behind):
            (w,) = kernel.read(f"w_{axis}", SHARED if axis else "{c} * row + {i}", 1, number)
            more = scale(w, add(there, here) if free else sub(there, here))
            both.append(more if axis else choose(w != 0.0, more, (0.0,) * count))
        found = add(found, sub(*both))
    return found


def parts(x: Any, to: Any, y: Any, z: Any, ends: Any, may_be: Any = None) -> Any:
    """Yield the parts of a row of nodes x … to - 1 that are within a box, and before and after it:
    first node, how many, whether they are within. ends: first node and first beyond along each
    axis, or None where all are within. may_be: a condition on all, too.
    """
    (begin, end), *across = ends
    for at, of_axis in zip((y, z), across, strict=True):
        if of_axis is not None:
            within = (at >= of_axis[0]) & (at < of_axis[1])
            may_be = within if may_be is None else may_be & within
    a = np.minimum(np.maximum(begin, x), to)
    a = a if may_be is None else pick(may_be, a, to)
    b = np.maximum(np.minimum(end, to), a)
    for part in each(3):
        first = pick(part == 0, x, pick(part == 1, a, b))
        n = pick(part == 0, a, pick(part == 1, b, to)) - first
        with when(n > 0):
            yield first, n, part == 1


def kinds(x: Any, n: Any, y: Any, z: Any, inside: Any) -> Iterator[Any]:
    """Yield the parts of a row of n nodes from x on, for kernels of any nodes and of those inside:
    first node, how many, and 1 where they are inside, else 0. inside: as ``ends`` of `parts`.
    """
    for begin, count, within in parts(x, x + n, y, z, inside):
        for kind, choice in ((1, when(within)), (0, otherwise())):
            with choice:
                yield begin, count, kind
