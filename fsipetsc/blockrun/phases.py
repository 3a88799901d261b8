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


class Listed:
    """A list of calls in the making, with the world vectors that each takes: y, and f of rates.

    Its methods are the phases, and what these have in common.
    """

    def __init__(self, of: Compiled) -> None:
        self._of, self._parts, self._particles = of, of.parts.values(), of.particles
        self.calls: list[Any] = []

    def phase(self, name: str, y: Array, f: Array) -> None:
        """Add the calls of a phase, one of the methods below, or of a stage."""
        self._y, self._f = y, f
        if name in STAGES:
            self.rates(name)
            self._call(name, of=(f,))
        else:
            getattr(self, name)()

    def share(self) -> None:
        """Members add up what is extensive; grids follow."""
        self._call("weigh")
        self._exchange(self._particles.sums)
        self._call("end_sums")
        self._follow()
        self._each("move")

    def impose(self) -> None:
        """The unknowns obey the conditions, and grids have their velocities."""
        if self._particles.slips:
            self._each("normals")
            self._exchange(self._particles.areas)
            self._call("end_normals")
        if self._particles.stores:
            self._call("begin_stored")
            self._halos()
            self._each("store")
            self._exchange(self._particles.stored)
            self._call("weigh_heat")
        self._call("impose_conditions")
        if self._particles.slips:  # the conditions have changed velocities
            self._follow()
        self._each("swing")

    def rates(self, name: str = "rates") -> None:
        """f = dy/dt, or, of a stage, what follows from it. name: "rates", or that of the stage."""
        self._call(f"begin_{name}", "clear_gain")
        if self._particles.slips:
            self._each("turn")
            self._exchange(self._particles.areas)
            self._call("end_turning")
        self._halos()
        self._each("finish")
        self._each("rates")
        self._call("weigh", of=(self._f,))
        self._exchange(self._particles.sums)
        self._call("end_rates")

    def monitor(self) -> None:
        """Extremes of all ranks, and this rank's shares of integrals."""
        self._call("begin_monitor")
        self._halos()
        self._each("finish")
        self._each("monitor")
        if self._of.layout.comm.size > 1:
            self._call("reduce")
        self._call("note_extremes")

    def halos(self) -> None:
        """Fill ghosted arrays whole."""
        self._halos(inside=True)

    def inside(self) -> None:
        """Fill the owned nodes of those ghosted arrays that have only their halos."""
        for part in self._parts:
            if part.part.has_halo and not part.reads_ghosted:
                self._exchange(part.part.inside)

    def _halos(self, inside: bool = False) -> None:
        """Fill halos; the owned nodes of ghosted arrays too where something reads them there."""
        self._exchange(self._of.layout.halos)
        for part in self._parts:
            if part.part.has_halo and (inside or part.reads_ghosted):
                self._exchange(part.part.inside)
        self._each("images")

    def _follow(self) -> None:
        """Tell the grids of gases where their particles are."""
        self._each("follow")
        for gas in self._of.gases:
            self._exchange(gas.gather)

    def _call(self, *names: str, of: tuple[Array, ...] | None = None) -> None:
        """Call procedures, with y and f if ``of`` is not given."""
        for name in names:
            procedure = self._of.does[name]
            vectors = (self._y, self._f) if of is None else of
            self.calls.append((procedure, vectors[: len(procedure.vectors)]))

    def _each(self, name: str) -> None:
        """Call the procedure of this name of each part that has it."""
        for procedure in (part.does[name] for part in self._parts if name in part.does):
            self.calls.append((procedure, (self._y, self._f)[: len(procedure.vectors)]))

    def _exchange(self, one: Any) -> None:
        """Exchange with other ranks, if there is something to be exchanged."""
        if not one.empty:
            self.calls.append((one, (self._y,)[: len(one.vectors)]))


class Phases:
    """Makes phases, of what is compiled. Each list of calls is made once."""

    def __init__(self, compiled: Compiled) -> None:
        self._of = compiled
        self._made: dict[Any, Calls] = {}

    def do(self, phases: str, y: Array, f: Array | None = None) -> None:
        """Make the calls of phases, whose names have blanks between; f: y if not given."""
        f = y if f is None else f
        key = phases, y.ctypes.data, f.ctypes.data
        if key not in self._made:
            listed = Listed(self._of)
            for phase in phases.split():
                listed.phase(phase, y, f)
            self._made[key] = Calls(self._of.calling.library, listed.calls)
        self._made[key]()

    def batch(
        self, stages: Sequence[tuple[str, BlockVector, BlockVector]], solution: BlockVector
    ) -> Calls:
        """The calls of one of many steps made together, with its monitor and the plan of the next
        one. stages: name, whose rates it takes, where it goes.
        """
        if "batch" not in self._made:
            listed, does, y = Listed(self._of), self._of.does, solution.array
            data = [(code.procedures[0], ()) for code in self._of.data]
            listed.calls.append((does["begin_step"], ()))
            for (name, now, to), time in zip(stages, OF_STAGES, strict=True):
                if data and time:
                    listed.calls += [(does[time], ()), *data]
                for phase in ("share", "impose", name):
                    listed.phase(phase, now.array, to.array)
            for phase in ("share", "impose", "monitor"):
                listed.phase(phase, y, y)
            listed.calls += [(does["note_gained"], (y,)), (does["end_step"], ())]
            self._made["batch"] = Calls(self._of.calling.library, listed.calls)
        return self._made["batch"]
