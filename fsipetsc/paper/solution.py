"""The solution of a problem in the paper's method: layers, their exchanges and procedures, what is
known of it.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blocks.values import names_of
from fsipetsc.errors import InputError
from fsipetsc.kernels.calls import Calls, calling_code
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.paper import steps
from fsipetsc.paper.layout import DOF, check_form, make_records, share_out
from fsipetsc.paper.outer_ends import ends_of
from fsipetsc.paper.parts import Interface, Layer
from fsipetsc.paper.stencils import stencils
from fsipetsc.parallel.exchange import Reduction, exchange_text
from fsipetsc.problem import Problem, SolidLayer
from fsipetsc.process.libraries import libraries
from fsipetsc.process.together import together
from fsipetsc.scheme.batch import plan_next
from fsipetsc.scheme.plan import CAPACITY, FLAGS, LIMITS, step_record
from fsipetsc.state import Seen, State

Array = np.ndarray
#: what the paper's method has of options that choose between methods
_WITHOUT = {
    "fsi_mapping": ("auto", "rigid"),
    "fsi_dissipation": (0.0, -1.0),
    "fsi_shock": (0.0,),
    "fsi_convection": ("auto", "divergence"),
}


class PaperSolution(State):
    """Layers of a run, and all that steps call; all methods are collective on ``comm``.

    records, shares: of the layers (fsipetsc.paper.layout); solution (world Vec). evaluations of the
    right-hand side are counted. layers: all (fsipetsc.paper.parts); here: those that this rank has
    a part of. opt: options in force; announce: told of what is compiled. InputError where grid,
    order and number of ranks do not fit, or the problem is not of the paper's form.
    """

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
        memory = self.y, _, self.k = np.zeros((3, int(begins[-1])))
        self.solution = PETSc.Vec().createWithArray(self.y, comm=comm)
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

        self.stages = {n: calls(procedures) for n, procedures in stages.items()}
        #: what lets the stage fulfil all conditions but for ghost points, which are filled later
        self.fulfil = calls(fulfil)
        self.completing, self.whole_step = calls(completing), calls(of_step)

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
        """The number of active points of all layers."""
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

    def _load(self, y: Array) -> None:
        """Let the stage be this rank's part y."""
        for layer in self.here:
            layer.owned[:] = layer.of(y)

    def destroy(self) -> None:
        """Free messages and the vector."""
        for one in (*self.layers, *self.interfaces):
            one.destroy()
        self.solution.destroy()
