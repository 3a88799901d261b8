"""Layers and their grids: what a rank has of them, and what procedures take.

A layer has planes, one unknown of all points after the other: gas rho, rho u, e; solid u, sigma, T,
x. Some points of a gas are held in reserve, on its outer side. All ranks have memory for all points
of all layers, so that a number has the same place on each of them.
"""

from collections.abc import Mapping
from math import prod
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.boundaries import Wall
from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.kernels.loops import zeros
from fsipetsc.operators.sbp import SBPOperator, row_length
from fsipetsc.paper.ends import OF_GAS
from fsipetsc.paper.rates import SCRATCH_ROWS, Gas
from fsipetsc.paper.stencils import halo_of_rates
from fsipetsc.parallel.block_shares import Extent, Share, share_out
from fsipetsc.parallel.exchange import RowExchange
from fsipetsc.problem import Problem
from fsipetsc.scheme.monitor import ROOM_COLUMNS

#: points by which a gas may grow, beside an eighth of its own
SPARE = 16
#: what the paper's method has of options that choose between methods
HAS = {
    "fsi_mapping": ("auto", "rigid"),
    "fsi_dissipation": (0.0, -1.0),
    "fsi_shock": (0.0,),
    "fsi_convection": ("auto", "divergence"),
    "fsi_probes": (None, ""),
}


def check_form(problem: Problem, opt: Mapping[str, Any]) -> None:
    """InputError for options in force, or for a problem, that the paper's method does not have."""
    kinds = [layer.kind for layer in problem.layers]
    walls = [end for end in (problem.left, problem.right) if isinstance(end, Wall)]
    for name, values in HAS.items():
        if opt[name] not in values:
            known = " or ".join(str(value) for value in values if value not in (None, ""))
            wanted = f"expected {known or 'nothing'} with the paper's couplings"
            raise InputError(f"-{name} {opt[name]}: {wanted}; or take -fsi_coupling conservative")
    found = ["layers have cells"] * any(layer.cells for layer in problem.layers)
    found += ["layers are " + ", ".join(kinds)] * (len(kinds) == 1 or kinds.count("solid") != 1)
    found += ["a wall moves, or has heat"] * any(wall.moves or wall.heated for wall in walls)
    if found:
        raise InputError(
            f"{found[0]}: the paper's couplings are of one solid beside gases in rigid frames, on "
            "grids of one spacing, with insulated walls at rest: take -fsi_coupling conservative"
        )


def grid_of(problem: Problem, k: int, op: SBPOperator, h: float) -> tuple[int, int, int, int]:
    """Points of layer k, the first and the last active one, and how many of these it needs; a gas
    may grow by a third, or by an eighth and SPARE points. InputError where h does not fit the solid
    or a layer is too short for the closures.
    """
    layer = problem.layers[k]
    cells, room, least = layer.fitting(h), 0, max(4, op.min_points)
    if layer.kind == "fluid":
        # the ghost point is the first one at or beyond the boundary
        cells = int(np.ceil((layer.X[1] - layer.X[0]) / h - 1e-9))
        degree = (problem.left if k == 0 else problem.right).degree or op.p + 1
        room = max(SPARE + max(1, cells // 8), cells // 3)
        # the treatment of the interface must not change the points of a boundary's formulas; a
        # new point takes one more than the degree of its extrapolation
        nodes = max(degree, *(end.new + 1 for end in OF_GAS.values()))
        least = max(op.min_points, nodes + 2, degree + 1 + row_length(op))
    if cells + 1 < least:
        raise InputError(
            f"{layer} has {cells + 1} points with -fsi_h {h:g}; the {op.name} operator "
            f"(-fsi_order {op.order}) needs {least}: take a smaller -fsi_h or a lower order"
        )
    first = room if k == 0 else 0
    return cells + 1 + room, first, first + cells, least


class Layer(SimpleNamespace):
    """A layer and all of its points, of which a rank owns those from own[0] to below own[1]. What
    is at others than these and their halos is never used.

    layer: as the case has it, which is number ``number``. ends: what stands at the left and the
    right end, None at an interface; end, end_x: formulas and place of that of a gas; given: (2, 5),
    data of both (fsipetsc.boundaries). material: as formulas; gamma of a gas. closure: of op, as
    numbers: of the points near an end the norm, then the rows of h D. narrow: with narrow second
    derivatives. least: active points that it needs. share: of all ranks. at, begin: of its numbers
    in the memory of all layers, and in this rank's part of a solution.

    active: the first and the last active point: in a gas interface point and ghost point. frame:
    velocity of the grid, that of the interface point, and x of the interface. local, y, forcing:
    (unknowns, points) the stage, the solution before the step, and what is added to rates, if
    anything; runs: see fsipetsc.scheme.plan.advance. steps: of fsipetsc.paper.rates.

    Of the own points: numbers, X, and owned, (unknowns, points), a view of the stage.
    """

    @property
    def side(self) -> int:
        """Where the boundary of a gas stands: 0 left, 1 right."""
        return 1 if self.ends[0] is None else 0

    @property
    def ghost(self) -> Any:
        """The point of a gas at or beyond its boundary."""
        return self.active[self.side]

    @property
    def cells(self) -> Any:
        return self.active[1] - self.active[0]

    @property
    def span(self) -> tuple[Any, ...]:
        """(a, b, A, B), see fsipetsc.paper.stencils: this rank's own active points."""
        (begin, end), (A, B) = self.own, (self.active[side] for side in (0, 1))
        return np.maximum(begin, A), np.minimum(end, B + 1), A, B

    def places(self, points: Array) -> Array:
        """Where the unknowns of points are in the memory of all layers."""
        dof, size = self.local.shape
        return (self.at + size * np.arange(dof)[:, None] + points).ravel()

    # this rank's own points

    def of(self, array: Array) -> Array:
        """What is ``owned``, in this rank's part of a solution."""
        return array[self.begin :][: self.owned.size].reshape(self.owned.shape)

    @property
    def mine(self) -> slice:
        """The active ones among them."""
        begin, (lo, hi) = self.own[0], self.active.tolist()
        return slice(max(lo - begin, 0), max(hi + 1 - begin, 0))

    @np.errstate(all="ignore")
    def saved(self) -> Array:
        """(points, 5): of a gas rho, u, T, p, x, NaN if inactive; of a solid u, sigma, T, x, p."""
        out, own = np.full((5, len(self.X)), np.nan), self.mine
        if self.is_gas:
            rho, m, e = self.owned[:, own]
            u, T = self.material.velocity_and_temperature(rho, m, e)
            x = self.X[own] - self.layer.X[1 - self.side] + self.frame[1]
            out[:, own] = rho, u, T, self.material.law.pressure(rho, T), x
        else:
            x_X = self.scratch[0, slice(*self.own)] / self.h
            out[:4], out[4] = self.owned, self.material.pressure(self.owned[2], x_X)
        return np.ascontiguousarray(out.T)

    @np.errstate(all="ignore")
    def seen(self) -> tuple[Any, ...]:
        own = self.mine
        if self.is_gas:
            rho, u, T, _, x = self.saved()[own].T
            values = {"rho": rho, "u": u, "T": T}
        else:
            u, sigma, T, x = self.owned
            # by the next point, as it is monitored
            after = np.append(self.local[3, self.own[0] + 1 :], x[-1:] + self.h)[: len(x)]
            x_X = (after - x) / self.h
            p = self.material.pressure(T, x_X)
            values = {"x": x, "x_X": x_X, "u": u, "sigma": sigma, "T": T}
            known = T, p, np.minimum(sigma, p), x_X
            values["m0 c^2 of waves"] = self.material.wave_modulus(*known)
        return self.number, self.numbers[own], values, x[:, None], self.X[own, None]


def layers_of(comm, problem, opt, op, steps):
    """All layers, on each rank; memory of all frames and the stage, and in the same places of the
    solution before the step and of the sum of its stages; runs of all layers. InputError.
    """
    halo, h = halo_of_rates(op), opt["fsi_h"]
    closure = np.column_stack([op.norm, op.closure]).astype(float)
    narrow = opt["fsi_viscous"] == "narrow"
    grids = [grid_of(problem, k, op, h) for k in range(len(problem.layers))]
    least = max(halo, op.rows + 1)
    of_layers = zip(problem.layers, grids, strict=True)
    # active points alone are work; the outermost rank of a gas has those in reserve
    extents = [Extent(v.kind, (hi - lo + 1,), (least,), least) for v, (_, lo, hi, _) in of_layers]
    shares = share_out(extents, comm.size, opt["fsi_partition"])
    shapes = [(len(v.fields) - 1, size) for v, (size, *_) in zip(problem.layers, grids)]
    at = np.cumsum([2 * len(grids), *map(prod, shapes)]).tolist()
    planes, runs = zeros((3, at[-1])), np.zeros((sum(dof for dof, _ in shapes), 2), np.int64)
    found, begin = [], 0
    for k, (layer, shape, share) in enumerate(zip(problem.layers, shapes, shares, strict=True)):
        (size, lo, hi, needed), material = grids[k], layer.material
        cuts = (0, *(cut + lo for cut in share.cuts[0][1:-1]), size)
        v = Layer(layer=layer, number=k, h=h, op=op, closure=closure, narrow=narrow, steps=steps)
        v.is_gas, v.least, v.share = layer.kind == "fluid", needed, Share(share.ranks, (cuts,))
        v.ends, v.given = problem.ends(k), np.zeros((2, 5))
        end = v.ends[v.side]
        v.end, v.end_x = OF_GAS.get(type(end)), getattr(end, "x", 0.0)
        v.material = Gas(*material.equations(1)) if v.is_gas else material.elastic
        v.gamma = getattr(material, "gamma", 0.0)
        v.own = v.share.part(comm.rank)[0] if comm.rank in share.ranks else (0, 0)
        v.at, v.begin, v.active = at[k], begin, np.array([lo, hi])
        v.frame = planes[0, 2 * k : 2 * k + 2]
        v.local, v.y = (of[at[k] : at[k + 1]].reshape(shape) for of in planes[:2])
        v.numbers, v.owned = np.arange(*v.own), v.local[:, slice(*v.own)]
        v.runs = runs[sum(dof for dof, _ in shapes[:k]) :][: len(v.local)]
        v.forcing = np.zeros(shape) if layer.forcing is not None else None
        v.scratch = np.zeros((SCRATCH_ROWS, max(size + halo, ROOM_COLUMNS)))
        at_right = v.is_gas and k == 0  # X are counted from the interface
        v.X = layer.X[at_right] + (v.numbers - hi * at_right) * h
        found.append(v)
        begin += v.owned.size
    return found, *planes, runs


def exchanges_of(comm, layers, interfaces, memory):
    """What ranks tell each other: rows at interfaces; halos, and of a gas its frame, (4.20)."""
    owners, (rows, halos) = np.zeros(memory.size, int), np.zeros((2, comm.size, memory.size), bool)
    for layer in layers:
        share, halo, k = layer.share, halo_of_rates(layer.op), 2 * layer.number
        points = np.arange(layer.local.shape[1])
        owners[layer.places(points)] = np.tile(share.owners(points), len(layer.local))
        owners[k : k + 2] = share.ranks[layer.side - 1]
        for rank in share.ranks:
            ((begin, end),) = share.part(rank)
            halos[rank, layer.places(points[max(begin - halo, 0) : end + halo])] = True
            halos[rank, k : k + 2] = layer.is_gas
    for one in interfaces:
        rows[np.ix_(one.ranks, one.places)] = True
    of_tags, table = enumerate([rows, halos]), memory[:, None]
    return [RowExchange(comm, tag, owners, dict(enumerate(of)), table) for tag, of in of_tags]
