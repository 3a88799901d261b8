"""The state of a run of the paper's method.

One evaluation of the right-hand side:

    1  interfaces   the owners of the two sides of an interface swap the rows that D reaches from
                    it, and each of them solves the same small system      (Thm 4.1, Sec. 4.2)
    2  halos        neighbours swap twice the reach of D, because D acts twice; the owner of a gas's
                    interface point tells the others its velocity s and place x_I  (4.20), (4.25)
    3  points       ghost points (4.26), then the rates of all points      (4.19), (4.20)

Interfaces come before halos, so that neighbours of an owner get rows that fulfil the conditions.
Nothing is added up over ranks: results are the same on any number of them, bit for bit.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.checks import NOWHERE, Array
from fsipetsc.kernels.loops import zeros
from fsipetsc.kernels.procedure import Code
from fsipetsc.kernels.symbols import Symbol
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.paper import ends, rates
from fsipetsc.paper.coupling import Interface, couple, note
from fsipetsc.paper.paper_layers import check_form, exchanges_of, layers_of
from fsipetsc.parallel.exchange import EXCHANGES, Reduction
from fsipetsc.problem import Problem, check_place
from fsipetsc.process.together import libraries, together
from fsipetsc.scheme.observables import SERIES, record
from fsipetsc.scheme.plan import FRACTIONS, NEW_DATA, OFF_GRID, SOLUTION, STAGES, advance, plan_next
from fsipetsc.scheme.recorded_data import Source, asked, forcing_of, found_by, set_time
from fsipetsc.state import State

#: procedures of a layer by name
_GAS = {"fill": ends.fill_ghost, "rates": rates.gas_rates, "complete": rates.complete_gas}
_SOLID = {"close": ends.close_solid, "stretch": rates.stretch, "rates": rates.elastic_rates}
OF_LAYERS = {"fluid": _GAS, "solid": {**_SOLID, "complete": rates.complete_solid}}
#: of data that have no place
ONE_PLACE = np.zeros((1, 1))
#: what is noted of a step: from mass on shares of ranks, at interfaces of the owner of the solid
NOTED = ["t", "dt", "mass", "energy", "momentum"]
NOTED += [name for name, one in SERIES.items() if one.of == "interface"]


class PaperState(State):
    """A run in the paper's method; all methods are collective on ``comm``.

    opt: options in force; announce: told of what is compiled. InputError where grid, order and
    number of ranks do not fit, or the problem is not of the paper's form. bounds: (layers, 2), the
    largest rates of convection and diffusion [1/s].
    """

    def __init__(self, comm: MPI.Comm, problem: Problem, opt: Any, announce: Any) -> None:
        check_form(problem, opt)
        self.comm, self.problem, self.h = comm, problem, opt["fsi_h"]
        self.op = OPERATORS[opt["fsi_order"]]
        gases = [v for v in problem.layers if v.kind == "fluid"]
        counts = {"gas": len(gases), "interface": len(problem.layers) - 1}
        reduced = self._lay_journal(np.dtype(record(NOTED, counts)), 2 * len(problem.layers))
        self.bounds = reduced[self.results.size :].reshape(-1, 2)
        steps = SimpleNamespace(plan=self.plan, results=self.results, bounds=self.bounds)
        steps.latest, steps.gases, steps.time = self.latest_numbers, len(gases), np.zeros(1)
        notes = steps.latest[steps.gases + 2 :].reshape(-1, counts["interface"])
        made = layers_of(comm, problem, opt, self.op, steps)
        self.layers, self._memory, steps.y, steps.total, steps.left = made
        self.parts = {v.number: v for v in self.layers if v.own[0] < v.own[1]}
        self.shapes = [v.local.shape[1:] for v in self.layers]
        self.changing = self._memory, *(v.active for v in self.layers), self.results, self.batch
        self.y = zeros(sum(v.owned.size for v in self.layers))
        self.solution = PETSc.Vec().createWithArray(self.y, comm=comm)
        of = comm.rank, opt["fsi_coupling"], notes
        self.interfaces = [Interface(pair, k, *of) for k, pair in enumerate(pairwise(self.layers))]
        self._rows, self._halos = exchanges_of(comm, self.layers, self.interfaces, self._memory)
        given = [numbers for layer in self.layers for numbers in layer.given]
        given += [one.jump for one in self.interfaces]
        steps.data = () if problem.steady_data else tuple(given)
        self._reduction = Reduction(comm, reduced)
        self._load_procedures(steps, announce)

    def _load_procedures(self, steps: Any, announce: Any) -> None:
        """Make machine code of all procedures; does: name -> those that this rank calls."""
        code, does = Code(EXCHANGES), defaultdict[str, list[Any]](list)

        def add(name: str, number: int, f: Any, of: Any, here: bool = True) -> None:
            does[name] += [code.procedure(f"{name}_{number}", f, of)][: int(here)]

        for k, layer in enumerate(self.layers):
            for name, f in ("begin", rates.begin_step), *OF_LAYERS[layer.layer.kind].items():
                add(name, k, f, layer, here=k in self.parts)
        for k, one in enumerate(self.interfaces):
            add("couple", k, couple, one, here=any(one.here))
            add("note", k, note, one, here=one.here[1])  # the owner of the solid does it
        for f in (rates.forget, rates.finish):
            add(f.__name__, 0, f, steps)
        for n in range(STAGES):
            add("stage", n, partial(advance, n), steps)
        for n in NEW_DATA:
            add("time", n, partial(set_time, FRACTIONS[n]), steps)
        planning = code.procedure("plan_next", plan_next, self.plan)
        self._sources = [*self._of_problem()]
        timed = [] if self.problem.steady_data else [*self._sources, *self._of_forcing()]
        codes = [code, *self._record_data([timed], steps.time)]
        loaded = libraries(self.comm, [one.text for one in codes], announce)
        for one, library in zip(codes, loaded, strict=True):
            one.load(library)
        does["tell"] = [self._reduction] if self.comm.size > 1 else []
        completing = "forget", "complete", "note", "tell", "finish"
        self.phases = {
            "fulfil": [self._rows, *does["couple"], *does["close"], self._halos],
            "begin": [],
            "complete": [one for name in completing for one in does[name]],
            "stretch": does["stretch"],
        }
        for n in range(STAGES):
            # a stage fulfils the conditions but for the ghost point, the completed solution all
            found = [*does["fill" if n > 0 else "begin"], *does["rates"]]
            self.phases |= {f"rates_{n}": found, f"advance_{n}": [*found, does["stage"][n]]}
        for n, of_time in zip(NEW_DATA, does["time"]):
            self.phases[f"data_{n}"] = [of_time, *self._data] if self._data else []
        self._take_calls(code.library, planning, (self._rows, self._halos, self._reduction))

    def vectors(self, n: int) -> tuple[Array, Array]:
        return self._memory, self._memory

    def _frames(self) -> Array:
        """(4, layers) of all ranks: the first and the last active point, and the frame."""
        found = np.full((4, len(self.layers)), -np.inf)
        for k, layer in self.parts.items():
            found[:, k] = *layer.active, *layer.frame
        self.comm.Allreduce(MPI.IN_PLACE, found, MPI.MAX)
        return found

    @property
    def points(self) -> int:
        """The number of active points of all layers. Collective."""
        lo, hi, *_ = self._frames()
        return int((hi - lo + 1).sum())

    def used_up(self) -> str:
        """Which gas has no points left, or too few, and where it is."""
        layer, m = self.layers[int(self.results[OFF_GRID]) - 1], self.problem.unit("m")
        x = self._frames()[-1, layer.number]
        short = f"become too short (the {self.op.name} operator needs {layer.least} points)"
        what = short if abs(x - layer.end_x) < layer.least * layer.h else "used up its points"
        where = f"its interface at x = {x:.6g}{m} and its boundary at x = {layer.end_x:.6g}{m}"
        return f"fluid {layer.layer} has {what}, with {where}"

    def owned(self, k: int) -> Array:
        return self.layers[k].owned.T

    def numbers(self, k: int) -> Array:
        return self.layers[k].numbers

    def fields(self, k: int) -> Sequence[str]:
        return self.problem.layers[k].fields

    def compared(self, kind: str) -> Sequence[str]:
        return {v.kind: v.fields[:-1] for v in self.problem.layers}[kind]  # all but the pressure

    def powers(self, k: int, names: Sequence[str], t: float, power: int) -> Array:
        """As of any state, over active points without ghosts."""
        self._do("stretch", 0)
        layer, own = self.parts[k], self.parts[k].mine
        exact = np.array(layer.layer.values("exact", layer.X[own], t))
        counted = layer.numbers[own] != (layer.ghost if layer.is_gas else -1)
        apart = layer.saved()[own][counted, : len(exact)].T - exact[:, counted]
        return self.h * np.sum(np.abs(apart) ** power, axis=1)

    def grids(self) -> list[Array]:
        return [layer.X[:, None] for layer in self.layers]

    def save(self) -> list[Array]:
        self._do("stretch", 0)
        return [layer.saved() for layer in self.layers]

    def seen(self) -> list[Any]:
        return [layer.seen() for layer in self.parts.values()]

    def _of_problem(self) -> Iterator[Source]:
        """Where data of ends and interfaces go."""

        def given(end: Any, x: Any, t: Any) -> list[Any]:
            at = () if isinstance(t, Symbol) else NOWHERE
            return end.data(lambda name, names: asked(end, name, at, t, names))

        def jump(k: int, x: Any, t: Any) -> Any:
            names = "g_u", "g_stress", "g_T", "g_flux"
            return found_by(self.problem.jumps, (k, t), names, NOWHERE, f"jumps at interface {k}")

        for layer in self.layers:
            for end, to in zip(layer.ends, layer.given, strict=True):
                if end is not None:
                    yield Source(end, partial(given, end), ONE_PLACE, None, *to[:, None])
        for k, one in enumerate(self.interfaces if self.problem.jumps else ()):
            yield Source("jumps", partial(jump, k), ONE_PLACE, None, *one.jump[:, None])

    def _of_forcing(self) -> Iterator[Source]:
        """Where forcing goes, which C fills at all own points."""
        for v in self.parts.values():
            if v.forcing is not None:
                given = "forcing", partial(forcing_of, v.layer), v.X[None], None
                yield Source(*given, *v.forcing[:, slice(*v.own)])

    def refresh(self, t: float) -> None:
        for one in self._sources:
            one.fill(t)
        for v in self.parts.values():
            if v.forcing is not None:
                values = v.layer.values("forcing", v.X[v.mine], t)
                v.forcing[:, slice(*v.own)][:, v.mine] = values

    def set_initial(self, t_end: float | None = None) -> None:
        """Initial data of all layers, projected; all else at t = 0. InputError, on all ranks."""

        def fill() -> None:
            solid = next(v.layer for v in self.layers if not v.is_gas)
            x = solid.values("initial", np.array(solid.X))[3]  # of its ends
            for v in self.parts.values():
                fields = v.layer.values("initial", v.X[v.mine])
                if v.layer.exact is not None:  # what is wrong with it is not found out at the end
                    v.layer.values("exact", v.X[v.mine])
                if v.is_gas:
                    end = v.layer.X[v.side] - v.layer.X[1 - v.side] + x[v.side]
                    check_place(v.layer, v.ends[v.side], end, self.h)
                    rho, u, T = fields
                    with np.errstate(all="ignore"):  # what comes of it is monitored
                        fields = [rho, rho * u, v.material.total_energy(rho, u, T)]
                v.owned[:, v.mine] = fields

        together(self.comm, fill)
        self.show(0)
        together(self.comm, lambda: self.refresh(0.0))  # says what is wrong
        self.set_data(0.0)
        self.finish()

    # steps; all stages are in the same memory

    def load(self, n: int, y: Array) -> None:
        for layer in self.parts.values():
            layer.owned[:] = layer.of(y)

    def unload(self, n: int, y: Array) -> None:
        for layer in self.parts.values():
            layer.of(y)[:] = layer.owned

    def right_hand_side(self, y: Array, f: Array) -> None:
        super().right_hand_side(y, f)
        for layer in self.parts.values():
            layer.of(f)[:] = 0.0
            layer.of(f)[:, layer.mine] = layer.owned[:, layer.mine]

    def show(self, n: int) -> None:
        self.unload(n, self.y)

    def completed(self) -> None:
        super().completed()
        self.show(SOLUTION)

    def begin(self) -> None:
        self._halos()
        self.show(0)

    def more(self) -> Mapping[str, Array]:
        return {"frames": self._frames()}

    def take(self, arrays: Mapping[str, Array]) -> None:
        for k, layer in self.parts.items():
            layer.active[:], layer.frame[:] = arrays["frames"][:, k].reshape(2, 2)
