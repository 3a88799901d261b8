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
from fsipetsc.operators.boxed import Box
from fsipetsc.parallel.block_layout import BlockVector
from fsipetsc.scheme import line_parts, line_steps
from fsipetsc.scheme.block_look import LEAST_J, LOOKED
from fsipetsc.scheme.line_steps import COMPLETE, LOOK, RATES, STEPS, Found, Line

Array = NDArray[Any]


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
        momentum, energy = columns["momentum_x"].start, columns["energy"].start
        self._lines: dict[int, Any] = {}
        for k, part in self.parts.items():
            if isinstance(part, GasPart):
                mass = columns["mass"].start + self._columns[k]
                sums = np.array([mass, momentum, energy, columns["entropy"].start])
                self._lines[k] = part.line(self._columns[k], sums)
            else:
                own = [(number, row, X) for number, block, row, X in ends if block == k]
                self._lines[k] = part.line(np.array([momentum, energy]), own)
        self.alone = alone and not self.particles.stores
        self.alone = self.alone and not any(part.part.has_halo for part in self.parts.values())
        self._filled: float | None = None  # when the data were asked for
        self._boxes = {k: Box(line) for k, line in self._lines.items()}
        self._box = Box(self.particles.line())

    def attach_steps(self, memory: tuple[Array, ...], words: Any, burst: Array, rows: Array) -> None:
        """What steps take and fill, before all but `initial`: see fsipetsc.scheme.line_steps.Found.
        """
        self._found = Found(*memory, self._gain, *words, burst, rows, np.zeros(2))
        self._all = Box(Line(tuple(self._boxes.values()), self._box, self._found))

    def _refresh(self, t: float) -> None:
        """Data of the case at time t [s]."""
        if self._filled is None or not self.steady:
            self.particles.refresh(t)
            for part in self.parts.values():
                part.refresh(t)
            self._filled = t

    def _share(self, t: float, y: BlockVector) -> None:
        self._refresh(t)
        line_steps.begin_sums(self._box, y.array, self._gain)
        self.particles.exchange()
        line_steps.end_sums(self._box, self._gain)

    def complete(self, t: float, y: BlockVector) -> None:
        """Let y obey all that holds its particles, in place. Collective."""
        if self.alone:
            self._refresh(t)
            line_steps.run(self._all, COMPLETE, y.array, y.array)
            return
        gain, box = self._gain, self._box
        self._share(t, y)
        if self.particles.stores:
            self._find_stored(y)
        line_steps.settle(box, y.array, gain)
        for gas in self._gases:
            line_parts.follow(self._boxes[gas.part.k], box)
        for gas in self._gases:
            gas.gather.begin()
        for gas in self._gases:
            gas.gather.end()
            line_parts.move(self._boxes[gas.part.k])

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
        for box in self._boxes.values():
            line_parts.rates_of(box, y.array, f, gain)
        line_steps.begin_rates(self._box, f)
        self.particles.exchange()
        line_steps.end_rates(self._box, y.array, f, gain)

    def bounds(self, t: float, y: BlockVector) -> Array:
        """See Scheme.bounds."""
        if self.alone:
            line_steps.run(self._all, LOOK, y.array, y.array)
        else:
            for box in self._boxes.values():
                line_parts.look_at(box, y.array)
        found = np.zeros((len(self.problem.blocks), LOOKED))
        found[:, LEAST_J] = -np.inf
        self._sums = {}
        for k, line in self._lines.items():
            found[k] = line.seen
            names = ("mass",) * isinstance(self.parts[k], GasPart), ("momentum_x", "energy", "entropy")
            self._sums[k] = dict(zip(names[0] + names[1], line.sums.tolist(), strict=False))
        return found

    def steps(self, t: float, dt: float) -> tuple[bool, float, float]:
        """Steps from t [s] as the burst allows, the first of dt [s]: whether all ended well, and the
        time that is reached; or begin and length of a step that is to be made anew.
        """
        self._refresh(t)
        self._found.now[:] = t, dt
        ended_well = line_steps.run(self._all, STEPS, self._found.stage, self._found.k)
        return bool(ended_well), float(self._found.now[0]), float(self._found.now[1])
