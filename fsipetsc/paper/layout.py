"""Who owns which points: grids, and a DMDA for each layer on a communicator of the ranks that have
a part of it.

The solution is one world vector; its part on a rank is the concatenation of the rank's parts of the
layers, each interlaced (gas rho, rho u, e; solid u, sigma, T, x).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.boundaries import INTERFACE_END, Wall, degree_of, heat_of, needs_stretching
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import SBPOperator, row_length
from fsipetsc.paper.ends import nodes_needed
from fsipetsc.paper.sums import SEEN, SHARES
from fsipetsc.parallel.block_shares import share_line
from fsipetsc.problem import FluidLayer, Problem

Array = np.ndarray
#: kind of layer -> unknowns of a point
DOF = {"fluid": 3, "solid": 4}
#: cells of a layer, with the spare ones: the unknowns of a few such layers can still be counted in
#: 32 bits
MOST_CELLS = 50_000_000

_I, _F = np.int64, np.float64
#: What compiled code knows of a layer: which points there are, whose they are, how the frame moves,
#: what stands at the outer end.
RECORD = np.dtype(
    [
        ("number", _I),  # of the layer, from the left
        ("fluid", _I),  # 1 of a gas
        ("present", _I),  # 1: this rank owns points of the layer
        ("n", _I),  # points, some of them held in reserve,
        ("lo", _I),  # the first and the last active one: in a gas interface point and ghost point
        ("hi", _I),
        ("least", _I),  # active points that the operator and the end conditions need
        ("own_lo", _I),  # this rank owns own_lo <= i < own_hi
        ("own_hi", _I),
        ("halo_lo", _I),  # and has halos of so many points
        ("halo_hi", _I),
        ("halo", _I),  # these, where there is a neighbour
        ("h", _F),
        ("s", _F),  # velocity of a gas's frame, that of its interface point
        ("x_interface", _F),  # x of a gas's interface
        # the ends: -1 where an interface stands, else a kind of fsipetsc.boundaries
        ("end_kind", _I, (2,)),
        ("end_degree", _I, (2,)),
        ("end_x", _F, (2,)),  # of a boundary
        ("end_data", _F, (2, 4)),
        ("end_thermal", _I, (2,)),  # INSULATED, GIVEN_T or GIVEN_FLUX, at the end of a solid,
        ("end_heat", _F, (2,)),  # and the temperature or heat flux that is given
        ("seen", _F, (SEEN,)),  # after a step, see fsipetsc.paper.sums
        ("shares", _F, (SHARES,)),
        ("rates", _F, (2,)),  # of convection and diffusion [1/s]
    ],
    align=True,
)


@dataclass(frozen=True)
class Grid:
    """The stored points of one layer: X = anchor + (i - anchor_index) h, active points lo..hi at
    first."""

    n: int
    lo: int
    hi: int
    h: float
    anchor: float
    anchor_index: int
    least: int

    @property
    def active(self) -> int:
        """Active points."""
        return self.hi - self.lo + 1

    def X(self, begin: int = 0, end: int | None = None) -> Array:
        """Lagrangian coordinates [m] of the points begin .. end-1."""
        points = np.arange(begin, self.n if end is None else end)
        return self.anchor + (points - self.anchor_index) * self.h


def ghost_index(distance: float) -> int:
    """Index of the ghost point counted from the interface: the first point at or beyond the
    boundary."""
    return int(np.ceil(distance - 1e-9))


def check_form(problem: Problem) -> None:
    """InputError for a problem that is not of the paper's form: a solid, with a gas on one side of
    it or on both, whose outer end insulates and stays where it is."""
    fluids = [k for k, layer in enumerate(problem.layers) if layer.kind == "fluid"]
    reason = ""
    if not problem.interfaces:
        reason = "there is no interface"
    elif len(fluids) == len(problem.layers) - 2 or len(problem.layers) > 3:
        reason = "a gas lies between two solids"
    for k in fluids:
        layer, end = problem.layers[k], problem.left if k == 0 else problem.right
        if not reason and layer.mapping == "stretched":
            reason = f"layer '{layer.name}' has mapping='stretched'"
        if not reason and isinstance(end, Wall) and needs_stretching(end):
            doing = "moves" if end.moves else "gives or takes heat"
            reason = f"the wall of layer '{layer.name}' {doing}"
    if reason:
        raise InputError(
            f"{reason}: the paper's couplings are of a solid between gases in rigid frames: take "
            "-fsi_coupling conservative"
        )


def make_grids(problem: Problem, op: SBPOperator, h: float, spare: int) -> list[Grid]:
    """Grids of all layers; a gas may grow by a third, or by an eighth and ``spare`` points.

    Raises InputError where h does not fit the solid or a layer is too short for the closures.
    """
    grids = []
    for k, layer in enumerate(problem.layers):
        length = layer.X[1] - layer.X[0]
        width = length / h
        if not width + spare < MOST_CELLS:
            raise InputError(
                f"layer '{layer.name}' of length {length:g} would have {width:.3g} cells with "
                f"-fsi_h {h:g}; {MOST_CELLS} are too many"
            )
        if isinstance(layer, FluidLayer):
            end, cells = (problem.left if k == 0 else problem.right), ghost_index(width)
            degree = degree_of(end, op.order)
            room = max(spare + max(1, cells // 8), cells // 3)
            # the treatment of the interface must not change the points of a boundary's formulas
            least = max(op.min_points, nodes_needed(degree) + 2, degree + 1 + row_length(op))
            n = cells + 1 + room
            if k == 0:
                grid = Grid(n, room, n - 1, h, layer.X[1], n - 1, least)
            else:
                grid = Grid(n, 0, cells, h, layer.X[0], 0, least)
        else:
            cells = _cells_of_solid(layer, h)
            grid = Grid(cells + 1, 0, cells, h, layer.X[0], 0, max(4, op.min_points))
        if grid.active < grid.least:
            raise InputError(
                f"layer '{layer.name}' has {grid.active} points with -fsi_h {h:g}; the "
                f"{op.name} operator (-fsi_order {op.order}) needs at least {grid.least}: take a "
                "smaller -fsi_h or a lower -fsi_order"
            )
        grids.append(grid)
    return grids


def _cells_of_solid(layer, h: float) -> int:
    """InputError where h does not fit."""
    length = layer.X[1] - layer.X[0]
    width = length / h
    count = max(1, round(width))
    if abs(width - count) > 1e-6 * max(1.0, width):
        fits = length / max(1, np.ceil(width)), length / max(1, np.floor(width))
        raise InputError(
            f"-fsi_h {h:.10g} misses an interface: layer '{layer.name}' of length {length:g} would "
            f"have {width:.6g} cells; the nearest spacings that fit are {fits[0]:.10g} and "
            f"{fits[1]:.10g}"
        )
    return count


class Layout:
    """Ownership of all layers on all ranks; collective on ``comm``.

    Attributes: records (RECORD array), dms (a DMDA or None per layer), grids, shares, halo (points
    of one), dof (unknowns of a point, by layer), local_size (doubles of the solution on this rank).
    """

    def __init__(
        self, comm: MPI.Comm, problem: Problem, op: SBPOperator, grids: list[Grid], mode: str
    ) -> None:
        self.comm, self.problem, self.grids = comm, problem, grids
        self.halo = max(2 * op.reach, 6)
        kinds = [layer.kind for layer in problem.layers]
        stored = [
            (kind, grid.n, grid.active, k == 0 and kind == "fluid")
            for k, (kind, grid) in enumerate(zip(kinds, grids, strict=True))
        ]
        self.shares = share_line(stored, comm.size, mode, max(self.halo, op.rows + 1))
        self.records = np.zeros(len(grids), RECORD)
        self.dof = [DOF[kind] for kind in kinds]
        self.dms: list[PETSc.DMDA | None] = []
        self._comms: list[MPI.Comm] = []
        self.local_size = 0
        self._places: list[slice] = []  # of the layers in this rank's part of a solution
        for k in range(len(grids)):
            self._describe(k, op.order)
            begin = self.local_size
            self._place(k)
            self._places.append(slice(begin, self.local_size))

    def _describe(self, k: int, order: int) -> None:
        """Note what is the same on all ranks."""
        record, grid, layers = self.records[k], self.grids[k], self.problem.layers
        record["number"], record["fluid"] = k, layers[k].kind == "fluid"
        for name in ("n", "lo", "hi", "least", "h"):
            record[name] = getattr(grid, name)
        record["halo"], record["end_kind"] = self.halo, INTERFACE_END
        for side, end in ((0, self.problem.left), (1, self.problem.right)):
            if k == (0, len(layers) - 1)[side]:
                record["end_kind"][side] = end.kind
                record["end_degree"][side] = degree_of(end, order)
                record["end_thermal"][side] = heat_of(end)[0]
                record["end_x"][side] = getattr(end, "x", 0.0)

    def _place(self, k: int) -> None:
        """Make the DMDA of layer k on its owners and note what this rank owns."""
        record, shares, dof = self.records[k], self.shares[k], self.dof[k]
        mine = any(rank == self.comm.rank for rank, _, _ in shares)
        sub = self.comm.Split(0 if mine else MPI.UNDEFINED, self.comm.rank)
        record["present"] = mine
        if not mine:
            self.dms.append(None)
            return
        dm = PETSc.DMDA().create(
            dim=1,
            dof=dof,
            sizes=(self.grids[k].n,),
            proc_sizes=(len(shares),),
            ownership_ranges=(np.array([end - begin for _, begin, end in shares], PETSc.IntType),),
            boundary_type=PETSc.DM.BoundaryType.NONE,
            stencil_width=self.halo,
            comm=sub,
        )
        (begin, end), (left, right) = dm.getRanges()[0], dm.getGhostRanges()[0]
        record["own_lo"], record["own_hi"] = begin, end
        record["halo_lo"], record["halo_hi"] = begin - left, right - end
        self.local_size += dof * (end - begin)
        self.dms.append(dm)
        self._comms.append(sub)

    def local(self, k: int, array: Array) -> Array:
        """View, shape (owned points, dof), of layer k in this rank's part of a solution vector."""
        return array[self._places[k]].reshape(-1, self.dof[k])

    def owned_X(self, k: int) -> Array:
        """Lagrangian coordinates [m] of the owned points of layer k."""
        record = self.records[k]
        return self.grids[k].X(int(record["own_lo"]), int(record["own_hi"]))

    def destroy(self) -> None:
        """Destroy the DMDAs, then their communicators. Collective."""
        for dm in self.dms:
            if dm is not None:
                dm.destroy()
        for sub in self._comms:
            sub.Free()
        self.dms, self._comms = [], []
