"""The state of a run of blocks; what is done in a stage says fsipetsc.stepping.phases."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blocks.block import size_of
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import block_values, checked, names_of
from fsipetsc.errors import InputError
from fsipetsc.kernels.loops import zeros
from fsipetsc.kernels.procedure import Code
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.options import COMMON
from fsipetsc.parallel.block_layout import BlockLayout
from fsipetsc.parallel.exchange import EXCHANGES, Reduction
from fsipetsc.particles.members import particles_of
from fsipetsc.particles.system import ParticleSystem
from fsipetsc.process.together import libraries, together
from fsipetsc.scheme.monitor import MONITORED
from fsipetsc.scheme.observables import PLACES, VELOCITIES
from fsipetsc.scheme.plan import RATE, SOLUTION, STAGES
from fsipetsc.state import State
from fsipetsc.stepping import saved
from fsipetsc.stepping.parts import GasPart, SolidPart
from fsipetsc.stepping.phases import phases, procedures_of_steps

#: by order: how much shorter steps are with dissipation of strength 1 at shocks. That alone is a
#: number of -1.6 at Courant number 0.8, of 2.785 that the classical method bears; next to the ends
#: of 8/4 more
PACE_AT_SHOCKS = {2: 1.0, 4: 1.0, 6: 1.0, 8: 4.0 / 3.0}
#: options that choose between methods -> what a state on blocks takes
HAS = {"fsi_coupling": "conservative", "fsi_mapping": "auto stretched", "fsi_viscous": "wide"}


class BlockState(State):
    """A run's solution on blocks. Making one is collective on ``comm``. InputError where blocks,
    options and ranks do not fit.

    opt: options, which else have their defaults. announce: told, on rank 0, of what is compiled.

    y: this rank's part of the solution. recorded: nodes that are recorded at each step. bounds:
    (blocks, 2), largest rates of convection and diffusion [1/s]; h: mean size of the cells of the
    finest block [m].
    """

    MOST_PARTS = 16
    _filled: tuple[float, float] | None = None  # the instant that Python's data are of

    def __init__(
        self,
        comm: MPI.Comm,
        problem: BlockProblem,
        opt: Mapping[str, Any],
        announce: Callable[[str], None] = lambda text: None,
    ) -> None:
        opt = {option.name: option.default for option in COMMON} | {**opt}
        for name, values in HAS.items():
            if opt[name] not in values.split():
                blocks = "this case is made of blocks, as is any with -fsi_coupling conservative"
                expected = f"expected {' or '.join(values.split())}"
                raise InputError(f"-{name} {opt[name]}: {blocks}: {expected}")
        order, shock = opt["fsi_order"], opt["fsi_shock"]
        self.comm, self.problem, self.op = comm, problem, OPERATORS[order]
        sizes = (size_of(block) / float(np.prod(block.cells)) for block in problem.blocks)
        self.h = min(sizes) ** (1.0 / problem.dimension)
        self.recorded = saved.chosen(problem, opt["fsi_probes"])
        gain, particles = saved.gain_of(problem), particles_of(problem)
        of_layout = order, shock > 0.0, opt["fsi_partition"], gain.numbers.size
        self.layout = layout = BlockLayout(comm, problem, *of_layout)
        self.shapes, size = layout.shapes, layout.local_size
        self._now = [zeros(size) for _ in range(STAGES)]  # the solution, and stages
        self.y = self._shown = self._now[0]
        self.solution = PETSc.Vec().createWithArray(self.y, size=(size, None), comm=comm)
        self._lay_journal(saved.step_record(problem, len(self.recorded)))
        self.changing = self.y, self.results, self.batch
        self.bounds = np.zeros((len(problem.blocks), 2))
        self.system = ParticleSystem(layout, particles, self._instant, gain)
        at = saved.slices(self.latest.dtype)
        found = SimpleNamespace(y=self.y, stages=tuple(self._now[1:]), total=zeros(size), gain=gain)
        found.plan, found.results, found.latest = self.plan, self.results, self.latest_numbers
        found.rates, found.extremes = self.bounds, np.zeros(1 + MONITORED * len(problem.blocks))
        found.time, found.stage = np.zeros(1), np.zeros(2)
        found.pace = max(1.0, shock * PACE_AT_SHOCKS[order])
        ends = (at.get(f"{name}_interface", slice(0)) for name in ("x", "u", "sigma", "T"))
        found.at_ends = tuple(self.latest_numbers[end] for end in ends)
        about = SimpleNamespace(layout=layout, opt=opt, particles=particles, system=self.system)
        about.found, about.columns = found, {name: where.start for name, where in at.items()}
        about.recorded = self.recorded
        kinds: dict[str, Any] = {"fluid": GasPart, "solid": SolidPart}
        every = [(k, kinds[problem.blocks[k].kind], part) for k, part in layout.parts.items()]
        # a grid or a prestress may be wrong on some ranks
        self.parts = together(comm, lambda: {k: of_kind(part, about) for k, of_kind, part in every})
        self._gases = [part for part in self.parts.values() if part.block.kind == "fluid"]
        found.left = self._left()
        self._compile(found, announce)

    def _compile(self, found: Any, announce: Callable[[str], None]) -> None:
        """Record what is not of parts, load all, and list what a step calls. InputError."""
        comm, layout, parts = self.comm, self.layout, self.parts.values()
        calling = Code(EXCHANGES)
        does: dict[str, Any] = procedures_of_steps(calling, found)
        having = () if self.problem.steady_data else (*parts, self.system.prescribed)
        data = self._record_data([part.sources for part in having], found.time)
        codes = [*(part.code for part in parts), *data, self.system.code, calling]
        loaded = libraries(comm, [code.text for code in codes], announce)
        for code, library in zip(codes, loaded, strict=True):
            code.load(library)
        does["reduce"] = Reduction(comm, found.extremes)
        members = self.system.sums, self.system.areas, self.system.stored
        exchanges = [layout.halos, *members, *(part.inside for part in parts), does["reduce"]]
        exchanges += [gas.gather for gas in self._gases]
        self.phases = phases(layout, [*parts], self.system, does, self._data)
        self._take_calls(calling.library, does["plan_next"], exchanges)
        if not self.asked:  # as data of a wall that begins with an infinite acceleration
            self._fill(0.0)
            bad = [about for about, of in self._targets if not np.isfinite(of).all()]
            self._ask([f"{what}: it is not finite at t = 0" for what in bad])
        self.system.begin()
        for gas in self._gases:  # the metrics where nothing has moved
            for name in ("edge", "move", "find_volumes"):
                gas.does[name]()
            gas.reference[:] = gas.J

    def _left(self) -> np.ndarray:
        """(runs, 2), begin and end of numbers to whose rates something is added after sweeps."""
        left = np.ones(self.layout.local_size, bool)
        for k, part in self.parts.items():
            patch = part.patch
            free = (slice(a - n, b - n) for (a, b), n in zip(part.inner, patch.first, strict=True))
            planes = self.layout.owned(k, left).T.reshape(-1, *patch.own[::-1])
            planes[(..., *[*free][::-1])] = False
        ends = np.flatnonzero(np.diff(left, prepend=False, append=False))
        return ends.reshape(-1, 2).astype(np.int64)

    def _instant(self) -> float:
        """A short time [s], for differences in time; a power of two, so that it hardly changes."""
        rate = float(self.results[RATE])
        _, power = math.frexp(0.25 / rate if 0.0 < rate < np.inf else 1e-3 * self.h)
        return math.ldexp(0.25, power)

    def set_initial(self, t_end: float | None = None) -> None:
        """Initial data. Grids of gases follow the solids, at the same density, velocity and
        temperature; what walls and clamps hold gets their velocity. All functions of the case are
        asked at t = 0. InputError for what they return, and where walls do not move with their
        velocity until t_end [s].
        """

        def fill() -> None:
            for k, part in self.parts.items():
                part.initial(self.owned(k))
                if part.block.exact is not None:
                    block_values(part.block, "exact", part.X[:, part.owned], 0.0)
            self.refresh(0.0)  # says what is wrong, also with those that C fills next
            self.set_data(0.0)
            if t_end is not None:
                self.system.prescribed.check_motion(t_end)

        together(self.comm, fill)
        self._auxiliary[:] = 0.0
        self._do("share", SOLUTION)
        self._do("grid", SOLUTION)
        for gas in self._gases:
            gas.does["find_volumes"]()
            q = self.owned(gas.k)
            q *= (gas.J / q[:, 0])[:, None]
        first = self.y.copy()
        self._do("fulfil", SOLUTION)
        obeying, self.y[:] = self.y.copy(), first
        for k, part in self.parts.items():
            part.begin_as_held(self.owned(k), self.layout.owned(k, obeying))

    def refresh(self, t: float) -> None:
        if self._filled != (instant := (t, self._instant())):
            self._filled = instant
            for one in (self.system.prescribed, *self.parts.values()):
                one.refresh(t)

    def load(self, n: int, y: np.ndarray) -> None:
        if n < STAGES:
            self._now[n][:] = y

    def unload(self, n: int, y: np.ndarray) -> None:
        y[:] = self._now[n]

    def right_hand_side(self, y: np.ndarray, f: np.ndarray) -> None:
        super().right_hand_side(y, f)
        f[:] = self.vectors(1)[1]

    def vectors(self, n: int) -> tuple[np.ndarray, np.ndarray]:
        return self._now[n % STAGES], self._now[(n + 1) % STAGES]

    def show(self, n: int) -> None:
        self._shown = self._now[n % STAGES]
        self._do("halos", n)

    def completed(self) -> None:
        super().completed()
        self._do("inside", SOLUTION)
        self._shown = self.y

    def begin(self) -> None:
        for gas in self._gases:
            for rows in vars(gas.volume.tile).values():
                rows[:] = 0.0  # no NaN may stay there for another step
        self._do("begin", 0)
        self.show(0)

    def repeat(self, look: Callable[[], Any]) -> Any:
        self._filled = None  # Python is asked anew
        return super().repeat(look)

    @property
    def _auxiliary(self) -> np.ndarray:
        return self.y[self.y.size - self.layout.auxiliary :]

    def more(self) -> Mapping[str, np.ndarray]:
        """The auxiliary unknowns of all ranks, added up, by the name that files have."""
        every = self.comm.gather(self._auxiliary) or []
        return {"behind": sum(every, np.zeros(self.layout.auxiliary))}

    def take(self, arrays: Mapping[str, np.ndarray]) -> None:
        behind = arrays["behind"]  # asked for on all ranks, so that all fail alike
        self._auxiliary[:] = behind if self.comm.rank == 0 else 0.0

    def header(self) -> dict[str, Any]:
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

    def seen(self) -> Iterator[Any]:
        problem, d = self.problem, self.problem.dimension
        for k, part in self.parts.items():
            columns = dict(zip(part.names, self.saved(k).T, strict=True))
            names = "J", "rho", *VELOCITIES[:d], "T"
            if part.block.kind == "solid":  # T of a law of J < 0 is no number: J says more
                columns["J"] = part.laws.volume(tuple(part.F))
                names = "J", *PLACES[:d], *VELOCITIES[:d], "T"
            values, numbers = {name: columns[name] for name in names}, part.numbers
            x = np.stack([columns[name] for name in PLACES[:d]], axis=1)
            yield k, numbers, values, x, problem.places(k, numbers)

    def compared(self, kind: str) -> tuple[str, ...]:
        """What is compared of a kind of block: stresses where all solids have an exact_stress."""
        blocks, d = self.problem.blocks, self.problem.dimension
        unknowns = names_of(kind, "exact", d)
        if kind == "fluid" or any(b.exact_stress is None for b in blocks if b.kind == kind):
            return unknowns
        return (*unknowns, *(n for n in saved.fields_of(kind, d) if n.startswith(("s_", "sigma"))))

    def powers(self, k: int, names: Sequence[str], t: float, power: int) -> np.ndarray:
        """As of any state; the weight of a node is H times J of the reference map. InputError."""
        part = self.parts[k]
        block, X = part.block, part.X[:, part.owned]
        exact = block_values(block, "exact", X, t)
        if len(names) > len(exact):
            where = f"exact of block '{block.name}' at t = {t:.6g}"
            exact += checked(block.exact_stress, (*X, t), X, names[len(exact) :], where)
        known = dict(zip(part.names, self.saved(k).T, strict=True))
        w = part.H * part.reference / (X[-1] ** self.problem.symmetry)
        pairs = zip(names, exact, strict=True)
        return np.array([np.sum(w * np.abs(known[name] - value) ** power) for name, value in pairs])

    def owned(self, k: int) -> np.ndarray:
        return self.layout.owned(k, self.y)

    def ghosted(self, k: int) -> np.ndarray:
        """(N, unknowns) of block k that is shown, with halos, if there are any, as filled last."""
        part = self.layout.parts[k]
        return part.halo.T if part.halo.size else self.layout.owned(k, self._shown)

    def numbers(self, k: int) -> np.ndarray:
        return self.parts[k].numbers if k in self.parts else np.empty(0, np.int64)

    def fields(self, k: int) -> Sequence[str]:
        block = self.problem.blocks[k]
        return saved.fields_of(block.kind, block.dimension, self.problem.symmetry)

    @property
    def points(self) -> int:
        return sum(map(math.prod, self.shapes))

    def saved(self, k: int) -> np.ndarray:
        """(M, columns) of ``fields``: what is saved of this rank's nodes of block k."""
        return self.parts[k].fields(self.ghosted(k))

    def save(self) -> list[np.ndarray]:
        """What is saved of this rank's nodes of each block, to be copied before the next call."""
        none = [np.empty((0, len(self.fields(k)))) for k in range(len(self.shapes))]
        here = [self.saved(k) if k in self.parts else array for k, array in enumerate(none)]
        return [self.layout.in_order(k, array) for k, array in enumerate(here)]
