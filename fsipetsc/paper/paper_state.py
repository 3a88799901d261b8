"""The state of a run of the paper's method.

One evaluation of the right-hand side:

    1  interfaces   the owners of the two sides of an interface swap the rows that D reaches from
                    it, and each of them solves the same small system      (Thm 4.1, Sec. 4.2)
    2  halos        neighbours fill the local arrays: twice the reach of D, because D acts twice;
                    the owner of a gas's interface point tells the layer its velocity s and its
                    place x_I                                              (4.20), (4.25)
    3  points       ghost points (4.26), then the rates of all points      (4.19), (4.20)

Interfaces come before halos, so that neighbours of an owner get rows that fulfil the conditions.
The point arithmetic is the same on any number of ranks, and nothing is added up over ranks: so are
the results, bit for bit.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.checks import names_of
from fsipetsc.errors import InputError
from fsipetsc.kernels.arrays import zeros
from fsipetsc.kernels.procedure import calling_code
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.paper import steps
from fsipetsc.paper.coupling import couple, note
from fsipetsc.paper.layers import (
    DOF,
    RECORD,
    Interface,
    Layer,
    check_ends,
    check_form,
    make_records,
    note_share,
    shares_of,
    used_up,
)
from fsipetsc.paper.stencils import stencils
from fsipetsc.parallel.exchange import Exchange, Reduction, exchange_text
from fsipetsc.problem import Problem, SolidLayer
from fsipetsc.process.libraries import libraries
from fsipetsc.process.together import agree, together
from fsipetsc.scheme.plan import (
    EXHAUSTED,
    SAID_STOP,
    TOO_SHORT,
    plan_next,
    step_record,
)
from fsipetsc.state import FAULT, Seen, State

Array = np.ndarray
#: of the record of a layer: where its grid lies, and how it moves
FRAME = "lo", "hi", "s", "x_interface"
ROWS_TAG, HALOS_TAG = 0, 1  # of messages between ranks


class PaperState(State):
    """A run in the paper's method; all methods are collective on ``comm``.

    opt: options in force; announce: told of what is compiled. InputError where grid, order and
    number of ranks do not fit, or the problem is not of the paper's form.

    records, layers: see fsipetsc.paper.layers. bounds: (layers, 2), the largest rates of convection
    and diffusion [1/s]; k: rates. loose: gases on which a force acts.
    """

    _filled = False  # whether there are data of ends, jumps, forcing

    def __init__(
        self,
        comm: MPI.Comm,
        problem: Problem,
        opt: Mapping[str, Any],
        announce: Callable[[str], None] = lambda text: None,
    ) -> None:
        check_form(problem, opt)
        order, self.h = opt["fsi_order"], opt["fsi_h"]
        self.comm, self.problem, self.op = comm, problem, OPERATORS[order]
        self.asks = not problem.steady_data
        self.loose = [v for v in problem.layers if v.kind == "fluid" and any(v.material.force)]
        op = stencils(order, opt["fsi_viscous"] == "narrow")
        records = make_records(problem, self.op, self.h)
        of_share = records, op.halo, opt["fsi_partition"]
        shares = shares_of(comm.size, problem, self.op, *of_share)
        pairs = zip(records, shares, strict=True)
        points = [note_share(record, share, comm.rank, op.halo) for record, share in pairs]
        # what ranks send each other of a stage: the records, and layers with their halos
        dof = np.array([DOF[layer.kind] for layer in problem.layers])
        sizes = records.nbytes // 8, *(dof * points)
        memory = zeros(sum(sizes))
        of_records, *local = np.split(memory, np.cumsum(sizes)[:-1])
        self.records = of_records.view(RECORD)
        self.records[:] = records
        begins = np.cumsum([0, *(dof * (records["own_hi"] - records["own_lo"]))]).tolist()
        self.y, total, self.k = zeros((3, begins[-1]))
        self.solution = PETSc.Vec().createWithArray(self.y, comm=comm)
        of_steps = self._lay_results(int(sum(dof == DOF["fluid"])))
        self.changing = self.y, self.records, self.results, self.batch
        self.layers = []
        for k, layer in enumerate(problem.layers):
            ends = tuple(problem.end(k, side) for side in (0, 1))
            place, vectors = slice(begins[k], begins[k + 1]), (self.y, total, self.k)
            where = local[k].reshape(dof[k], -1), place, vectors
            of_layer = self.records[k:][:1], shares[k], op, *where, self.bounds[k], self.batch
            self.layers.append(Layer(layer, ends, *of_layer))
        self.shapes = [(n,) for n in records["n"].tolist()]
        self.parts = {layer.number: layer for layer in self.layers if layer.present}
        kind, notes = opt["fsi_coupling"], of_steps.notes.reshape(steps.NOTES, -1)
        rooms = np.zeros((len(problem.interfaces), sum(DOF.values()), op.n))
        self.interfaces = [
            Interface(kind, [self.layers[n] for n in pair], k, notes, rooms, memory, comm.rank)
            for k, pair in enumerate(problem.interfaces)
        ]
        rows = [route for one in self.interfaces for route in one.routes]
        halos = [route for layer in self.layers for route in layer.routes(comm.rank, memory)]
        self._rows = Exchange(comm, ROWS_TAG, rows, rooms, memory)
        self._halos = Exchange(comm, HALOS_TAG, halos, memory, memory)
        self._load_procedures(of_steps, announce)

    def _lay_results(self, gases: int) -> steps.Steps:
        """Make what is known after a step: what ranks tell each other comes first."""
        record = step_record(len(self.problem.interfaces), gases)
        noted, count = len(self.problem.interfaces) * steps.NOTES, 2 * len(self.records)
        numbers = self._lay_journal(record, count)
        first = self.results.size
        rates, notes = numbers[first:][:count], numbers[first + count :][:noted]
        self.bounds = rates.reshape(-1, 2)
        told, sums = np.split(numbers, [first + count + noted])
        return steps.Steps(told, self.results, rates, notes, sums)

    def _load_procedures(self, of_steps: steps.Steps, announce: Callable[[str], None]) -> None:
        """Record all procedures, the same ones on all ranks, and make machine code of them."""
        code = calling_code(exchange_text())
        solid = next(layer.number for layer in self.layers if not layer.is_gas)
        for layer in self.layers:
            place = ("left", "solid", "right")[layer.number - solid + 1]
            layer.does = steps.of_layer(code, place, layer.part, of_steps)
        for one in self.interfaces:
            place = ("left", "right")[one.side]
            functions = couple, note
            one.does = {f: code.procedure(f"{f.__name__}_{place}", f, one.sides) for f in functions}
        functions = steps.forget, steps.tell, steps.finish
        self._does = {f: code.procedure(f.__name__, f, of_steps) for f in functions}
        planning = code.procedure("plan_next", plan_next, self.plan)
        (library,) = libraries(self.comm, [code.text], announce)
        code.load(library)
        self._reduction = Reduction(self.comm, of_steps.told)
        for exchange in (self._rows, self._halos, self._reduction):
            exchange.load(library)
        self._take_calls(library, planning)

    def phase(self, name: str, n: int, f: Array | None = None) -> list[Any]:
        here, does, found = self.parts.values(), self._does, list[Any]()
        if name == "fulfil" and n > 0:  # the solution fulfils the conditions
            found += [self._rows]
            found += [one.does[couple] for one in self.interfaces if any(one.here)]
            found += [layer.does["close"] for layer in here if not layer.is_gas]
            found += [self._halos]
        elif name in ("rates", "advance"):
            # a stage fulfils the conditions but for the ghost point, the completed solution all
            made = [*["fill"] * (n != 0), "rates", f"{name}_{n}"]
            found += [v.does[one] for v in here for one in made if one in v.does]
        elif name == "complete":
            found += [does[steps.forget], *(layer.does["complete"] for layer in here)]
            # the owner of the solid notes an interface
            found += [one.does[note] for one in self.interfaces if one.here[1]]
            found += [does[steps.tell], self._reduction] if self.comm.size > 1 else []
            found += [does[steps.finish]]
        return [(one, ()) for one in found if not getattr(one, "empty", False)]

    # what is known of it

    @property
    def points(self) -> int:
        """The number of active points of all layers. Collective."""
        self._learn_frames()
        return int((self.records["hi"] - self.records["lo"] + 1).sum())

    def _learn_frames(self) -> None:
        """Let all ranks know where the grids of layers lie, and how they move."""
        frames = np.array([self.records[name] for name in FRAME], float)
        frames[:, self.records["present"] == 0] = -np.inf
        self.comm.Allreduce(MPI.IN_PLACE, frames, MPI.MAX)
        for name, of_layers in zip(FRAME, frames, strict=True):
            self.records[name] = of_layers

    def used_up(self) -> str:
        """Which gas has no points left, or too few, and where it is."""
        self._learn_frames()
        exhausted, too_short = self.results[[EXHAUSTED, TOO_SHORT]].tolist()
        record = self.records[int(exhausted or too_short) - 1]
        return used_up(record, self.problem, self.op, bool(exhausted))

    def owned(self, k: int) -> Array:
        return self.layers[k].of(self.y)

    def numbers(self, k: int) -> Array:
        return self.layers[k].numbers

    def fields(self, k: int) -> Sequence[str]:
        return self.problem.layers[k].fields

    def compared(self, kind: str) -> Sequence[str]:
        return names_of(kind, "exact", 1) if kind == "fluid" else SolidLayer.unknowns

    def powers(self, k: int, names: Sequence[str], t: float, power: int) -> Array:
        return self.parts[k].powers(t, power)

    def grids(self) -> list[dict[str, Any]]:
        """What the writer must know of the points of each layer: see RunWriter."""
        return [{"n": int(p.record["n"]), "X": p.X} for p in self.layers]

    def save(self) -> dict[int, Array]:
        """What is saved of this rank's points, (local, 5) by layer."""
        return {k: layer.saved() for k, layer in self.parts.items()}

    def seen(self) -> list[Seen]:
        """Values at this rank's active points."""
        return [part.seen() for part in self.parts.values()]

    def destroy(self) -> None:
        """Free messages and the vector."""
        self._rows.destroy()
        self._halos.destroy()
        self.solution.destroy()

    # data

    def set_data(self, t: float) -> None:
        """Evaluate boundary data, jumps and forcing at time t [s]; once if they are steady.

        If a function of the user's fails, here alone perhaps, the step goes on, and all ranks learn
        of it when it is complete: see ``fault``.
        """
        problem, records = self.problem, self.records
        if self._filled and not self.asks:
            return
        self._filled = True
        try:
            for k, side, end in ((0, 0, problem.left), (-1, 1, problem.right)):
                values, records[k]["end_heat"][side] = end.data(t)
                records[k]["end_data"][side, : len(values)] = values
            if problem.jumps is not None:
                for k, interface in enumerate(self.interfaces):
                    interface.jump[:] = problem.jumps_at(k, t)
            for part in self.parts.values():
                part.set_forcing(t)
        except InputError as error:
            self.fault = self.fault or error
            self.results[SAID_STOP] = FAULT

    def check_data(self, t_end: float | None = None) -> None:
        """Fill the solution, not projected, with initial data, and ask for all else at t = 0; walls
        are at rest.

        InputError, on all ranks, where something is not what it must be.
        """

        def fill() -> None:
            for part in self.parts.values():
                part.set_initial(part.of(self.y))
            check_ends(self.problem, self.h)

        together(self.comm, fill)
        self.set_data(0.0)
        agree(self.comm, self.fault)

    def set_initial(self) -> None:
        """Initial data of all layers, projected. InputError."""
        self.check_data()
        self.finish()

    # steps; all stages are in the same memory

    def load(self, n: int, y: Array) -> None:
        for layer in self.parts.values():
            layer.owned[:] = layer.of(y).T

    def unload(self, n: int, y: Array) -> None:
        for layer in self.parts.values():
            layer.of(y)[:] = layer.owned.T

    def right_hand_side(self, y: Array, f: Array) -> None:
        super().right_hand_side(y, f)
        f[:] = self.k

    def show(self, n: int) -> None:
        """Do nothing: the halos are filled."""

    def begin(self) -> None:
        self.load(0, self.y)
        self._halos()

    # checkpoints

    def more(self) -> Mapping[str, Array]:
        """Where the grids of layers lie, and how they move."""
        self._learn_frames()
        return {name: self.records[name].copy() for name in FRAME}

    def take(self, arrays: Mapping[str, Array]) -> None:
        for name in FRAME:
            self.records[name] = arrays[name]
