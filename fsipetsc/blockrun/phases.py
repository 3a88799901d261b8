"""The phases of a right-hand side on blocks, which read as the method:

    share      members add up what is extensive; the grids of the gas follow the solids
    impose     the unknowns obey the conditions
    rates      volume terms of each block, what passes open faces, forcing; then the constraints
               of the particles

A phase is a list of calls: procedures of parts and of particles (fsipetsc.kernels.procedure), and
exchanges between ranks (fsipetsc.parallel.exchange). C makes all calls of a list.
"""

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from fsipetsc.blockrun.compiled import STAGES, Compiled
from fsipetsc.kernels.calls import Calls
from fsipetsc.parallel.block_layout import BlockVector
from fsipetsc.scheme.timed import OF_STAGES

Array = NDArray[Any]


class Phases(Compiled):
    """The phases as lists of calls of what is compiled. Each list is made once."""

    def __init__(self, *about: Any) -> None:
        super().__init__(*about)
        self._made: dict[Any, Calls] = {}
        self._calls: list[Any] = []  # those of the list in the making

    def do(self, phases: str, y: Array, f: Array | None = None) -> None:
        """Make the calls of phases, whose names have blanks between; f: y if not given."""
        f = y if f is None else f
        key = phases, y.ctypes.data, f.ctypes.data
        if key not in self._made:
            for phase in phases.split():
                self._phase(phase, y, f)
            self._made[key] = self._list()
        self._made[key]()

    def batch(
        self, stages: Sequence[tuple[str, BlockVector, BlockVector]], solution: BlockVector
    ) -> Calls:
        """The calls of one of many steps made together, with its monitor and the plan of the next
        one. stages: name, whose rates it takes, where it goes.
        """
        if "batch" not in self._made:
            y, data = solution.array, [(code.procedures[0], ()) for code in self.data]
            self._call("begin_step")
            for (name, now, to), time in zip(stages, OF_STAGES, strict=True):
                if data and time:
                    self._call(time)
                    self._calls += data
                for phase in ("share", "impose", name):
                    self._phase(phase, now.array, to.array)
            for phase in ("share", "impose", "monitor"):
                self._phase(phase, y, y)
            self._call("note_gained", "end_step")
            self._made["batch"] = self._list()
        return self._made["batch"]

    def _list(self) -> Calls:
        """The calls that were added since the last list."""
        calls, self._calls = self._calls, []
        return Calls(self.calling.library, calls)

    def _phase(self, name: str, y: Array, f: Array) -> None:
        """Add the calls of a phase, one of the methods below, or of a stage."""
        self._y, self._f = y, f
        if name in STAGES:
            self._rates(name)
            self._call(name, of=(f,))
        else:
            getattr(self, f"_{name}")()

    def _share(self) -> None:
        """Members add up what is extensive; grids follow."""
        self._call("weigh")
        self._exchange(self.particles.sums)
        self._call("end_sums")
        self._follow()
        self._each("move")

    def _impose(self) -> None:
        """The unknowns obey the conditions, and grids have their velocities."""
        if self.particles.slips:
            self._each("normals")
            self._exchange(self.particles.areas)
            self._call("end_normals")
        if self.particles.stores:
            self._call("begin_stored")
            self._fill()
            self._each("store")
            self._exchange(self.particles.stored)
            self._call("weigh_heat")
        self._call("impose_conditions")
        if self.particles.slips:  # the conditions have changed velocities
            self._follow()
        self._each("swing")

    def _rates(self, name: str = "rates") -> None:
        """f = dy/dt, or, of a stage, what follows from it. name: "rates", or that of the stage."""
        self._call(f"begin_{name}", "clear_gain")
        if self.particles.slips:
            self._each("turn")
            self._exchange(self.particles.areas)
            self._call("end_turning")
        self._fill()
        self._each("finish")
        self._each("rates")
        self._call("weigh", of=(self._f,))
        self._exchange(self.particles.sums)
        self._call("end_rates")

    def _monitor(self) -> None:
        """Extremes of all ranks, and this rank's shares of integrals."""
        self._call("begin_monitor")
        self._fill()
        self._each("finish")
        self._each("monitor")
        if self.layout.comm.size > 1:
            self._call("reduce")
        self._call("note_extremes")

    def _halos(self) -> None:
        """Fill ghosted arrays whole."""
        self._fill(inside=True)

    def _inside(self) -> None:
        """Fill the owned nodes of those ghosted arrays that have only their halos."""
        for part in self.parts.values():
            if part.part.has_halo and not part.reads_ghosted:
                self._exchange(part.part.inside)

    def _fill(self, inside: bool = False) -> None:
        """Fill halos; the owned nodes of ghosted arrays too where something reads them there."""
        self._exchange(self.layout.halos)
        for part in self.parts.values():
            if part.part.has_halo and (inside or part.reads_ghosted):
                self._exchange(part.part.inside)
        self._each("images")

    def _follow(self) -> None:
        """Tell the grids of gases where their particles are."""
        self._each("follow")
        for gas in self.gases:
            self._exchange(gas.gather)

    def _call(self, *names: str, of: tuple[Array, ...] | None = None) -> None:
        """Call procedures, with y and f if ``of`` is not given."""
        for name in names:
            procedure = self.does[name]
            vectors = (self._y, self._f) if of is None else of
            self._calls.append((procedure, vectors[: len(procedure.vectors)]))

    def _each(self, name: str) -> None:
        """Call the procedure of this name of each part that has it."""
        for procedure in (part.does[name] for part in self.parts.values() if name in part.does):
            self._calls.append((procedure, (self._y, self._f)[: len(procedure.vectors)]))

    def _exchange(self, one: Any) -> None:
        """Exchange with other ranks, if there is something to be exchanged."""
        if not one.empty:
            self._calls.append((one, (self._y,)[: len(one.vectors)]))
