"""What the writer keeps in memory between two writes: the frames of a run, laid out as they will stand in the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

_LINE = 8  # doubles in a cache line


class Slots(NamedTuple):
    """Where one frame goes: column c of the j-th local point of layer k to values[starts[k] + j stride + c]."""

    values: Array
    starts: np.ndarray[Any, np.dtype[np.int64]]
    stride: int


class FrameBuffer:
    """Frames of all layers' local points: for each point of a layer, its columns in one frame after the other.

    layers: as RunWriter.start_segment takes them; width: columns of a point; capacity: most frames (it may hold less).
    """

    def __init__(self, layers: Sequence[Mapping[str, Any]], width: int, capacity: int) -> None:
        # of many frames a few less: points an odd number of cache lines apart do not evict each other
        if capacity >= 8 * _LINE:
            capacity -= (capacity - _LINE) % (2 * _LINE)
        self.capacity, self.width, self.stride = capacity, width, capacity * width
        self.X = [np.array(layer["X"], dtype=np.float64).reshape(int(layer["local"])) for layer in layers]
        bounds = self.stride * np.cumsum([0, *(len(X) for X in self.X)])
        self._starts, self._ends = bounds[:-1], bounds[1:]
        self._values = np.empty(bounds[-1])

    def slots(self, frame: int) -> Slots:
        return Slots(self._values, self._starts + frame * self.width, self.stride)

    def part(self, layer: int, count: int) -> Array:
        """The first ``count`` frames of a layer, (local, count·width)."""
        part = self._values[self._starts[layer] : self._ends[layer]]
        return part.reshape(len(self.X[layer]), self.stride)[:, : count * self.width]
