"""Where a rank keeps the stages of a step: areas of one memory, all with the same things at the same places.

In an area stand, one after another, the points of each layer that the rank holds, halos among them, row by row with the
unknowns of a point side by side, and what stands behind the layers in its part of the solution.
"""

from __future__ import annotations

import numpy as np

from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.plane.layer import DOF

#: that of the solution, which is the first stage's; behind it those of the other stages; and the sum, see
#: fsipetsc.scheme.plane.targets
WORK, SUM, AREAS = 0, 4, 5
#: doubles by which areas begin further and further from the boundaries of pages
STAGGER = 136
#: doubles of a cache line: with the first point that is owned one begins, and with each row where the width allows it
LINE = 8
#: doubles behind the points of a layer, into which vectors may reach
SLACK = 64 * DOF


class Areas:
    """The memory and what is where.

    Attributes: memory; apart, doubles from an area to the next; begin, of layer k in an area; places, (local_size,), where the
    numbers of this rank's part of the solution stand in an area.
    """

    def __init__(self, layout: PlaneLayout) -> None:
        self._shapes = [(int(record["height"]), int(record["width"]), DOF) for record in layout.records]
        self.begin, self._behind = [], 0
        for (height, width, _), record, dm in zip(self._shapes, layout.records, layout.dms, strict=True):
            first = (int(record["own_y"][0]) * width + int(record["own_x"][0])) * DOF
            self.begin.append(self._behind + -(self._behind + first) % LINE)
            self._behind = self.begin[-1] + (height * width * DOF + SLACK if dm is not None else 0)
        self._behind += -self._behind % LINE
        behind = layout.behind
        self._end = self._behind + behind.stop - behind.start
        self.apart = self._end + -self._end % 512 + STAGGER  # equal points of two areas must not evict each other from caches
        room = np.zeros(AREAS * self.apart + LINE)  # one piece, for which the system may have larger pages
        self.memory = room[-(room.ctypes.data // room.itemsize) % LINE :][: AREAS * self.apart]
        self.places = np.zeros(layout.local_size, np.int64)
        for k, record in enumerate(layout.records):
            if layout.dms[k] is not None:
                numbers = self.begin[k] + np.arange(np.prod(self._shapes[k])).reshape(self._shapes[k])
                layout.local(k, self.places)[...] = numbers[slice(*record["own_y"]), slice(*record["own_x"])]
        self.places[behind] = np.arange(self._behind, self._end)

    def unknowns(self, k: int, area: int = WORK) -> np.ndarray:
        """Of the points of layer k in a row, and the room behind."""
        end = (*self.begin, self._behind)[k + 1]
        return self.memory[area * self.apart + self.begin[k] : area * self.apart + end]

    def points(self, k: int, area: int = WORK) -> np.ndarray:
        """The points of layer k, (height, width, DOF)."""
        return self.unknowns(k, area)[: int(np.prod(self._shapes[k]))].reshape(self._shapes[k])

    def behind(self, area: int = WORK) -> np.ndarray:
        """What stands behind the layers."""
        return self.memory[area * self.apart + self._behind : area * self.apart + self._end]
