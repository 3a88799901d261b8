"""What a rank's parts of gas and solid blocks have in common, and what passes their faces: lists of
nodes and their data, for fsipetsc.scheme.faces.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.saved import fields_of
from fsipetsc.blocks.block_problem import Meeting
from fsipetsc.blocks.conditions import COLUMNS, VECTORS, Condition
from fsipetsc.blocks.face_formulas import Effect
from fsipetsc.blocks.metrics import Wide, cube_of
from fsipetsc.checks import block_values, checked, place_text
from fsipetsc.errors import InputError
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.kernels.symbols import Symbol, numbers_of
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.scheme.faces import Faces, load_face, pass_face
from fsipetsc.scheme.recorded_data import Source, asked, positive
from fsipetsc.scheme.sweep import in_order

Array = NDArray[Any]
#: data that must be above 0
ABOVE_0 = "rho", "T", "slip_length"


class FaceTerms:
    """Terms of the faces of one part of a block that have a condition, or interfaces with jumps.

    X: (d, ghosted nodes) places in the reference map. record: for procedures, once its sources have
    filled it.

    In three dimensions, and around an axis or a centre, the pressure p_ref under which a solid is
    free of strain is no part of its stress: -p_ref cof F would not be at rest with a gas. Nor is it
    part of the stress of a law of a case. Faces to gas, and those with a traction of their own, get
    p_ref n(x) instead; in three dimensions n is in the curl form that the gas has.
    """

    def __init__(self, problem: Any, part: Part, order: int, X: Array) -> None:
        k, d, self._jumps = part.k, problem.dimension, problem.jumps
        block = problem.blocks[k]
        self._d, self._gas, self.p_ref = d, block.kind == "fluid", _left_out(problem, k)
        self.sources, self._slips = list[Source](), list[tuple[Array, slice, Array]]()
        self.record: Any = None
        alike = [n for n, other in enumerate(problem.blocks) if other.kind == block.kind]
        # blocks of one kind have one text
        effects = list(dict.fromkeys(effect for n in alike for *_, effect in _acting(problem, n)))
        acting = sorted(_acting(problem, k), key=lambda face: effects.index(face[3]))
        if not acting:  # on all ranks of the block, for these record the same
            return
        listed = [nodes_of(problem, part, axis, side) for axis, side, *_ in acting]
        nodes = [np.concatenate(values) for values in zip(*listed, strict=True)]
        ends = np.cumsum([0, *(own.size for _, own, *_ in listed)]).tolist()
        places = [slice(*pair) for pair in pairwise(ends)]
        groups, n = [], ends[-1]
        for effect in effects:  # whose nodes lie together
            of = [at for at, face in zip(places, acting, strict=True) if face[3] == effect]
            begin, end = (of[0].start, of[-1].stop) if of else (0, 0)
            groups.append(SimpleNamespace(effect=effect, begin=begin, nodes=end - begin))
        names = "at", "own", "axis", "sign", "per_weight", "across", "column"
        of_both: dict[str, Any] = dict(zip(names, nodes, strict=True), groups=tuple(groups))
        of_both["pressure"], of_both["heat"], more = np.zeros((3, n))
        if self._gas:
            own = {"outside": np.zeros((n, d + 2)), "width": more, "add_node": pass_face}
        else:
            traction, normal = np.zeros((2, n, d))
            own = {"traction": traction, "normal": normal, "stress": more, "add_node": load_face}
        self.record = Faces(**of_both, **own, turned=())
        turned = []
        for (axis, side, condition, effect), where in zip(acting, places, strict=True):
            if d == 3 and not self._gas:
                turned.append(_turned(problem, part, order, axis, side, where))
            own, X = nodes[1][where], problem.places(k, part.numbers[nodes[1][where]])
            self._take(condition, X, where)
            if not isinstance(condition, Meeting) and condition.slip_length is not None:
                step = int(np.prod(block.shape[:axis])) * (-1 if side else 1)
                beside = problem.places(k, part.numbers[own] + step)
                self._slips.append((X, where, np.linalg.norm(X - beside, axis=1)))
            if effect.first_order:
                low, high = (block.face_positions(axis, at) for at in (0, 1))
                self.record.width[where] = np.linalg.norm(high - low, axis=0).mean()
        if turned:
            self._cubes, faces = zip(*turned)  # what addresses of the faces point to
            self.record.turned = faces

    def _take(self, condition: Any, X: Array, at: slice) -> None:
        """Take the data of a face, with nodes here or without, of which p_ref is a part."""
        rows, record = np.arange(at.start, at.stop), self.record
        supplied = isinstance(condition, Meeting)
        if not self._gas and (supplied or condition.loaded):
            record.pressure[at] = 0.0 - self.p_ref
        if supplied and not self._gas and self._jumps is not None:
            to = record.traction, record.heat
            self.sources.append(Source(condition, self._supplied, X.T, rows, *to))
        for column, names in () if supplied else COLUMNS.items():
            if getattr(condition, names[0], None) is not None:
                less = self.p_ref if column == "pressure" and condition.loaded else 0.0
                make = partial(_column, condition, names, less)
                self.sources.append(Source(condition, make, X.T, rows, getattr(record, column)))

    def _supplied(self, x: Any, t: Any) -> tuple[Any, Any]:
        """Traction and heat that a solid gets from outside at interfaces, of numbers or symbols."""
        if isinstance(t, Symbol):
            *traction, heat = numbers_of(self._jumps(*x, t), self._d + 1)
        else:
            names = *(f"traction along {x}" for x in "xyz"[: self._d]), "heat"
            *traction, heat = checked(self._jumps, (*x, t), x, names, f"jumps at t = {t:.6g}")
        return tuple(traction), heat

    def check(self, t: float) -> None:
        """InputError where a slip length is shorter than a cell, which no step resolves."""
        for X, at, spacing in self._slips:
            length = self.record.width[at]
            for n in np.flatnonzero(~(length >= spacing))[:1]:
                where = f"slip_length of NoSlip at t = {t:.6g} is {length[n]:.4g}"
                wanted = f"the distance {spacing[n]:.4g} of the nodes beside the wall, or more"
                raise InputError(f"{where} at {place_text(X[n])}: expected {wanted}")


def _turned(problem: Any, part: Part, order: int, axis: int, side: int, nodes: slice) -> Any:
    """A face of a solid in three dimensions, of which this rank may have no nodes, and its cube."""
    shape, ghosted = problem.blocks[part.k].shape, part.ghosted
    sizes = zip(ghosted, part.patch.first, part.patch.own, strict=True)
    where = [(begin + first, begin + first + own) for (begin, _), first, own in sizes]
    where[axis] = (shape[axis] - 1, shape[axis]) if side else (0, 1)
    wide = Wide(problem, part.k, order, where)
    index = [
        np.clip(np.arange(*ends) - begin, 0, end - begin - 1)
        for ends, (begin, end) in zip(wide.wide, ghosted, strict=True)
    ]
    places = np.meshgrid(*index, indexing="ij")
    at = np.ravel_multi_index(places, part.patch.ghosted, order="F").ravel(order="F")
    areas = np.zeros((9, int(np.prod([end - begin for begin, end in where]))))
    address, kept = cube_of(wide, [(axis, 0)])
    of_cube = {"address": address, "x": wide.y.copy(), "y": wide.y, "at": at, "areas": areas}
    of_face = {"row": 3 * axis, "begin": nodes.start, "nodes": nodes.stop - nodes.start}
    return kept, SimpleNamespace(**of_cube, **of_face, sign=1.0 if side else -1.0)


def _left_out(problem: Any, k: int) -> float:
    """p_ref of a block where it is no part of the stress."""
    block = problem.blocks[k]
    if block.kind == "fluid":
        return 0.0
    left_out = block.dimension == 3 or problem.symmetry or not isinstance(block.material.law, str)
    return float(block.material.p_ref) if left_out else 0.0


def _column(condition: Condition, names: Sequence[str], less: float, x: Any, t: Any) -> Any:
    """The data of a condition, side by side if there are several, less a number; of symbols what
    must be above 0 and is not is no number.
    """
    found: list[Any] = []
    for name in names:
        several = "uvw"[: len(x)] if name in VECTORS else ""
        value = asked(condition, name, x, t, several)
        if name in ABOVE_0:
            value = positive(value)
        found += [*value] if several else [value]
    return (tuple(found),) if len(found) > 1 else (found[0] - less,)


def nodes_of(problem: Any, part: Part, axis: int, side: int) -> tuple[Array, ...]:
    """This rank's nodes of those of a face: numbers in the ghosted array and among the owned ones,
    axis, sign, 1 / weight of the axis, product of the other weights, column of its energy.
    """
    nodes, through = problem.blocks[part.k].face_nodes(axis, side), problem.column_of_face
    own = part.rows_among(nodes)
    at = part.patch.ghosted_rows(own)
    last = part.patch.first[axis] + (part.patch.own[axis] - 1 if side else 0)
    weight, ones = float(part.bands[axis].weight[last]), np.ones(own.size)
    column = np.full(own.size, through.get((part.k, axis, side), len(through)))
    signs, across = ones if side else -ones, part.weights(at) / weight
    return at, own, np.full(own.size, axis), signs, ones / weight, across, column


def _acting(problem: Any, k: int) -> list[tuple[int, int, Any, Effect]]:
    """Axis, side, what stands there and what it adds to rates, of faces of block k where it does.

    Also interfaces where a solid gets something from outside, and faces that p_ref loads.
    """
    found, p_ref, solid = [], _left_out(problem, k), problem.blocks[k].kind == "solid"
    for (axis, side), condition in problem.kinds[k].items():
        met = isinstance(condition, Meeting)
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


class BlockPart:
    """One part of a block. does: name -> procedure.

    X: (d, ghosted nodes) places in the reference map. owned, weights: (M,) rows there of the nodes
    that the rank owns, and their H. names: of what is saved of a node. sources: of data that may
    depend on time. at_particles: faces at constraints, known once there are particles. added:
    whether something adds to the rates of nodes within the block, after its sweep. reads_ghosted:
    whether something but sweeps reads the ghosted array.
    """

    added: bool
    adds: tuple[Any, ...] = ()  # functions and records that add to rates after the sweep
    dissipation: tuple[Any, ...] = ()
    metrics: Array
    at_particles: Any
    equations: Any
    add_force: Any  # functions that add to rates: a constant force, forcing
    supply: Any
    _record: Any  # (system, begins) -> the text of its kernels, its record, what becomes procedures

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        self.part, self._layout, self._problem = part, layout, layout.problem
        self.block, self._order, self._form = self._problem.blocks[part.k], order, form
        self._d = d = self.block.dimension
        self.names = fields_of(self.block.kind, d, self._problem.symmetry)
        self.X = self._problem.positions(part.k, part.ghosted)
        self.owned = part.patch.ghosted_rows(np.arange(part.numbers.size))
        self.weights = part.weights(self.owned)
        self.faces = FaceTerms(self._problem, part, order, self.X)
        self.sources, self.forcing = self.faces.sources, None
        self.reads_ghosted = self.faces.record is not None
        if self.block.forcing is not None:
            rows, x = d + 2 if self.block.kind == "fluid" else 2 * d + 1, self.X[:, self.owned]
            self.forcing = np.zeros((rows, self.owned.size))
            self.sources.append(Source("forcing", self._forced, x, None, *self.forcing))

    def _forced(self, x: Any, t: Any) -> Any:
        """The forcing, of numbers or symbols."""
        if isinstance(t, Symbol):
            return numbers_of(self.block.forcing(*x, t), len(self.forcing))
        return block_values(self.block, "forcing", x, t)

    @property
    def free(self) -> list[tuple[int, int]]:
        """First node and first beyond along each axis of the ghosted array, of the owned nodes to
        whose rates nothing is added after a sweep: none of them is on a face of the block.
        """
        patch, found = self.part.patch, []
        for axis, (first, n) in enumerate(zip(patch.first, patch.own, strict=True)):
            begin, end = first, first + (0 if self.added else n)
            if axis < self._d and not self.block.periodic[axis]:
                at = self.part.ghosted[axis][0] + first
                begin, end = begin + (at == 0), end - (at + n == self.block.shape[axis])
            found.append((begin, max(begin, end)))
        return found

    def refresh(self, t: float) -> None:
        """Data of faces and of the forcing at time t [s]. InputError."""
        for one in self.sources:
            one.fill(t)
        self.faces.check(t)

    def record(self, system: Any, found: Any, begins: Mapping[str, int]) -> Code:
        """Record the procedures of this part. InputError, perhaps on this rank alone.

        system: of particles; found: see fsipetsc.scheme.plan; begins: name -> where a series
        begins in the record of a step.
        """
        text, record, functions = self._record(system, begins)
        code, self.does = Code(text), dict[str, Procedure]()
        takes = {"particles": system.record, "gain": found.gain, "found": found}
        for f in functions:  # they take what their parameters name
            beside = [takes[p] for p in inspect.signature(f).parameters if p in takes]
            self.does[f.__name__] = code.procedure(f"part_{f.__name__}", f, record, *beside)
        return code

    def _common(self, begins: Mapping[str, int]) -> dict[str, Any]:
        part, d, sizes = self.part, self._d, self.part.patch.ghosted
        reaches, forced = [band.reach for band in part.bands], any(self.equations.force)
        S, weight = np.zeros((3, 1 + max(reaches), max(sizes))), np.zeros((3, max(sizes)))
        for k, band in enumerate(part.bands):
            S[k, : 1 + band.reach, : sizes[k]], weight[k, : sizes[k]] = band
        before = self.adds + self.dissipation + (self.faces.record,) * bool(self.faces.record)
        after = (self.add_force,) * forced + (self.supply,) * (self.forcing is not None)
        return {
            "like": (0.0,) * d,
            "free": in_order(self.free, d),
            "terms": before + after,
            "forced": forced,
            "loses": self._problem.loses(part.k),
            "block": part.k,
            "begin": part.begin,
            "dof": part.dof,
            "halo": part.local if part.has_halo else np.empty((part.dof, 0)),
            "signs": part.signs,
            "X": self.X,
            "metrics": self.metrics,
            "S": S,
            "weight": weight,
            "axes": np.array([reaches, sizes, np.cumprod([1, *sizes[:2]])]).T.copy(),
            "patch": part.patch,
            "per_h": np.array(self.block.cells, float),
            "at_particles": self.at_particles,
            "forcing": self.forcing,
            "columns": SimpleNamespace(**begins),
        }
