"""The scheme of blocks in one dimension: the same right-hand side in few compiled calls.

A step of some hundred nodes is short, so that calls from Python, each with dozens of arrays, would
take 30 times as long as the arithmetic. Here each part is a record in a box. A rank that has all
blocks makes stages, and where no data depend on time many steps, in one call; else the calls of a
stage are those between the exchanges.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.block_scheme import Scheme
from fsipetsc.blockrun.gas_part import GasPart
from fsipetsc.operators.boxed import Box, with_calls
from fsipetsc.parallel.block_layout import BlockVector
from fsipetsc.scheme import line_parts, line_steps
from fsipetsc.scheme.block_look import LEAST_J, LOOKED
from fsipetsc.scheme.line_steps import COMPLETE, LOOK, RATES, STEPS, Found, Line

Array = NDArray[Any]
#: sums of a look, in their order
OF_GAS, OF_SOLID = ("mass", "momentum_x", "energy", "entropy"), ("momentum_x", "energy")


class LineScheme(Scheme):
    """See fsipetsc.blockrun.block_scheme.Scheme; `attach` comes before all but `initial`."""

    def attach(
        self, columns: dict[str, slice], ends: list[tuple[int, int, int, float]], alone: bool
    ) -> None:
        """Make the records of the parts. Collective.

        columns: of the sums in the record of a step. ends: number, block, owned row, X of the
        interfaces whose solid's end is here. alone: there is one rank.
        """
        self.particles.find_normals(self._metrics)  # they do not turn
        first = {name: where.start for name, where in columns.items()}
        self._lines: dict[int, Any] = {}
        for k, part in self.parts.items():
            if isinstance(part, GasPart):
                sums = np.array([first[name] for name in OF_GAS])
                sums[0] += self._columns[k]
                self._lines[k] = part.line(self._columns[k], sums)
            else:
                own = [(number, row, X) for number, block, row, X in ends if block == k]
                stored = self.particles.members.get(k, (np.zeros(0, int), np.zeros(0, int)))
                columns_here = np.array([first[name] for name in OF_SOLID])
                self._lines[k] = part.line(columns_here, own, stored)
        self.alone = alone and not any(part.part.has_halo for part in self.parts.values())
        self._filled: float | None = None  # when the data were asked for
        self._boxes = {k: Box(line) for k, line in self._lines.items()}

    def attach_steps(self, memory: tuple[Array, ...], words: Any, burst: Array, rows: Array) -> None:
        """What steps take and fill, before all but `initial`: see fsipetsc.scheme.line_steps.Found.
        """
        self._found = Found(*memory, self._gain, *words, burst, rows, np.zeros(2))
        found, y, gain = Box(self._found), self._found.y, self._gain
        particles = self.particles.box
        takes = (particles, y), (particles,), (y, y, gain), (y,), (found,)
        held = [
            with_calls(line_parts.hold, box, dict(zip(self._calls(k), takes, strict=True)))
            for k, box in self._boxes.items()
        ]
        self._all = Box(Line(tuple(held), self.particles.held(y, gain), found))

    def _calls(self, k: int) -> tuple[Any, ...]:
        """What is done with a block's part: fsipetsc.scheme.line_parts.Held, without `part`."""
        if k in self._columns:
            return line_parts.OF_GAS
        stores = self.particles.stores and not self.parts[k].equations.coupled
        return line_parts.OF_STORING_SOLID if stores else line_parts.OF_SOLID

    def _refresh(self, t: float) -> None:
        """Data of the case at time t [s]."""
        if self._filled is None or not self.steady:
            self.particles.refresh(t)
            for part in self.parts.values():
                part.refresh(t)
            self._filled = t

    def _share(self, t: float, y: BlockVector) -> None:
        self._refresh(t)
        self.particles.share(y.array, t, self._gain)

    def complete(self, t: float, y: BlockVector) -> None:
        """Let y obey all that holds its particles, in place. Collective."""
        if self.alone:
            self._refresh(t)
            line_steps.run(self._all, COMPLETE, y.array, y.array)
            return
        self._share(t, y)
        if self.particles.stores:
            self._find_stored(y)
        self.particles.settle(y.array, self._gain)
        self._move(t)

    def _move(self, t: float) -> None:
        """Let the grids follow solids and walls: places and velocities. Collective."""
        for gas in self._gases:
            line_parts.follow_gas(self._boxes[gas.part.k], self.particles.box)
            gas.gather.begin()
        for gas in self._gases:
            gas.gather.end()
            line_parts.move_gas(self._boxes[gas.part.k])

    def rates(self, t: float, y: BlockVector, f: Array) -> None:
        """f = dy/dt for a completed y. Collective."""
        if t != self._filled:
            self._refresh(t)
        if self.alone:
            line_steps.run(self._all, RATES, y.array, f)
            return
        gain = self._gain
        gain[:] = 0.0
        y.begin()
        y.end()
        for k, box in self._boxes.items():
            self._calls(k)[2](box, y.array, f, gain)
        self.particles.constrain(y.array, f, gain)

    def bounds(self, t: float, y: BlockVector) -> Array:
        """See Scheme.bounds."""
        if self.alone:
            line_steps.run(self._all, LOOK, y.array, y.array)
        else:
            for k, box in self._boxes.items():
                self._calls(k)[3](box, y.array)
        found = np.zeros((len(self.problem.blocks), LOOKED))
        found[:, LEAST_J] = -np.inf
        self._sums = {}
        for k, line in self._lines.items():
            found[k] = line.seen
            names = OF_GAS if k in self._columns else OF_SOLID
            self._sums[k] = dict(zip(names, line.sums.tolist(), strict=True))
        return found

    def steps(self, t: float, dt: float) -> tuple[bool, float, float]:
        """Steps from t [s] as the burst allows, the first of dt [s]: whether all ended well, and the
        time that is reached; or begin and length of a step that is to be made anew.
        """
        self._refresh(t)
        self._found.now[:] = t, dt
        ended_well = line_steps.run(self._all, STEPS, self._found.stage, self._found.k)
        return bool(ended_well), float(self._found.now[0]), float(self._found.now[1])
