"""The phases of a right-hand side on blocks, which read as the method:

    share      members add up what is extensive; faces of the gas's grids follow the solids
    fulfil     share, and then the unknowns obey the conditions
    grid       the grids of the gas follow their faces: just before rates, so that no rank waits
    rates      volume terms of each block, what passes open faces, forcing; then the constraints
               of the particles

A phase is a list of calls, which C makes: procedures of parts and of particles
(fsipetsc.kernels.procedure), and exchanges between ranks (fsipetsc.parallel.exchange).
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.blockrun.gas_part import GasPart
from fsipetsc.blockrun.saved import slices
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.kernels.procedure import Code
from fsipetsc.parallel.block_layout import BlockLayout
from fsipetsc.parallel.exchange import Reduction, exchange_text
from fsipetsc.particles.members import particles_of
from fsipetsc.particles.system import ParticleSystem
from fsipetsc.process.libraries import libraries
from fsipetsc.process.together import together
from fsipetsc.scheme import runge_kutta as stages
from fsipetsc.scheme.part import clear
from fsipetsc.scheme.plan import RATE, plan_next
from fsipetsc.scheme.recorded_data import Recorder, set_time

Array = NDArray[Any]


class Phases:
    """This rank's parts of blocks, the particles they meet in, all procedures of both, and the
    phases as lists of their calls. Making one is collective. InputError.

    form: fsipetsc.blockrun.block_state.BlockForm. found: what steps take and fill; its left is
    found here. columns: of the record of a step. asks: some data depend on time, and not all of
    these are recorded: Python is asked for them. not_recorded: why, on this rank.
    """

    def __init__(
        self,
        layout: BlockLayout,
        order: int,
        form: Any,
        found: Any,
        columns: np.dtype,
        announce: Callable[[str], None],
    ) -> None:
        problem, kinds = layout.problem, {"fluid": GasPart, "solid": SolidPart}
        self.layout, self.problem, self.found = layout, problem, found
        self.steady, particles = problem.steady_data, particles_of(problem)

        def make() -> dict[int, Any]:
            of = layout.parts.items()
            return {k: kinds[problem.blocks[k].kind](layout, part, order, form) for k, part in of}

        self.parts = together(layout.comm, make)  # a grid or a prestress may be wrong on some ranks
        self.gases = [part for part in self.parts.values() if part.block.kind == "fluid"]
        solids = {k: part for k, part in self.parts.items() if part.block.kind == "solid"}
        inertia = {k: part.inertia for k, part in solids.items()}
        self.particles = ParticleSystem(layout, particles, inertia, self.instant)
        for k, part in self.parts.items():
            part.at_particles = self.particles.faces_at(k)
        for gas in self.gases:
            gas.follow(particles, self.particles)
        found.left = self._left()
        self._compile(columns, announce)
        self._lists = self._listed()

    def instant(self) -> float:
        """A time [s] in which little happens, for differences in time: a power of two, so that it
        is the same in most steps, and data need not be asked for again where the next step begins.
        """
        rate, h = float(self.found.results[RATE]), self.problem.spacing
        _, power = math.frexp(0.25 / rate if 0.0 < rate < np.inf else 1e-3 * h)
        return math.ldexp(0.25, power)

    def _left(self) -> Array:
        """(runs, 2) of the numbers of this rank's part of a world vector with rates that something
        adds to after a sweep.
        """
        left = np.ones(self.layout.local_size, bool)
        for part in self.parts.values():
            left[part.part.begin : part.part.end].reshape(part.part.dof, -1)[:, part.free_nodes] = 0
        ends = np.flatnonzero(np.diff(left, prepend=False, append=False))
        return ends.reshape(-1, 2).astype(np.int64)

    def _compile(self, columns: np.dtype, announce: Callable[[str], None]) -> None:
        """Record all procedures, and load them. Collective. InputError."""
        comm, found, parts = self.layout.comm, self.found, self.parts.values()
        begins = {name: at.start for name, at in slices(columns).items()}
        about = self.particles, found, begins
        codes = together(comm, lambda: [part.record(*about) for part in parts])
        self.calling = Code(exchange_text())
        of_step = stages.begin_monitor, stages.note_extremes, stages.note_gained
        wanted: dict[str, Any] = {f.__name__: (f, found) for f in of_step}
        wanted["clear_gain"] = clear, found.gain.numbers
        wanted["plan_next"] = plan_next, found.plan
        wanted["begin_rates"] = stages.begin_stage(None), found
        for n in range(stages.STAGES):
            wanted[f"begin_{n}"] = stages.begin_stage(n), found
            wanted[f"stage_{n}"] = stages.advance(n), found
            wanted[f"time_{n}"] = set_time(stages.FRACTIONS[n]), found
        self.does = {name: self.calling.procedure(name, *one) for name, one in wanted.items()}
        self._record_data(comm)
        codes += [*self._data, self.particles.procedures(found.gain), self.calling]
        made = libraries(comm, [code.text for code in codes], announce)
        for code, library in zip(codes, made, strict=True):
            code.load(library)
        self.does |= self.particles.does
        self.does["reduce"] = Reduction(comm, found.extremes)
        halos = self.layout.halos, *(part.inside for part in self.layout.parts.values())
        particles = self.particles.sums, self.particles.areas, self.particles.stored
        gathers = (gas.gather for gas in self.gases)
        for exchange in (*halos, *particles, *gathers, self.does["reduce"]):
            exchange.load(self.calling.library)
        self._check_recorded(comm)
        self.particles.begin()
        for gas in self.gases:
            gas.begin()

    def _record_data(self, comm: Any) -> None:
        """Record data that depend on time, if all can be. Collective."""
        having = () if self.steady else (*self.parts.values(), self.particles.prescribed)
        self._recorders = [Recorder(part.sources) for part in having]
        self._ask(comm, [why for recorder in self._recorders for why in recorder.refused])
        codes = [recorder.code(self.found.time) for recorder in self._recorders if not self.asks]
        self._data = [code for code in codes if code is not None]

    def _check_recorded(self, comm: Any) -> None:
        """Let Python be asked if recorded data are not finite at t = 0, as those of a wall that
        begins with an infinite acceleration. So it is after a restart, too. Collective.
        """
        if not self.asks:
            self.fill(0.0)
            bad = [what for recorder in self._recorders for what in recorder.faulty()]
            self._ask(comm, [f"{what}: it is not finite at t = 0" for what in bad])

    def _ask(self, comm: Any, why: list[str]) -> None:
        """Let Python be asked for data if a rank has a reason. Collective."""
        self.not_recorded, self.asks = why, comm.allreduce(bool(why), MPI.LOR)

    def fill(self, t: float) -> None:
        """Let C fill the recorded data at time t [s]."""
        self.found.time[0] = t
        for code in self._data:
            code.procedures[0]()

    def refresh(self, t: float) -> None:
        """Let Python fill all data at time t [s]. InputError."""
        for one in (self.particles.prescribed, *self.parts.values()):
            one.refresh(t)

    def destroy(self) -> None:
        self.particles.destroy()
        for gas in self.gases:
            gas.gather.destroy()

    def calls(self, phase: str, y: Array, f: Array) -> list[tuple[Any, Any]]:
        """Calls of a phase: procedure, vectors."""
        found = []
        for one in self._lists[phase]:
            procedure, vectors = (one[0], (f,)) if isinstance(one, tuple) else (one, (y, f))
            if not getattr(procedure, "empty", False):
                found.append((procedure, vectors[: len(procedure.vectors)]))
        return found

    def _listed(self) -> dict[str, list[Any]]:
        """Phase -> procedures and exchanges, in their order; (procedure,) is of f, not of y."""
        does, of_particles, parts = self.does, self.particles, self.parts.values()

        def each(name: str) -> list[Any]:
            return [part.does[name] for part in parts if name in part.does]

        sums, areas, slips = of_particles.sums, of_particles.areas, of_particles.record.slips
        with_halo = [part for part in parts if part.part.has_halo]
        inside = [part.part.inside for part in with_halo]
        read = [part.part.inside for part in with_halo if part.reads_ghosted]
        halos, images = self.layout.halos, each("images")
        fill = [halos, *read, *images]  # owned nodes of ghosted arrays too where they are read
        follow = [*each("follow"), *(gas.gather for gas in self.gases)]
        reduce = [does["reduce"]] * (self.layout.comm.size > 1)
        normals = [*each("normals"), areas, does["end_normals"]] if slips else []
        turned = [*each("turn"), areas, does["end_turning"]] if slips else []
        stored: list[Any] = []
        if of_particles.record.stores:
            stored = [*each("move"), does["begin_stored"], *fill, *each("store")]
            stored += [of_particles.stored, does["weigh_heat"]]
        # where walls slip, conditions change velocities, which grids follow
        imposed = [does["impose_conditions"], *(follow if slips else [])]
        share = [does["weigh"], sums, does["end_sums"], *follow, *each("edge")]
        move, swing = each("move"), each("swing")
        # what takes long is done just before the rates: ranks need not wait for it
        grid = swing if stored else [*move, *swing]
        found = {
            "share": share,
            "fulfil": [*share, *normals, *stored, *imposed],
            "grid": [*move, *swing],
            "complete": [does["begin_monitor"], *fill, *grid, *each("monitor"), *reduce,
                does["note_extremes"], does["note_gained"]],
            "halos": [halos, *inside, *images],
            "inside": [one for one in inside if one not in read],
        }  # fmt: skip
        rates = [does["clear_gain"], *fill, *grid, *turned, *each("rates")]
        rates += [(does["weigh"],), sums, does["end_rates"]]
        found["rates"] = [does["begin_rates"], *rates]
        data = [code.procedures[0] for code in self._data]
        for n in range(stages.STAGES):
            found[f"advance_{n}"] = [does[f"begin_{n}"], *rates, (does[f"stage_{n}"],)]
            # a stage at the time of that before has its data
            new = data and stages.FRACTIONS[n] != stages.FRACTIONS[n - 1]
            found[f"data_{n}"] = [does[f"time_{n}"], *data] if new else []
        return found
