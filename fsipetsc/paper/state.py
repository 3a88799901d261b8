"""The state of a run of the paper's method: what fsipetsc.stepping drives.

One evaluation of the right-hand side:

    1  interfaces   the owners of the two sides of an interface swap the rows that D reaches from
                    it, and each of them solves the same small system      (Thm 4.1, Sec. 4.2)
    2  frames       the owner of a gas's interface point tells the layer its velocity s and its
                    place x_I                                              (4.20), (4.25)
    3  halos        neighbours fill the local arrays: twice the reach of D, because D acts twice
    4  points       ghost points (4.26), then the rates of all points      (4.19), (4.20)

Interfaces come before halos, so that neighbours of an owner get rows that fulfil the conditions.
The point arithmetic is the same on any number of ranks, and nothing is added up over ranks: so are
the results, bit for bit.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blocks.values import names_of
from fsipetsc.errors import InputError
from fsipetsc.kernels.calls import Calls, calling_code
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.paper import steps
from fsipetsc.paper.ends import ends_of
from fsipetsc.paper.layout import DOF, check_ends, check_form, make_records, share_out
from fsipetsc.paper.parts import Interface, Layer
from fsipetsc.paper.stencils import stencils
from fsipetsc.parallel.exchange import Reduction, exchange_text
from fsipetsc.problem import Problem, SolidLayer
from fsipetsc.process.libraries import libraries
from fsipetsc.process.together import agree, together
from fsipetsc.scheme.batch import ALLOWED, DT, MADE, TIME, plan_next
from fsipetsc.scheme.plan import BAD, CAPACITY, FLAGS, LIMITS, SAID_STOP, step_record
from fsipetsc.state import FAULT, Seen, State, as_numbers, crushed, whole

Array = np.ndarray
#: times of the stages, in steps
FRACTIONS = 0.0, 0.5, 0.5, 1.0
#: of the record of a layer: what all ranks learn after a step, beside its rates
FRAME = "lo", "hi", "s", "x_interface"
#: what the paper's method has of options that choose between methods
_WITHOUT = {
    "fsi_mapping": ("auto", "rigid"),
    "fsi_dissipation": (0.0, -1.0),
    "fsi_shock": (0.0,),
    "fsi_convection": ("auto", "divergence"),
}


class PaperState(State):
    """Solution and everything that belongs to it; all methods are collective on ``comm``.

    records, shares: of the layers (fsipetsc.paper.layout); solution (world Vec). evaluations of the
    right-hand side are counted. layers: all (fsipetsc.paper.parts); here: those that this rank has
    a part of. opt: options in force; announce: told of what is compiled. InputError where grid,
    order and number of ranks do not fit, or the problem is not of the paper's form.
    """

    KINDS: Mapping[str, str] = MappingProxyType({"latest": "any", "lo": "whole", "hi": "whole"})
    fault: InputError | None = None
    _kept: tuple[Array, ...] = ()  # what the last call of ``step`` began with

    def __init__(
        self,
        comm: MPI.Comm,
        problem: Problem,
        opt: Mapping[str, Any],
        announce: Callable[[str], None] = lambda text: None,
    ) -> None:
        for name, without in _WITHOUT.items():
            if opt[name] not in without:
                raise InputError(
                    f"-{name} {opt[name]}: -fsi_coupling {opt['fsi_coupling']} has none: "
                    "take -fsi_coupling conservative"
                )
        check_form(problem)
        order, self.h = opt["fsi_order"], opt["fsi_h"]
        self.comm, self.problem, self.op = comm, problem, OPERATORS[order]
        self.evaluations = 0
        op = stencils(order, opt["fsi_viscous"] == "narrow")
        self.records = make_records(problem, self.op, self.h, op.halo)
        self.shares = share_out(comm, problem, self.op, self.records, opt["fsi_partition"])
        dof = [DOF[layer.kind] for layer in problem.layers]
        begins = np.cumsum([0, *(dof * (self.records["own_hi"] - self.records["own_lo"]))])
        memory = self._y, _, self.k = np.zeros((3, int(begins[-1])))
        self.solution = PETSc.Vec().createWithArray(self._y, comm=comm)
        self.results, noted = np.zeros(FLAGS + LIMITS), len(problem.interfaces) * steps.NOTES
        record = step_record(len(problem.interfaces), dof.count(DOF["fluid"]))
        _, latest = self._lay_journal(record, CAPACITY)
        self._notes = latest[:noted]
        ends = [ends_of(problem, k, order) for k in range(len(dof))]
        of_layers = problem.layers, ends, self.shares
        self.layers = [
            Layer(layer, ends, self.records[k:][:1], share, op, memory, int(begins[k]), self.batch)
            for k, (layer, ends, share) in enumerate(zip(*of_layers, strict=True))
        ]
        self.here = [layer for layer in self.layers if layer.present]
        kind, notes = opt["fsi_coupling"], self._notes.reshape(steps.NOTES, -1)
        self.interfaces = [
            Interface(comm, k, kind, *(self.layers[n] for n in pair), notes)
            for k, pair in enumerate(problem.interfaces)
        ]
        told = np.zeros(steps.TOLD * len(self.records) + noted + self.results.size)
        self._connect(told)
        of_steps = steps.Steps(self.records, self.results, self._notes, latest[noted:], told)
        self._load_procedures(of_steps, announce)

    def _connect(self, told: Array) -> None:
        """Make all exchanges. Collective."""
        for layer in self.layers:
            layer.connect(self.comm)
        for interface in self.interfaces:
            interface.connect()
        self._all_hear = Reduction(self.comm, told)

    def _load_procedures(self, of_steps: steps.Steps, announce: Callable[[str], None]) -> None:
        """Record all procedures, the same ones on all ranks, and make machine code of them."""
        code = calling_code(exchange_text())
        solid = next(layer.number for layer in self.layers if not layer.is_gas)
        for layer in self.layers:
            layer.record_on(code, ("left", "solid", "right")[layer.number - solid + 1], of_steps)
        for interface in self.interfaces:
            interface.record_on(code)
        self._does = steps.of_step(code, of_steps)
        self.planning = code.procedure("plan_next", plan_next, self.plan)
        (library,) = libraries(self.comm, [code.text], announce)
        code.load(library)
        parts = *self.layers, *self.interfaces
        for exchange in (*(one for part in parts for one in part.exchanges), self._all_hear):
            exchange.load(library)
        numbers = (steps.RATES_ALONE, *range(steps.STAGES))
        stages = {n: [one for layer in self.here for one in layer.stage(n)] for n in numbers}
        completing = [self._does["forget"], *(layer.does["complete"] for layer in self.here)]
        completing += [one for interface in self.interfaces for one in interface.note()]
        if self.comm.size > 1:
            completing += [self._does["tell"], self._all_hear, self._does["hear"]]
        completing.append(self._does["finish"])
        fulfil = [one for interface in self.interfaces for one in interface.coupling()]
        fulfil += [one for layer in self.here for one in layer.exchange()]
        of_step = list(stages[0])  # it begins with the completed solution
        for n in range(1, steps.STAGES):
            of_step += [*fulfil, *stages[n]]
        of_step += [*fulfil, *completing, self.planning]

        def calls(procedures: list[Any]) -> Calls:
            return Calls(library, [(procedure, ()) for procedure in procedures])

        self._stages = {n: calls(procedures) for n, procedures in stages.items()}
        #: what lets the stage fulfil all conditions but for ghost points, which are filled later
        self._fulfil = calls(fulfil)
        self._completing, self._batch = calls(completing), calls(of_step)

    # data

    def first_notes(self) -> list[str]:
        """Forces that do not keep rest. Else nothing: frames are cut where walls are, and the
        couplings bring stresses together.
        """
        return [
            f"note: the force on '{layer.name}' is added node by node: a gas at rest stays so to "
            "the order of the scheme only, and small motions may grow; -fsi_coupling conservative "
            "keeps rest"
            for layer in self.problem.layers
            if layer.kind == "fluid" and any(layer.material.force)
        ]

    def last_notes(self) -> list[str]:
        """No notes."""
        return []

    inflows = last_notes

    def set_data(self, t: float) -> None:
        """Evaluate boundary data, jumps and forcing at time t [s] for the next evaluation of the
        right-hand side.

        If a function of the user's fails, here alone perhaps, the data stay as they are, the step
        goes on, and all ranks learn of it when it is complete: see ``fault``.
        """
        try:
            self._set_data(t)
        except InputError as error:
            self.fault = self.fault or error
            self.results[SAID_STOP] = FAULT

    def _set_data(self, t: float) -> None:
        problem, records = self.problem, self.records
        for k, side, end in ((0, 0, problem.left), (-1, 1, problem.right)):
            values = end.data(side, t)
            records[k]["end_data"][side, : len(values)] = values
            records[k]["end_heat"][side] = end.heat(side, t)
        if problem.jumps is not None:
            for k, interface in enumerate(self.interfaces):
                interface.jump[:] = problem.jumps_at(k, t)
        for part in self.here:
            if part.forcing is not None:
                values = part.layer.values("forcing", part.X, t, part.active)
                part.forcing[:] = 0.0
                part.forcing[part.active] = np.stack(values, axis=-1)[part.active]

    def check_data(self) -> None:
        """Fill the solution, not projected, with initial data, and ask for all else at t = 0.

        InputError, on all ranks, where something is not what it must be.
        """

        def set_layers() -> list[dict[tuple[int, int], float]]:
            return [part.set_initial(part.of(self._y)) for part in self.here]

        found = self.comm.allgather(together(self.comm, set_layers))
        ends = {end: x for mine in found for layer in mine for end, x in layer.items()}
        check_ends(self.problem, ends, self.h)
        self.set_data(0.0)
        agree(self.comm, self.fault)

    def check_motion(self, t_end: float) -> None:
        """Do nothing: walls are at rest (fsipetsc.paper.layout.check_form)."""

    def set_initial(self) -> None:
        """Initial data of all layers, projected. InputError where they are not what they must
        be."""
        self.check_data()
        self.finish()

    # what is said of it

    @property
    def rates(self) -> Array:
        """(layers, 2): the largest rates of convection and diffusion [1/s] of each layer."""
        return self.records["rates"]

    @property
    def places(self) -> list[float]:
        """Positions x [m] of the interfaces."""
        return self.latest["x_interface"].tolist()

    @property
    def points(self) -> int:
        """Active points of all layers."""
        return sum(int(r["hi"] - r["lo"]) + 1 for r in self.records)

    def header(self) -> dict[str, Any]:
        """What a result file says of layers, and of points that are recorded: none."""
        layers = zip(self.problem.layers, self.records["n"].tolist(), strict=True)
        about = [
            {"name": v.name, "kind": v.kind, "fields": list(v.fields), "shape": [n]}
            for v, n in layers
        ]
        return {"layers": about, "points": ()}

    def grids(self) -> list[dict[str, Any]]:
        """What the writer must know of the points of each layer: see RunWriter."""
        return [{"n": int(p.record["n"]), "X": p.X} for p in self.layers]

    def save(self) -> dict[int, Array]:
        """What is saved of this rank's points, (local, 5) by layer."""
        return {layer.number: layer.saved() for layer in self.here}

    def errors(self, t: float, norm: str = "L2") -> dict[str, dict[str, float]] | None:
        """Errors at time t [s]: kind of layer -> name -> (h sum |difference|^p)^(1/p), and
        "combined" over the unknowns.

        norm: "L1" or "L2", p = 1 or 2. Active points without ghosts of all layers of a kind. None
        without an exact solution. Collective; InputError if the exact solution cannot be had.
        """
        if any(layer.exact is None for layer in self.problem.layers):
            return None
        power = {"L1": 1, "L2": 2}[norm]
        names = {"fluid": names_of("fluid", "exact", 1), "solid": SolidLayer.unknowns}
        sums = {kind: np.zeros(len(names[kind])) for kind in names}
        found = together(self.comm, lambda: [part.powers(t, power) for part in self.here])
        for part, own in zip(self.here, found, strict=True):
            sums[part.layer.kind] += own
        return self._norms(sums, names, power)

    def seen(self) -> list[Seen]:
        """Values at this rank's active points."""
        return [part.seen() for part in self.here]

    # steps

    def _load(self, y: Array) -> None:
        """Let the stage be this rank's part y."""
        for layer in self.here:
            layer.owned[:] = layer.of(y)

    def right_hand_side(self, y: Array, f: Array) -> None:
        """f = dy/dt of this rank's part, at the projected y, for the data set last."""
        self.evaluations += 1
        self._load(y)
        self._fulfil()
        self._stages[steps.RATES_ALONE]()
        f[:] = self.k

    def _complete(self) -> None:
        """Project the stage, which is the new solution, let boundaries move, and monitor it."""
        self._fulfil()
        self._completing()

    def finish(self) -> None:
        """Complete a step whose raw result PETSc has left in the solution."""
        self._load(self._y)
        self._complete()

    def step(self, t: float, dt: float, steady: bool) -> None:
        """A step dt [s] of the classical Runge-Kutta method from the completed solution at t [s],
        and its completion.

        The others of its batch follow. steady: the data do not depend on time; all steps are one
        call of C then.
        """
        self.batch[DT] = dt
        changed = self._y, self.records, self.results, self.batch
        self._kept = tuple(array.copy() for array in changed)
        if steady:
            self._batch.batch(self.results[BAD:], self.batch[ALLOWED:])
            self.evaluations += steps.STAGES * max(1, int(self.batch[MADE]))
            return
        more = True
        while more:
            self.evaluations += steps.STAGES
            self._advance(t, dt, steady)
            more, dt = self.plan_next(), self.batch[DT]

    def _advance(
        self, t: float, dt: float, steady: bool, ends: Callable[[], Any] = lambda: None
    ) -> bool:
        """A step of the length that batch has, dt [s]; ends: called with each stage that fulfils
        the conditions, and with the completed one. Where it returns something, the step ends, and
        returns True.
        """
        for number, fraction in enumerate(FRACTIONS):
            if not steady:
                self.set_data(t + fraction * dt)
            if number > 0:  # it begins with the completed solution
                self._fulfil()
                if ends():
                    return True
            self._stages[number]()
        if not steady:
            self.set_data(t + dt)
        self._complete()
        return bool(ends())

    def go_to_fault(self, unphysical: Callable[[], Any]) -> str:
        """Repeat the steps since the last call of ``step`` up to the first unphysical stage: NaN
        spreads from there. Steps of PETSc's methods are not repeated.
        """
        if not self._kept:
            return ""
        self._y[:], records, self.results[:], self.batch[:] = self._kept
        for name in FRAME:
            self.records[name] = records[name]
        self._begin()
        said, more = "", True
        while more:
            said = self._crushed()
            t, dt = self.batch[[TIME, DT]].tolist()
            more = (
                not self._advance(t, dt, self.problem.steady_data, unphysical) and self.plan_next()
            )
        return said

    def _crushed(self) -> str:
        """Where the solid is crushed most, if it is. Collective."""
        mine = [(*part.shortest(), part.number) for part in self.here if not part.is_gas]
        every = (one for some in self.comm.allgather(mine) for one in some)
        stretch, node, X, push, k = min(every)
        layer = self.problem.layers[k]
        where = f"'{layer.name}' at X = {X:.6g}{self.problem.unit('m')} (node {node})"
        return crushed(where, stretch, push, layer.material.K)

    # checkpoints

    def capture(self) -> dict[str, Array] | None:
        """What a step depends on, on rank 0: whole layers, where their grids lie and how they move,
        and the results of the last step. Collective."""
        arrays = {}
        for layer in self.layers:
            size, own = int(layer.record["n"]), layer.of(self._y)
            arrays[f"layer{layer.number}"] = whole(self.comm, size, layer.numbers, own)
        if self.comm.rank > 0:
            return None
        frames = {name: self.records[name].copy() for name in FRAME}
        latest = as_numbers(self.latest).copy()
        return {**arrays, **frames, "results": self.results.copy(), "latest": latest}

    def kept_shapes(self) -> dict[str, tuple[int, ...]]:
        """Name -> shape of each array that ``capture`` gives."""
        sizes = zip(self.problem.layers, self.records["n"].tolist(), strict=True)
        layers = {f"layer{k}": (n, DOF[layer.kind]) for k, (layer, n) in enumerate(sizes)}
        frames = dict.fromkeys(FRAME, self.records.shape)
        results, latest = self.results.shape, as_numbers(self.latest).shape
        return {**layers, **frames, "results": results, "latest": latest}

    def check_places(self, arrays: Mapping[str, Array]) -> None:
        """ValueError if the active points of a checkpoint are not those of its interfaces."""
        for k, layer in enumerate(self.layers):
            now = layer.record
            lo, hi, x = (arrays[name][k].item() for name in ("lo", "hi", "x_interface"))
            fits = lo == now["lo"], hi == now["hi"]
            if layer.is_gas:  # the end at its boundary moves over the grid
                side = int(now["outer"])
                beyond = hi - lo - abs(now["end_x"][side] - x) / now["h"]
                fits = fits[1 - side], 0 <= lo, hi < now["n"], -1e-6 < beyond < 1.0 + 1e-6
            if not all(fits):
                raise ValueError(f"its arrays lo, hi and x_interface do not fit at layer {k}")

    def restore(self, arrays: Mapping[str, Array], t: float) -> None:
        """Be at time t [s] what arrays, known on all ranks, tell of. InputError."""
        for name in FRAME:
            self.records[name] = arrays[name]
        self.results[:], as_numbers(self.latest)[:] = arrays["results"], arrays["latest"]
        self.set_data(t)
        agree(self.comm, self.fault)
        for layer in self.here:
            layer.of(self._y)[:] = arrays[f"layer{layer.number}"][layer.numbers]
        self._begin()

    def _begin(self) -> None:
        """Let the stage be the solution, which is completed: it fulfils the conditions."""
        self._load(self._y)
        for layer in self.here:
            layer.fill_halos()

    def destroy(self) -> None:
        """Free messages and the vector."""
        for one in (*self.layers, *self.interfaces):
            one.destroy()
        self.solution.destroy()
