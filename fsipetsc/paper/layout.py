"""Who owns which points: grids, and a DMDA for each layer on a communicator of the ranks that have
a part of it.

The solution is one world vector; its part on a rank is the concatenation of the rank's parts of the
layers, each interlaced (gas rho, rho u, e; solid u, sigma, T, x).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.boundaries import INTERFACE_END, Wall, degree_of, heat_of, needs_stretching
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import SBPOperator, row_length
from fsipetsc.paper.ends import nodes_needed
from fsipetsc.paper.layer import DOF, FLUID, RECORD, SOLID
from fsipetsc.parallel.partition import Extent, partition, stretched
from fsipetsc.problem import FluidLayer, Problem

Array = np.ndarray


#: cells of a layer, with the spare ones: the unknowns of a few such layers can still be counted in
#: 32 bits
MOST_CELLS = 50_000_000


@dataclass(frozen=True)
class Grid:
    """The stored points of one layer: X = anchor + (i - anchor_index) h, active points lo..hi."""

    n: int
    lo: int
    hi: int
    h: float
    anchor: float
    anchor_index: int
    least: int

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


def make_grids(
    problem: Problem,
    op: SBPOperator,
    h: float,
    spare: int,
    cells: dict[int, int] | None = None,
    before: Sequence[Grid] | None = None,
) -> list[Grid]:
    """Grids of all layers. cells: ghost index of each gas, where it differs from the initial one.

    before: grids that these take the place of; none has fewer points than it had.
    Raises InputError where h does not fit the solid or a layer is too short for the closures.
    """
    grids = []
    for k, layer in enumerate(problem.layers):
        length = layer.X[1] - layer.X[0]
        width = length / h
        if not width + spare < MOST_CELLS:
            raise InputError(
                f"layer '{layer.name}' of length {length:g} would have {width:.3g} cells with "
                f"-fsi_h {h:g} and -fsi_spare {spare}; {MOST_CELLS} are too many"
            )
        if isinstance(layer, FluidLayer):
            G = (cells or {}).get(k, ghost_index(width))
            degree = degree_of(problem.left if k == 0 else problem.right, op.order)
            # the treatment of the interface must not change the points of a boundary's formulas
            least = max(op.min_points, nodes_needed(degree) + 2, degree + 1 + row_length(op))
            n = max(
                G + 1 + (spare + max(1, G // 8) if spare >= 8 else spare),
                before[k].n if before else 0,
            )
            room = n - 1 - G
            grid = Grid(n, room, n - 1, h, layer.X[1], n - 1, least)
            if k > 0:
                grid = Grid(n, 0, G, h, layer.X[0], 0, least)
        else:
            count = max(1, round(width))
            if abs(width - count) > 1e-6 * max(1.0, width):
                fits = length / max(1, np.ceil(width)), length / max(1, np.floor(width))
                raise InputError(
                    f"-fsi_h {h:.10g} misses an interface: layer '{layer.name}' of length "
                    f"{length:g} would have {width:.6g} cells; the nearest spacings that fit are "
                    f"{fits[0]:.10g} and {fits[1]:.10g}"
                )
            grid = Grid(count + 1, 0, count, h, layer.X[0], 0, max(4, op.min_points))
        if grid.hi - grid.lo + 1 < grid.least:
            raise InputError(
                f"layer '{layer.name}' has {grid.hi - grid.lo + 1} points with -fsi_h {h:g}; the "
                f"{op.name} operator (-fsi_order {op.order}) needs at least {grid.least}: take a "
                "smaller -fsi_h or a lower -fsi_order"
            )
        grids.append(grid)
    return grids


class Layout:
    """Ownership of all layers on all ranks; collective on ``comm``.

    kept: the layout that this one takes the place of, whose ranks keep what they own where today's
    active points cannot be dealt out to all of them: a gas may have shrunk since. shares: who owns
    what, if that is known.

    Attributes: records (RECORD array), dms (a DMDA or None per layer), grids, shares, halo (points
    of one), dof (unknowns of a point, by layer), local_size (doubles of the solution on this rank).
    """

    def __init__(
        self,
        comm: MPI.Comm,
        problem: Problem,
        op: SBPOperator,
        grids: list[Grid],
        mode: str,
        kept: Layout | None = None,
        shares: list[list[tuple[int, int, int]]] | None = None,
    ) -> None:
        self.comm, self.problem, self.grids, self._order = comm, problem, grids, op.order
        self.halo = max(2 * op.reach, 6)
        pairs = list(zip(problem.layers, grids, strict=True))
        extents = [
            Extent(v.kind, g.n, g.hi - g.lo + 1, k == 0 and v.kind == "fluid")
            for k, (v, g) in enumerate(pairs)
        ]
        try:
            self.shares = shares or partition(extents, comm.size, mode, max(self.halo, op.rows + 1))
        except InputError:
            if kept is None:
                raise
            self.shares = [
                stretched(extent, own) for extent, own in zip(extents, kept.shares, strict=True)
            ]
        self.records = np.zeros(len(grids), RECORD)
        self._comms: list[MPI.Comm] = []
        self.dms: list[PETSc.DMDA | None] = []
        self.dof = [DOF[FLUID if v.kind == "fluid" else SOLID] for v in problem.layers]
        self.local_size = 0
        self._places: list[slice] = []  # of the layers in this rank's part of a solution
        for k in range(len(grids)):
            self._describe(k)
            begin = self.local_size
            self._place(k)
            self._places.append(slice(begin, self.local_size))

    def _describe(self, k: int) -> None:
        """Note what is the same on all ranks."""
        record, grid, layers = self.records[k], self.grids[k], self.problem.layers
        record["kind"] = FLUID if layers[k].kind == "fluid" else SOLID
        for name in ("n", "lo", "hi", "least", "h"):
            record[name] = getattr(grid, name)
        record["halo"], record["end_kind"] = self.halo, INTERFACE_END
        for side, end in ((0, self.problem.left), (1, self.problem.right)):
            if k == (0, len(layers) - 1)[side]:
                record["end_kind"][side], record["end_degree"][side] = (
                    end.kind,
                    degree_of(end, self._order),
                )
                record["end_thermal"][side], record["end_x"][side] = (
                    heat_of(end)[0],
                    getattr(end, "x", 0.0),
                )

    def _place(self, k: int) -> None:
        """Make the DMDA of layer k on its owners and note what this rank owns."""
        record, shares, dof = self.records[k], self.shares[k], self.dof[k]
        mine = any(rank == self.comm.rank for rank, _, _ in shares)
        sub = self.comm.Split(0 if mine else MPI.UNDEFINED, self.comm.rank)
        record["start"], record["present"] = self.local_size, mine
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
