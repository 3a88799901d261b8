"""The state in two dimensions: what the run and TS are given where fsipetsc.stepping.state.State is that of one dimension.

The same names for the same things: ``solution``, ``results``, ``journal``, ``right_hand_side``, ``finish`` … The
right-hand side is fsipetsc.stepping.plane.path; a fused step is one of fsipetsc.stepping.plane.fused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numba
import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc import given
from fsipetsc.errors import FsiError, InputError
from fsipetsc.operators.cache import compiling, garbage_waiting
from fsipetsc.operators.prepared import Prepared
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.plane.grids import make_grids
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.plane.layer import DOF
from fsipetsc.plane import PlaneProblem
from fsipetsc.process.together import agree, together, wait_asleep
from fsipetsc.scheme.burst import DT, Notes
from fsipetsc.scheme.plan import BURST, CAPACITY, FLAGS, LIMITS, RATE, SAID_STOP, STAGES
from fsipetsc.scheme.plane import entries
from fsipetsc.scheme.plane.account import OF_ALL
from fsipetsc.scheme.plane.equations import USUAL, PlaneForm
from fsipetsc.stepping.diagnosis import Failure
from fsipetsc.stepping.plane import snapshot
from fsipetsc.stepping.plane.diagnosis import describe_failure
from fsipetsc.stepping.plane.edge_data import EdgeData
from fsipetsc.stepping.plane.path import PlanePath
from fsipetsc.stepping.plane.watched import NAMES, Watched, chosen
from fsipetsc.stepping.snapshot import as_numbers, kept, put_back, rates_of
from fsipetsc.stepping.start import Start
from fsipetsc.stepping.state import FAULT

#: records of steps that are kept before they are written
KEPT = min(CAPACITY, 4096)


def step_record(layers: int, fluids: int, points: int = 0) -> np.dtype:
    """What is noted of a step: as fsipetsc.scheme.plan.step_record. least_J: of each layer; then come shares of the ranks:
    integrals, and what is known of the points that are watched.

    mass_in, of each gas, impulse_x, impulse_y, energy_in: what came in during the step through the edges, and by body forces.
    """
    masses = [(name, "f8", (fluids,)) for name in ("mass", "mass_in") if fluids]
    integrals = "energy", "momentum_x", "momentum_y", "entropy", "impulse_x", "impulse_y", "energy_in"
    scalars = [(name, "f8") for name in integrals]
    watched = [(name, "f8", (points,)) for name in NAMES] if points else []
    return np.dtype([("t", "f8"), ("dt", "f8"), ("least_J", "f8", (layers,)), *masses, *scalars, *watched])


class PlaneState:
    """Layers, solution and what is known of it. Collective on ``comm``.

    places: X [m] of points of interfaces that are watched. partition: as fsipetsc.parallel.plane.grids has it. InputError
    where grid, order and ranks do not fit, a material and the form of the equations, or such an X and the interfaces.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        problem: PlaneProblem,
        order: int,
        h: float,
        form: PlaneForm = USUAL,
        places: Sequence[float] = (),
        partition: str = "auto",
    ) -> None:
        self.comm, self.problem, self.h, self.op = comm, problem, h, OPERATORS[order]
        self._order = order
        self.layout = PlaneLayout(comm, problem, self.op, make_grids(problem, self.op, h), partition)
        self.solution = PETSc.Vec().createMPI((self.layout.local_size, None), comm=comm)
        self._data = EdgeData(self.layout, self._instant)
        self.path, self.convection = PlanePath(self.layout, order, self._data, form), form.convection
        self.watched = Watched(self.layout, self.path, chosen(problem, self.layout, places))
        fluids = sum(layer.kind == "fluid" for layer in problem.layers)
        record = step_record(len(problem.layers), fluids, len(self.watched.points))
        row = record.itemsize // 8
        sizes = BURST, FLAGS + LIMITS, KEPT * row, row - 2
        begins = np.cumsum([0, *sizes]).tolist()
        memory = np.zeros(begins.pop())
        self.burst, self.results, journal, self._latest = np.split(memory, begins[1:])
        self.journal = journal.view(record)
        self.latest = self._latest.view([(name, record[name]) for name in record.names[2:]])[0]
        self._plan_next = Prepared(entries.plan_next, Notes(*begins[:3], row, begins[3]), memory)
        layers = len(problem.layers)
        self._extremes = np.zeros(2 + 3 * layers)  # STOP, BAD, the least J and the rates of each layer
        self.rates = self._extremes[2 + layers :].reshape(-1, 2)  # of convection and diffusion, see stepping.limits
        self._account_end = layers + 2 * fluids + OF_ALL
        arrays = self._extremes[1 : 2 + layers], self.rates, self._latest[layers : self._account_end]
        self._account = Prepared(entries.account_of, self.layout.records, self.path.words, self.path.gains, *arrays)
        self._bound = Prepared(entries.bounds_of, self._extremes, layers, self.results, self._latest[:layers])
        self.evaluations, self.begin, self._t = 0, 0.0, 0.0
        self._jacobians: Mapping[int, Callable[..., Any]] = {}
        self.fault: InputError | None = None  # of a user's function, on this rank

    @property
    def points(self) -> int:
        """Of all layers."""
        return sum(grid.nx * grid.ny for grid in self.layout.grids)

    def compile(self, announce: Callable[[str], None], also: Callable[[], object] = lambda: None) -> None:
        """Compile the kernels of all layers if that has not been done for this machine: one rank first."""
        if self.comm.rank == 0:
            first, *_ = (entry for entry, _ in self.path.entries())
            with garbage_waiting(), compiling(first, announce):
                self._compile()
        wait_asleep(self.comm)
        self._compile()

    def _compile(self) -> None:
        for entry, arguments in self.path.entries():
            entry.compile(tuple(numba.typeof(argument) for argument in arguments))

    def begin_with(self, start: Start) -> None:
        """Let initial data be those of a frame, at its time, instead of the case's."""
        self.problem, self.begin, self._t, self._jacobians = start.problem, start.t, start.t, start.jacobians

    def check_data(self) -> None:
        """Ask the case's functions for all data at the time ``begin`` [s]. InputError, on all ranks, where they are not what
        they must be.
        """
        together(self.comm, self._ask)

    def _ask(self) -> None:
        y = self.solution.getArray()
        for k, layer in enumerate(self.problem.layers):
            if self.layout.dms[k] is None:
                continue
            X, Y = self.layout.grids[k].points(*self.layout.owned(k))
            values, q = given.plane_fields(layer, "initial", X, Y, self.begin), self.layout.local(k, y)
            if layer.exact is not None:  # not found out at the end
                given.plane_fields(layer, "exact", X, Y, self.begin)
            if layer.kind == "solid":
                u, v, T, x, z = values
                for c, value in enumerate((x - X, z - Y, u, v, T)):
                    q[..., c] = value
            else:
                rho, u, v, T = values
                energy = layer.material.internal_energy(rho, T) + 0.5 * (u * u + v * v)
                J = self._jacobians[k](X, Y)[0] if k in self._jacobians else 1.0
                for c, value in enumerate((1.0, rho, rho * u, rho * v, rho * energy)):
                    q[..., c] = J * value
        with np.errstate(all="ignore"):  # of what is given at edges that it can be had: nothing is held yet
            for part in self.path.layers:
                self._data.refresh(part.k, self.begin)
                self._data.lay(part, self.begin)
        for number, meeting in enumerate(self.layout.meetings):
            energies = self.layout.energies(number, y)
            if energies.size:
                solid = meeting.layers[1]
                end = self.layout.local(solid, y)[0 if meeting.rows[1] == 0 else -1]
                energies[:] = 0.5 * self.problem.layers[solid].material.m0 * (end[:, 2] ** 2 + end[:, 3] ** 2)

    def set_initial(self) -> None:
        """Initial data of all layers, J of the grids, projected, at the time ``begin``. InputError."""
        self.check_data()
        y = self.solution.getArray()
        self.path.apply_conditions(y, self.begin)  # which lays the lines of the grids
        for part in self.path.layers:
            self._data.begin(part, self.layout.local(part.k, y))
            if part.k not in self._jacobians:
                part.stretch(self.layout.local(part.k, y))

    def set_data(self, t: float) -> None:
        """The next evaluation of the right-hand side is at time t [s]."""
        self._t = t

    def right_hand_side(self, y: np.ndarray, f: np.ndarray) -> None:
        """f = dy/dt of this rank's part. A fault of a function of the case's is kept: all learn of it after the step."""
        self.evaluations += 1
        try:
            self.path.rates(y, f, self._t)
        except InputError as error:
            self._keep(error)

    def _keep(self, error: InputError) -> None:
        self.fault = self.fault or error
        self.results[SAID_STOP] = FAULT

    def project(self, y: np.ndarray) -> None:
        """Let this rank's part y fulfil all conditions, in place."""
        self.path.project(y, self._t)

    def step(self, t: float, dt: float, steady: bool) -> None:
        """A step dt [s] of the fused Runge-Kutta method from the completed solution at t [s], and its completion; then those
        that follow as the burst allows.

        steady: the data do not depend on time; else PETSc's own methods make the steps (fsipetsc.stepping.solve).
        """
        y, more = self.solution.getArray(), True
        while more:
            self.path.step(y, dt)
            self.evaluations += STAGES
            self._complete(y, True)
            more = self._plan_next()
            dt = float(self.burst[DT])
        self.path.put_points(y)

    def finish(self) -> None:
        """Complete a step that PETSc has made."""
        y = self.solution.getArray()
        self.path.bring(y)
        self._complete(y)
        self.path.put_points(y)

    def _complete(self, y: np.ndarray, fused: bool = False) -> None:
        """Project the local parts, look at them, bound the next step; of y only what stands behind the points is changed.

        fused: after a fused step.
        """
        try:
            self.path.complete(y, self._t)
        except InputError as error:
            self._keep(error)
        self.path.look(fused)
        self._account(y)
        if self.watched.points:
            self._latest[self._account_end :] = 0.0
            try:
                self.watched.look(self.latest, self._t)
            except InputError as error:
                self._keep(error)
        self._extremes[0] = self.results[SAID_STOP]
        if self.comm.size > 1:
            self.comm.Allreduce(MPI.IN_PLACE, self._extremes, MPI.MAX)
        self._bound()

    def _instant(self) -> float:
        """As fsipetsc.stepping.state.State._instant."""
        rate = float(self.results[RATE])
        return 0.25 / rate if 0.0 < rate < np.inf else 1e-3 * self.h

    def keep(self, room: tuple[np.ndarray, ...] | None = None) -> tuple[np.ndarray, ...]:
        """As fsipetsc.stepping.state.State.keep."""
        return (*kept(self, room and room[:-1]), np.array(self._t))

    def back(self, copies: tuple[np.ndarray, ...]) -> None:
        """Be what was kept again."""
        put_back(self, copies[:-1])
        self._t = float(copies[-1])
        self.path.load_completed(self.solution.getArray(), self._t)

    def capture(self, rates: np.ndarray | None = None) -> dict[str, np.ndarray] | None:
        """See fsipetsc.stepping.plane.snapshot.capture."""
        return snapshot.capture(self, rates)

    def restore(self, arrays: Mapping[str, np.ndarray], t: float) -> np.ndarray | None:
        """Be at time t [s] what arrays, known on all ranks, tell of; the rates among them, if any. InputError."""
        snapshot.check(self, arrays)
        self.results[:], as_numbers(self.latest)[:], self._t = arrays["results"], arrays["latest"], t
        y = self.solution.getArray()
        snapshot.put(self.layout, y, arrays)
        try:
            self.path.load_completed(y, t)
        except InputError as error:
            self._keep(error)
        agree(self.comm, self.fault)
        return rates_of(self.layout, arrays, snapshot.put)

    @property
    def reserve(self) -> int:
        """Points held in reserve: no grid grows."""
        return 0

    @property
    def places(self) -> list[float]:
        """Mean heights y [m] of the interfaces, as ranks that have a part of them know them. Collective."""
        own = [np.zeros(2) for _ in self.layout.meetings]
        for number, heights in self.path.interfaces.heights():
            own[number] += heights.sum(), heights.size
        return [float(total / count) for total, count in map(self.comm.allreduce, own)]

    def failure(self, t: float, step: int) -> Failure:
        """What is wrong with a state that is not physical. Collective."""
        return describe_failure(self, t, step)

    def unknowns(self, y: np.ndarray) -> list[np.ndarray]:
        """Those of this rank's part y, layer by layer."""
        return [self.layout.local(part.k, y).reshape(-1, DOF) for part in self.path.layers]

    def compile_saving(self) -> None:
        """All has been compiled."""

    def compile_path(self, announce: Callable[[str], None]) -> None:
        """All has been compiled."""

    @property
    def recorded(self) -> list[list[float]]:
        """[interface, X] of the points of interfaces that are recorded at each step."""
        return [[number, X] for number, _, X in self.watched.points]

    def header(self) -> list[dict[str, Any]]:
        """What a result file says of each layer; of a solid its conductivity, too, by which fluxes of heat are known."""
        return [
            {
                **{"name": layer.name, "kind": layer.kind, "fields": list(layer.fields)},
                **{"shape": [grid.ny, grid.nx], "origin": [grid.x0, grid.y0], "spacing": [grid.h_x, grid.h_y]},
                **({"kappa_e": layer.material.kappa_e} if layer.kind == "solid" else {}),
            }
            for layer, grid in zip(self.problem.layers, self.layout.grids, strict=True)
        ]

    def grids(self) -> list[dict[str, Any]]:
        """What the writer must know of the points: by number, rank by rank, in the order of rows."""
        return [
            {"local": len(numbers), "n": grid.nx * grid.ny, "X": numbers}
            for grid, numbers in zip(self.layout.grids, self.path.saved_numbers(), strict=True)
        ]

    def save(self, slots: tuple[np.ndarray, Sequence[int], int]) -> None:
        """Put what is saved of this rank's points in the slots of a frame (fsipetsc.output.buffers.Slots). Collective."""
        values, starts, stride = slots
        for k, rows in enumerate(self.path.saved()):
            if rows.size:
                begin = int(starts[k])
                to = np.lib.stride_tricks.as_strided(values[begin:], rows.shape, (8 * stride, 8))
                to[:] = rows

    def errors(self, t: float, norm: str) -> dict[str, dict[str, float]] | None:
        """As fsipetsc.stepping.frames.errors, of (rho, u, v, T) and (u, v, T, x, y), with the norm of the operators: that is an
        integral to their order. Collective.
        """
        layers = self.problem.layers
        if any(layer.exact is None for layer in layers):
            return None
        names = {"fluid": ("rho", "u", "v", "T"), "solid": ("u", "v", "T", "x", "y")}
        power = {"L1": 1, "L2": 2}[norm]
        sums = {kind: np.zeros(len(names[kind])) for kind in {layer.kind for layer in layers}}
        for kind, parts in together(self.comm, lambda: self._departures(t)):
            sums[kind] += [np.sum(np.abs(part) ** power * area) for part, area in parts]
        result = {}
        for kind in sorted(sums):
            total = self.comm.allreduce(sums[kind])
            result[kind] = {name: float(v) for name, v in zip(names[kind], total ** (1 / power), strict=True)}
            result[kind]["combined"] = float(total.sum() ** (1 / power))
        return result

    def _departures(self, t: float) -> list[tuple[str, list[tuple[np.ndarray, np.ndarray]]]]:
        """kind, [(computed less exact, area of each point, by the norm of the operators)] of this rank's layers."""
        found = []
        for part in self.path.layers:
            layer, grid = self.problem.layers[part.k], self.layout.grids[part.k]
            exact = given.plane_fields(layer, "exact", *grid.points(*self.layout.owned(part.k)), t)
            columns = (0, 1, 2, 3) if layer.kind == "fluid" else (0, 1, 2, 6, 7)
            across_y = self.op.norm_weights(grid.ny)[part.rows, None]
            along_x = np.ones(grid.nx) if grid.periodic else self.op.norm_weights(grid.nx)
            saved, area = part.save(), grid.h_x * grid.h_y * along_x[part.columns] * across_y
            found.append((layer.kind, [(saved[..., c] - e, area) for c, e in zip(columns, exact, strict=True)]))
        return found

    def destroy(self) -> None:
        """Free vectors, DMDAs and communicators, in this order."""
        self.path.destroy()
        self.solution.destroy()
        self.layout.destroy()

    def __enter__(self) -> PlaneState:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Destroy it, unless this rank may be alone with an error: the others would not meet it there."""
        if error is None or self.comm.size == 1 or (isinstance(error, FsiError) and error.collective):
            self.destroy()
