"""What the writer keeps in memory between two writes: the frames of a run, laid out as they will stand in the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

_LINE = 8  # doubles in a cache line


class Slots(NamedTuple):
    """Where one frame goes: column c of the j-th local point of layer k to values[starts[k] + j stride + c].

    stride: an array, of each layer, where layers have different numbers of columns.
    """

    values: Array
    starts: np.ndarray[Any, np.dtype[np.int64]]
    stride: Any


class FrameBuffer:
    """Frames of all layers' local points: for each point of a layer, its columns in one frame after the other.

    layers: as RunWriter.start_segment takes them; widths: columns of a point of each; capacity: most frames (it may hold
    less).
    """

    def __init__(self, layers: Sequence[Mapping[str, Any]], widths: int | Sequence[int], capacity: int) -> None:
        # of many frames a few less: points an odd number of cache lines apart do not evict each other
        if capacity >= 8 * _LINE:
            capacity -= (capacity - _LINE) % (2 * _LINE)
        self.capacity, self._widths = capacity, np.broadcast_to(np.array(widths, np.int64), len(layers))
        self._strides = capacity * self._widths
        same = len(set(self._strides.tolist())) == 1
        self.stride = int(self._strides[0]) if same else self._strides
        # numbers of points, or these and coordinates side by side
        self.X = [_as_columns(np.array(layer["X"], dtype=np.float64), int(layer["local"])) for layer in layers]
        bounds = np.cumsum([0, *(len(X) * int(stride) for X, stride in zip(self.X, self._strides, strict=True))])
        self._starts, self._ends = bounds[:-1], bounds[1:]
        self._values = np.empty(bounds[-1])

    def slots(self, frame: int) -> Slots:
        return Slots(self._values, self._starts + frame * self._widths, self.stride)

    def part(self, layer: int, count: int) -> Array:
        """The first ``count`` frames of a layer, (local, count·width)."""
        part = self._values[self._starts[layer] : self._ends[layer]]
        width, stride = int(self._widths[layer]), int(self._strides[layer])
        return part.reshape(len(self.X[layer]), stride)[:, : count * width]


def _as_columns(X: Array, local: int) -> Array:
    return X.reshape(local, X.shape[1] if X.ndim == 2 else 1)
