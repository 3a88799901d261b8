"""The state of a run of blocks; what is done in a stage says fsipetsc.blockrun.phases."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blockrun import saved
from fsipetsc.blockrun.gas_part import loose_gases
from fsipetsc.blockrun.phases import Phases
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import block_values, checked, names_of
from fsipetsc.errors import InputError
from fsipetsc.kernels.arrays import zeros
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.block_layout import BlockLayout, BlockVector
from fsipetsc.process.together import agree, together
from fsipetsc.scheme.monitor import MONITORED
from fsipetsc.scheme.observables import PLACES, VELOCITIES
from fsipetsc.scheme.plan import SAID_STOP
from fsipetsc.scheme.runge_kutta import STAGES
from fsipetsc.state import FAULT, Seen, State

#: by order: how much shorter steps are with dissipation of strength 1 at shocks. That alone is a
#: number of -1.6 at Courant number 0.8, of 2.785 that the classical method bears; next to the ends
#: of 8/4 more
PACE_AT_SHOCKS = {2: 1.0, 4: 1.0, 6: 1.0, 8: 4.0 / 3.0}


class BlockForm(NamedTuple):
    """convection: "auto", "entropy" or "divergence"; dissipation, shock: times the usual size."""

    convection: str = "auto"
    dissipation: float = 0.0
    shock: float = 0.0


class BlockState(State):
    """A run's solution on blocks. Making one is collective on ``comm``. InputError where blocks,
    order and ranks do not fit.

    recorded: nodes to be recorded at each step, which have a name and X. announce: called on rank
    0, with a message, before and after kernels are compiled.

    y: this rank's part of the solution. bounds: (blocks, 2), largest rates of convection and
    diffusion [1/s]; h: size of the smallest cells [m]. loose: gases on which a constant force acts
    node by node.
    """

    MOST_PARTS = 16
    _filled: tuple[float, float] | None = None  # the instant that the data are of

    def __init__(
        self,
        comm: MPI.Comm,
        problem: BlockProblem,
        order: int,
        form: BlockForm = BlockForm(),  # noqa: B008
        partition: str = "auto",
        recorded: Sequence[saved.Probe] = (),
        announce: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.comm, self.problem, self.op = comm, problem, OPERATORS[order]
        self.h = problem.spacing
        self.loose = loose_gases(problem, form.convection)
        shocks, auxiliary = form.shock > 0.0, saved.gained(problem).itemsize // 8
        self.layout = BlockLayout(comm, problem, order, shocks, partition, auxiliary)
        self._now = [BlockVector(self.layout) for _ in range(STAGES)]  # the solution, and stages
        self.y = self._now[0]
        size = (self.layout.local_size, None)
        self.solution = PETSc.Vec().createWithArray(self.y.array, size=size, comm=comm)
        self.recorded = recorded
        self._lay_journal(saved.step_record(problem, len(recorded)))
        self.changing = self.y.array, self.results, self.batch
        self.bounds = np.zeros((len(problem.blocks), 2))
        at = saved.slices(self.latest.dtype)
        first, last = (at.get(saved.OF_INTERFACES[k], slice(0, 0)) for k in (0, -1))
        ends = self.latest_numbers[first.start : last.stop]
        found = SimpleNamespace(
            y=self.y.array,
            stages=tuple(stage.array for stage in self._now[1:]),
            total=zeros(self.layout.local_size),
            gain=saved.gain_of(problem),
            extremes=np.zeros(1 + MONITORED * len(problem.blocks)),
            rates=self.bounds,
            results=self.results,
            latest=self.latest_numbers,
            at_ends=ends.reshape(len(saved.OF_INTERFACES), -1),
            pace=max(1.0, form.shock * PACE_AT_SHOCKS[order]),
            plan=self.plan,
            time=np.zeros(1),
            stage=np.zeros(2),
            left=np.empty((0, 2), np.int64),  # known once there are parts
        )
        self.phases = Phases(self.layout, order, form, found, self.latest.dtype, announce)
        self._take_calls(self.phases.calling.library, self.phases.does["plan_next"])
        self.shapes, self.parts = self.layout.shapes, self.phases.parts
        self._noted = [
            (number, node, row)
            for number, node in enumerate(recorded)
            if node.block in self.parts
            for row in self.parts[node.block].part.rows_among(np.array([node.node])).tolist()
        ]
        self._shown = self.y

    def check_data(self, t_end: float | None = None) -> None:
        """Fill the solution with the data of the case at t = 0. InputError for what its functions
        return, those of exact solutions, conditions and forcing as well, and where walls do not
        have the velocity with which they move until t_end [s].
        """

        def fill() -> None:
            for k, part in self.parts.items():
                part.initial(0.0, self.y.owned(k))
                if part.block.exact is not None:
                    block_values(part.block, "exact", part.X[:, part.owned], 0.0)
            self.set_data(0.0)
            if t_end is not None:
                self.phases.particles.prescribed.check_motion(t_end)

        together(self.comm, fill)

    def set_initial(self) -> None:
        """Initial data of all blocks. Grids of gases follow the solids, and J is that of the grid,
        at the same density, velocity and temperature; gas at walls gets their velocity. InputError.
        """
        self.check_data()
        self.y.auxiliary[:] = 0.0
        self.set_data(0.0)
        self._do("share", STAGES)
        self._do("grid", STAGES)
        for gas in self.phases.gases:
            k = gas.part.k
            gas.stretch(self.y.owned(k))
            gas.impose_velocities(self.y.owned(k), *self.phases.particles.at_walls(k))
        agree(self.comm, self.fault)

    def set_data(self, t: float) -> None:
        """Let data be those at time t [s]. InputError the first time; later ones are the fault:
        the rank goes on with the data before, so that others do not wait for its messages.
        """
        phases, first = self.phases, self._filled is None
        instant = t, phases.instant()
        if first or (phases.asks and not phases.steady and instant != self._filled):
            self._filled = instant
            try:
                phases.refresh(t)
            except InputError as error:
                if first:
                    raise
                self.fault = self.fault or error
                self.results[SAID_STOP] = FAULT
        if not phases.asks:
            phases.fill(t)

    @property
    def asks(self) -> bool:
        """Python is asked for data at each stage, or for what is recorded of nodes."""
        return self.phases.asks or bool(self.recorded)

    def load(self, n: int, y: np.ndarray) -> None:
        if n < STAGES:
            self._now[n].array[:] = y

    def unload(self, n: int, y: np.ndarray) -> None:
        y[:] = self._now[n].array

    def phase(self, name: str, n: int, f: np.ndarray | None = None) -> list[Any]:
        now, after = (self._now[k % STAGES].array for k in (n, n + 1))
        numbered = f"{name}_{n}" if name in ("advance", "data") else name
        return self.phases.calls(numbered, now, after if f is None else f)

    def show(self, n: int) -> None:
        self._shown = self._now[n % STAGES]
        self._do("halos", n)

    def complete(self) -> None:
        super().complete()
        self._do("inside", STAGES)
        saved.note_nodes(self, self._noted)

    def begin(self) -> None:
        for gas in self.phases.gases:
            gas.volume.rows[:] = 0.0  # no NaN may stay there for another step
        self.load(1, self.y.array)
        self._do("fulfil", 1)
        self.show(0)

    def repeat(self, look: Callable[[], Any]) -> Any:
        """As of any state; Python is asked for recorded data, as it says what is wrong."""
        self.phases.asks, self._filled = not self.phases.steady, (np.inf, 0.0)
        return super().repeat(look)

    def more(self) -> Mapping[str, np.ndarray]:
        """The auxiliary unknowns of all ranks, added up, by the name that files have."""
        every = self.comm.gather(self.y.auxiliary) or []
        return {"behind": sum(every, np.zeros(self.layout.auxiliary))}

    def take(self, arrays: Mapping[str, np.ndarray]) -> None:
        behind = arrays["behind"]  # asked for on all ranks, so that all fail alike
        self.y.auxiliary[:] = behind if self.comm.rank == 0 else 0.0

    def header(self) -> dict[str, Any]:
        """What a result file says of blocks, interfaces, and nodes recorded at each step."""
        found, problem = super().header(), self.problem
        interfaces = range(len(problem.interfaces))
        for layer, block in zip(found["layers"], problem.blocks, strict=True):
            layer["periodic"] = list(block.periodic)[::-1]
        return {
            **found,
            "interface_faces": [problem.interface_faces(n)[0] for n in interfaces],
            "faces": problem.face_names,
            "symmetry": problem.symmetry,
            "points": [[problem.blocks[one.block].name, list(one.X)] for one in self.recorded],
        }

    def grids(self) -> list[np.ndarray]:
        places, natural = self.problem.places, self.layout.natural
        return [places(k, natural(k)) for k in range(len(self.shapes))]

    def seen(self) -> Iterator[Seen]:
        """Values at this rank's nodes, block by block."""
        problem, d = self.problem, self.problem.dimension
        for k, part in self.parts.items():
            columns = dict(zip(part.names, self.saved(k).T, strict=True))
            names = "J", "rho", *VELOCITIES[:d], "T"
            if part.block.kind == "solid":  # T of a law of J < 0 is no number: J says more
                columns["J"] = part.volume_ratio
                names = "J", *PLACES[:d], *VELOCITIES[:d], "T"
            values, numbers = {name: columns[name] for name in names}, part.part.numbers
            x = np.stack([columns[name] for name in PLACES[:d]], axis=1)
            yield Seen(k, numbers, values, x, problem.places(k, numbers))

    def compared(self, kind: str) -> tuple[str, ...]:
        """What is compared of a kind of block: stresses where all solids have an exact_stress."""
        blocks, d = self.problem.blocks, self.problem.dimension
        unknowns = names_of(kind, "exact", d)
        if kind == "fluid" or any(b.exact_stress is None for b in blocks if b.kind == kind):
            return unknowns
        return (*unknowns, *(n for n in saved.fields_of(kind, d) if n.startswith(("s_", "sigma"))))

    def powers(self, k: int, names: Sequence[str], t: float, power: int) -> np.ndarray:
        """Of this rank's nodes of block k sum w |difference|^power at time t [s], with w = H times
        J of the reference map. InputError.
        """
        part = self.parts[k]
        block, X = part.block, part.X[:, part.owned]
        exact = block_values(block, "exact", X, t)
        if len(names) > len(exact):
            where = f"exact of block '{block.name}' at t = {t:.6g}"
            exact += checked(block.exact_stress, (*X, t), X, names[len(exact) :], where)
        known = dict(zip(part.names, self.saved(k).T, strict=True))
        w = part.weights * part.reference / (X[-1] ** self.problem.symmetry)
        pairs = zip(names, exact, strict=True)
        return np.array([np.sum(w * np.abs(known[name] - value) ** power) for name, value in pairs])

    def owned(self, k: int) -> np.ndarray:
        return self.y.owned(k)

    def numbers(self, k: int) -> np.ndarray:
        return self.parts[k].part.numbers if k in self.parts else np.empty(0, np.int64)

    def fields(self, k: int) -> Sequence[str]:
        block = self.problem.blocks[k]
        return saved.fields_of(block.kind, block.dimension, self.problem.symmetry)

    @property
    def invariants(self) -> dict[str, Any]:
        """Those of the problem that hold in this form (fsipetsc.scheme.gas_force)."""
        found = self.problem.invariants
        return {**found, "potential": found["potential"] and not self.loose}

    @property
    def points(self) -> int:
        return sum(map(math.prod, self.shapes))

    def saved(self, k: int) -> np.ndarray:
        """(M, columns) of ``fields``: what is saved of this rank's nodes of block k."""
        return self.parts[k].fields(self._shown.ghosted(k))

    def save(self) -> dict[int, np.ndarray]:
        """What is saved of this rank's nodes: number of a block -> (local, columns), to be copied
        before the next call (RunWriter.write_frame). Collective."""
        none = [np.empty((0, len(self.fields(k)))) for k in range(len(self.shapes))]
        here = [self.saved(k) if k in self.parts else array for k, array in enumerate(none)]
        return {k: self.layout.in_order(k, array) for k, array in enumerate(here)}

    def destroy(self) -> None:
        self.phases.destroy()
        self.solution.destroy()
        self.layout.destroy()
