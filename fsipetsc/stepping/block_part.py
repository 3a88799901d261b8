"""What a rank's parts of gas and solid blocks have in common, and what passes their faces: lists of
nodes and their data, for fsipetsc.scheme.face_terms.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import accumulate, pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.block import mesh
from fsipetsc.blocks.block_problem import BlockFace
from fsipetsc.blocks.conditions import COLUMNS, VECTORS, Condition
from fsipetsc.blocks.face_formulas import Effect
from fsipetsc.blocks.metrics import Curls
from fsipetsc.checks import Array, names_of, place_text
from fsipetsc.errors import InputError
from fsipetsc.kernels.loops import Known, zeros
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.parallel.block_layout import Part
from fsipetsc.scheme.face_terms import Faces, load_face, pass_face
from fsipetsc.scheme.observables import SERIES
from fsipetsc.scheme.recorded_data import Source, asked, forcing_of, found_by
from fsipetsc.scheme.sweep import in_order
from fsipetsc.stepping.saved import fields_of


class BlockPart(Part):
    """One part of a block, which is what its procedures take: see fsipetsc.scheme.part.

    owned, H: (M,) rows in the ghosted array of the nodes that the rank owns, and their H. sources:
    of data that may depend on time. added: whether something adds to the rates of nodes within the
    block, after its sweep. reads_ghosted: whether something but sweeps reads the ghosted array.
    names: of what is saved of a node. code, does: recorded procedures, also by name.

    about: layout of blocks; opt: options in force; particles: all of the problem, system: of those
    here; columns: name -> where a series, or this block's number of it, is in the record of a step;
    found: fsipetsc.scheme.plan; recorded: nodes that each step records. InputError, perhaps on this
    rank alone.
    """

    def __init__(self, part: Part, about: SimpleNamespace) -> None:
        super().__init__(**vars(part))
        self.about, self.problem, self.order = about, about.layout.problem, about.layout.order
        self.block = block = self.problem.blocks[part.k]
        self.d = d = Known(block.dimension)
        self.laws = block.material.equations(d, self.problem.symmetry)
        self.names = fields_of(block.kind, d, self.problem.symmetry)
        self.X = self.problem.positions(part.k, part.ghosted)
        self.owned = part.patch.ghosted_rows(np.arange(part.numbers.size))
        self.H = part.weights(self.owned)
        self.p_ref = _left_out(self.problem, part.k)
        self.sources, self._slips = list[Source](), list[tuple[Array, ...]]()
        self.terms: tuple[Any, ...] = tuple(self._find_faces())
        self.reads_ghosted = bool(self.terms) or part.signs.size > 0
        self.forcing, self.forced, self.moves = None, any(self.laws.force), False
        if block.forcing is not None:
            self.forcing = np.zeros((len(names_of(block.kind, "forcing", d)), self.owned.size))
            given = "forcing", partial(forcing_of, block), self.X[:, self.owned], None
            self.sources.append(Source(*given, *self.forcing))
        # what else procedures take
        reaches, sizes = [band.reach for band in part.bands], part.patch.ghosted
        self.S, self.weight = np.zeros((3, 1 + max(reaches), max(sizes))), np.zeros((3, max(sizes)))
        for k, band in enumerate(part.bands):
            self.S[k, : 1 + band.reach, : sizes[k]], self.weight[k, : sizes[k]] = band
        self.axes = np.array([reaches, sizes, np.cumprod([1, *sizes[:2]])]).T.copy()
        self.per_h, self.loses = np.array(block.cells, float), self.problem.loses(part.k)
        self.column = [other.kind for other in self.problem.blocks[: part.k]].count("fluid")
        number = {"gas": self.column, "layer": part.k}
        columns = {name: c + number.get(SERIES[name].of, 0) for name, c in about.columns.items()}
        self.columns = SimpleNamespace(**columns)
        self.at_particles = about.system.faces_at(part.k)
        self.points = self._recorded(about.recorded) if about.recorded else None

    def add_sources(self, add_force: Any, supply: Any) -> None:
        """Let these functions add a constant force and forcing to rates, if there are any."""
        self.terms += (add_force,) * self.forced + (supply,) * (self.forcing is not None)

    def _recorded(self, nodes: Sequence[Any]) -> Array:
        """(n, 2), numbers and owned rows of the nodes here that are recorded at each step."""
        found = [
            (number, row)
            for number, node in enumerate(nodes)
            if node.block == self.k
            for row in self.rows_among([node.node])
        ]
        return np.array(found, np.int64).reshape(-1, 2)

    # what passes faces

    def _find_faces(self) -> list[Faces]:
        """The faces with a condition, or with jumps, those of one effect together."""
        blocks, acting = self.problem.blocks, _acting(self.problem, self.k)
        alike = [n for n, other in enumerate(blocks) if other.kind == self.block.kind]
        # blocks of one kind have one text, and so do ranks, with nodes or without
        effects = dict.fromkeys(effect for n in alike for *_, effect in _acting(self.problem, n))
        return [self._faces(e, [f for f in acting if f[3] == e]) for e in effects if acting]

    def _faces(self, effect: Effect, acting: Sequence[Any]) -> Faces:
        """The nodes of faces of one effect, and the sources of their data."""
        gas, turned = self.block.kind == "fluid", list[Any]()
        nodes, counts = self.nodes_of([face[:2] for face in acting])
        n = nodes["own"].size
        data = dict(zip(("pressure", "heat", "stress", "width", "slip"), np.zeros((5, n))))
        data |= dict(zip(("traction", "normal"), np.zeros((2, n, self.d))))
        data["outside"] = np.zeros((n, self.d + 2))
        faces = Faces(**nodes, **data, effect=effect, add_node=pass_face if gas else load_face)
        ends = pairwise(accumulate(counts, initial=0))
        for (axis, side, condition, _), (begin, end) in zip(acting, ends, strict=True):
            rows = np.arange(begin, end)
            if self.d == 3 and not gas:
                turned.append(self._turned(axis, side, begin, end))
            numbers = self.numbers[faces.own[rows]]
            X = self.problem.places(self.k, numbers)
            self._take(faces, condition, X, rows)
            if getattr(condition, "slip_length", None) is not None:
                step = int(np.prod(self.block.shape[:axis])) * (-1 if side else 1)
                beside = np.linalg.norm(X - self.problem.places(self.k, numbers + step), axis=1)
                self._slips.append((X, faces.slip[begin:end], beside))
            if effect.first_order:
                low, high = (self.block.face_positions(axis, at) for at in (0, 1))
                faces.width[rows] = np.linalg.norm(high - low, axis=0).mean()
        faces.turned = tuple(turned)
        return faces

    def nodes_of(self, faces: Sequence[tuple[int, int]]) -> tuple[dict[str, Array], list[int]]:
        """What fsipetsc.scheme.face_terms takes of faces (axis, side), without data; nodes each."""
        rows, own = [], [self.rows_among(self.block.face_nodes(*face)) for face in faces]
        for axis, side in faces:
            last = self.patch.first[axis] + (self.patch.own[axis] - 1 if side else 0)
            weight = float(self.bands[axis].weight[last])
            column = self.problem.column((self.k, axis, side))
            rows.append((axis, 1.0 if side else -1.0, weight, column))
        of_all, counts = np.concatenate([np.zeros(0, int), *own]), [nodes.size for nodes in own]
        axes, sign, weights, columns = np.repeat(np.array(rows).reshape(-1, 4).T, counts, axis=1)
        at = self.patch.ghosted_rows(of_all)
        found = {"at": at, "own": of_all, "axis": axes.astype(int), "sign": sign}
        found |= {"per_weight": 1.0 / weights, "across": self.weights(at) / weights}
        return {**found, "column": columns.astype(int)}, counts

    def _take(self, faces: Faces, condition: Any, X: Array, rows: Array) -> None:
        """Take the data of a face, with nodes here or without.

        In three dimensions, and around an axis or a centre, the pressure p_ref under which a solid
        is free of strain is no part of its stress: -p_ref cof F would not be at rest with a gas.
        Nor is it part of the stress of a law of a case. Faces to gas, and those with a traction of
        their own, get p_ref n(x) instead; in three dimensions n is in the curl form of the gas.
        """
        met = isinstance(condition, BlockFace)  # of a solid
        less = self.p_ref if met or condition.loaded else 0.0
        faces.pressure[rows] = 0.0 - less
        if met and self.problem.jumps is not None:
            to = faces.traction, faces.heat
            self.sources.append(Source("jumps", self._supplied, X.T, rows, *to))
        for column, names in COLUMNS.items():
            if getattr(condition, names[0], None) is not None:
                make = partial(_column, condition, names, less if column == "pressure" else 0.0)
                self.sources.append(Source(condition, make, X.T, rows, getattr(faces, column)))

    def _supplied(self, x: Any, t: Any) -> tuple[Any, Any]:
        """Traction and heat that a solid gets from outside at interfaces, of numbers or symbols."""
        names = *(f"traction along {x}" for x in "xyz"[: self.d]), "heat"
        *traction, heat = found_by(self.problem.jumps, (*x, t), names, x, "jumps")
        return tuple(traction), heat

    def _turned(self, axis: int, side: int, begin: int, end: int) -> Any:
        """A face of a solid in three dimensions, perhaps without nodes here."""
        shape, ghosted = self.block.shape, self.ghosted
        sizes = zip(ghosted, self.patch.first, self.patch.own, strict=True)
        where = [(low + first, low + first + own) for (low, _), first, own in sizes]
        where[axis] = (shape[axis] - 1, shape[axis]) if side else (0, 1)
        curls = Curls(self.problem, self.k, self.order, where, [(axis, 0)])
        index = [np.arange(*ends) - low for ends, (low, _) in zip(curls.wide, ghosted)]
        at = np.ravel_multi_index(mesh(index), self.patch.ghosted, "clip", "F").ravel()
        areas, x = np.zeros((9, curls.N)), zeros(curls.y.shape)
        of_wide = {"curls": curls, "x": x, "y": curls.y, "at": at, "areas": areas}
        of_face = {"row": 3 * axis, "begin": begin, "nodes": end - begin}
        return SimpleNamespace(**of_wide, **of_face, sign=1.0 if side else -1.0)

    def refresh(self, t: float) -> None:
        """Data of faces and forcing at t [s]. InputError, also for slip lengths below a cell."""
        for one in self.sources:
            one.fill(t)
        for X, length, spacing in self._slips:
            for n in np.flatnonzero(~(length >= spacing))[:1]:
                where = f"slip_length of NoSlip at t = {t:.6g} is {length[n]:.4g}"
                wanted = f"the distance {spacing[n]:.4g} of the nodes beside the wall, or more"
                raise InputError(f"{where} at {place_text(X[n])}: expected {wanted}")

    @np.errstate(all="ignore")  # start values that are far too large are told later
    def begin_as_held(self, q: Array, obeying: Array) -> None:
        """What is held from outside gets the velocities that obey; its rho and T stay."""
        _, nodes, particle = self.about.system.own(self.k)
        rows = self.rows(nodes[self.about.system.record.facts.held[particle] == 1])
        gas, d, of, new = self.block.kind == "fluid", self.d, q[rows], obeying[rows]
        u, E = (slice(2, 2 + d), 2 + d) if gas else (slice(d, 2 * d), 2 * d)
        mass, new_mass = (of[:, 1:2], new[:, 1:2]) if gas else (1.0, 1.0)
        moved = mass * new[:, u] / new_mass
        change = 0.5 * ((moved**2 - of[:, u] ** 2) / mass).sum(axis=1)
        matters = np.abs(change) > 1e-13 * np.abs(of[:, E])  # else it is round-off
        of[:, u], of[:, E] = moved, of[:, E] + change
        q[rows[matters]] = of[matters]

    # what is recorded

    def kernels_of(self, make: Callable[..., Any], *given: Any) -> Any:
        """The kernels that make(laws, d, *given) returns, once for all blocks of a material."""
        known, key = self.about.layout.kernels, (id(self.block.material), *given)
        if key not in known:
            known[key] = make(self.laws, self.d, *given)
        return known[key]

    @property
    def inner(self) -> list[tuple[int, int]]:
        """(first, first beyond), along each ghosted axis, of owned nodes that sweeps complete."""
        found = []
        for axis, (first, n) in enumerate(zip(self.patch.first, self.patch.own, strict=True)):
            begin, end = first, first + (0 if self.added else n)
            if axis < self.d and not self.block.periodic[axis]:
                at = self.ghosted[axis][0] + first
                begin, end = begin + (at == 0), end - (at + n == self.block.shape[axis])
            found.append((begin, max(begin, end)))
        return found

    def _record(self, functions: Sequence[Any], of_grid: Mapping[str, Any]) -> None:
        """Record functions. They take what their parameters name; methods of a grid it as self."""
        self.free, found = in_order(self.inner, self.d), self.about.found
        self.code, self.does = Code(f"#define ROW {self.volume.width}\n"), dict[str, Procedure]()
        takes = {"part": self, "record": self.about.system.record, **of_grid}
        takes |= {"gain": found.gain, "found": found}
        for f in functions:
            given = [takes[p] for p in inspect.signature(f).parameters if p in takes]
            self.does[f.__name__] = self.code.procedure(f"part_{f.__name__}", f, *given)


def _left_out(problem: Any, k: int) -> float:
    """p_ref of a block where it is no part of the stress."""
    block = problem.blocks[k]
    if block.kind == "fluid":
        return 0.0
    left_out = block.dimension == 3 or problem.symmetry or not isinstance(block.material.law, str)
    return float(block.material.p_ref) if left_out else 0.0


def _column(condition: Condition, names: Sequence[str], less: float, x: Any, t: Any) -> Any:
    """The data of a condition, side by side if there are several, less a number."""
    found: list[Any] = []
    for name in names:
        several = "uvw"[: len(x)] if name in VECTORS else ""
        value = asked(condition, name, x, t, several)
        found += [*value] if several else [value]
    return (tuple(found),) if len(found) > 1 else (found[0] - less,)


def _acting(problem: Any, k: int) -> list[tuple[int, int, Any, Effect]]:
    """Axis, side, what stands there and what it adds to rates, of faces of block k where it does;
    of interfaces where a solid gets something from outside, and faces that p_ref loads, too.
    """
    found, p_ref, solid = [], _left_out(problem, k), problem.blocks[k].kind == "solid"
    for (axis, side), condition in problem.kinds[k].items():
        met = isinstance(condition, BlockFace)
        to_gas = met and problem.blocks[condition.block].kind == "fluid"
        supplied = to_gas and solid and problem.jumps is not None
        beyond = _left_out(problem, condition.block) if met else 0.0
        pressed = (met or condition.loaded) and p_ref not in (0.0, beyond)
        effect = None if met else condition.effect
        if effect is None and (supplied or pressed):
            effect = Effect(Condition)
        if effect is not None:
            found.append((axis, side, condition, effect))
    return found
