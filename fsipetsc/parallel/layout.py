"""Who owns what: DMDAs on sub-communicators and the world vector that holds them all.

The solution is one world vector; its part on a rank is the concatenation of the rank's parts of the layers, each
interlaced (fluid rho, rho u, e; solid u, sigma, T, x). Beside it every rank has a work array in which the same
points stand with their halos.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.boundaries import DIRICHLET, INTERFACE_END, OPEN, WALL, Wall, degree_of, heat_of, in_time, nodes_needed
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import SBPOperator, row_length
from fsipetsc.parallel.partition import Extent, partition, stretched
from fsipetsc.physics.layer import DOF, ENDS, FLUID, LAYER, SHARED_HEAT, SOLID, UNLOADED
from fsipetsc.problem import FluidLayer, Layer, Problem, SolidLayer

#: cells of a layer, with the spare ones: the unknowns of a few such layers can still be counted in 32 bits
MOST_CELLS = 50_000_000


@dataclass(frozen=True)
class Grid:
    """The stored points of one layer: X = anchor + (i - anchor_index) h, active points lo..hi; stretched: of a gas, between
    its ends."""

    n: int
    lo: int
    hi: int
    h: float
    anchor: float
    anchor_index: int
    least: int
    stretched: bool = False

    def X(self, begin: int = 0, end: int | None = None) -> np.ndarray:
        """Lagrangian coordinates [m] of the points begin .. end-1."""
        return self.anchor + (np.arange(begin, self.n if end is None else end) - self.anchor_index) * self.h


def ghost_index(distance: float) -> int:
    """Index of the ghost point counted from the interface: the first point at or beyond the boundary."""
    return int(np.ceil(distance - 1e-9))


def make_grids(
    problem: Problem,
    op: SBPOperator,
    h: float,
    spare: int,
    mapping: str,
    cells: dict[int, int] | None = None,
    before: Sequence[Grid] | None = None,
) -> list[Grid]:
    """Grids of all layers. mapping: of the gases, see ``Problem.is_stretched``.

    cells: ghost index of each rigid fluid layer, where it differs from the initial one.
    before: grids that these take the place of; none has fewer points than it had.
    Raises InputError where h does not fit the solids or a layer is too short for the closures.
    """
    grids, last = [], len(problem.layers) - 1
    for k, layer in enumerate(problem.layers):
        width = (layer.X[1] - layer.X[0]) / h
        if not width + spare < MOST_CELLS:
            raise InputError(
                f"layer '{layer.name}' of length {layer.X[1] - layer.X[0]:g} would have {width:.3g} cells with -fsi_h {h:g} "
                f"and -fsi_spare {spare}; {MOST_CELLS} are too many"
            )
        if isinstance(layer, SolidLayer) or problem.is_stretched(k, mapping):
            grid = _between_ends(layer, op, h, width)
            if isinstance(layer, FluidLayer):
                ends = [end for at, end in ((0, problem.left), (last, problem.right)) if at == k and not isinstance(end, Wall)]
                grid = replace(grid, least=max([grid.least, *(_least(op, degree_of(end, op.order)) for end in ends)]))
        else:
            G = (cells or {}).get(k, ghost_index(width))
            end = problem.left if k == 0 else problem.right
            degree = degree_of(end, op.order)
            least = _least(op, degree)
            room = spare + max(1, G // 8) if spare >= 8 else spare
            n = max(G + 1 + room, before[k].n if before else 0)
            room = n - 1 - G
            grid = Grid(n, room, n - 1, h, layer.X[1], n - 1, least) if k == 0 else Grid(n, 0, G, h, layer.X[0], 0, least)
        if grid.hi - grid.lo + 1 < grid.least:
            raise InputError(
                f"layer '{layer.name}' has {grid.hi - grid.lo + 1} points with -fsi_h {h:g}; the {op.name} operator "
                f"(-fsi_order {op.order}) needs at least {grid.least}: take a smaller -fsi_h or a lower -fsi_order"
            )
        grids.append(grid)
    return grids


def _least(op: SBPOperator, degree: int) -> int:
    """Active points of a gas with an end whose formula has this degree: the treatment of the interface must not change them."""
    return max(op.min_points, nodes_needed(degree) + 2, degree + 1 + row_length(op))


def _between_ends(layer: Layer, op: SBPOperator, h: float, width: float) -> Grid:
    """The grid of a solid, whose width in cells must be a whole number, or of a stretched gas, whose spacing is made to fit."""
    cells = max(1, round(width))
    # the rows that the treatments of its two ends may change must not overlap
    least = max(4, op.min_points)
    if isinstance(layer, FluidLayer):
        return Grid(cells + 1, 0, cells, (layer.X[1] - layer.X[0]) / cells, layer.X[0], 0, least, stretched=True)
    if abs(width - cells) > 1e-6 * max(1.0, width):
        raise InputError(
            f"-fsi_h {h:.10g} misses an interface: layer '{layer.name}' of length {layer.X[1] - layer.X[0]:g} "
            f"would have {width:.6g} cells; the nearest spacings that fit are "
            f"{(layer.X[1] - layer.X[0]) / max(1, np.ceil(width)):.10g} and "
            f"{(layer.X[1] - layer.X[0]) / max(1, np.floor(width)):.10g}"
        )
    return Grid(cells + 1, 0, cells, h, layer.X[0], 0, least)


class Layout:
    """Ownership of all layers on all ranks; collective on ``comm``.

    kept: the layout that this one takes the place of, whose ranks keep what they own where today's active points cannot
    be dealt out to all of them: a gas may have shrunk since. shares: who owns what, if that is known.

    Attributes: records (LAYER array), dms (a DMDA or None per layer), grids, shares, local_size (doubles of the
    solution on this rank), work_size (doubles with halos), halo (its points).
    """

    def __init__(
        self,
        comm: MPI.Comm,
        problem: Problem,
        op: SBPOperator,
        h: float,
        grids: list[Grid],
        mode: str,
        conservative: bool,
        kept: Layout | None = None,
        shares: list[list[tuple[int, int, int]]] | None = None,
    ) -> None:
        self.comm, self.problem, self.grids, self.h, self._order = comm, problem, grids, h, op.order
        self._conservative = conservative
        self.halo = max(2 * op.reach, 6)
        extents = [
            Extent(layer.kind, grid.n, grid.hi - grid.lo + 1, k == 0 and not grid.stretched and layer.kind == "fluid")
            for k, (layer, grid) in enumerate(zip(problem.layers, grids, strict=True))
        ]
        try:
            self.shares = shares or partition(extents, comm.size, mode, max(self.halo, op.rows + 1))
        except InputError:
            if kept is None:
                raise
            self.shares = [stretched(extent, shares) for extent, shares in zip(extents, kept.shares, strict=True)]
        self.records = np.zeros(len(grids), LAYER)
        self._comms: list[MPI.Comm] = []
        self.dms: list[PETSc.DMDA | None] = []
        self.local_size = self.work_size = 0
        for k, layer in enumerate(problem.layers):
            self._place(k, DOF[FLUID if layer.kind == "fluid" else SOLID])
            self._materials(k)

    def _place(self, k: int, dof: int) -> None:
        """Make the DMDA of layer k on its owners and note who owns what on this rank."""
        record, grid, shares = self.records[k], self.grids[k], self.shares[k]
        record["kind"] = FLUID if dof == DOF[FLUID] else SOLID
        record["n"], record["lo"], record["hi"] = grid.n, grid.lo, grid.hi
        record["least"], record["h"], record["J"], record["stretched"] = grid.least, grid.h, 1.0, grid.stretched
        record["ends"] = -1
        mine = any(rank == self.comm.rank for rank, _, _ in shares)
        sub = self.comm.Split(0 if mine else MPI.UNDEFINED, self.comm.rank)
        record["start"], record["work"] = self.local_size, self.work_size
        if not mine:
            self.dms.append(None)
            return
        dm = PETSc.DMDA().create(
            dim=1,
            dof=dof,
            sizes=(grid.n,),
            proc_sizes=(len(shares),),
            ownership_ranges=(np.array([end - begin for _, begin, end in shares], PETSc.IntType),),
            boundary_type=PETSc.DM.BoundaryType.NONE,
            stencil_width=self.halo,
            comm=sub,
        )
        (begin, end), (left, right) = dm.getRanges()[0], dm.getGhostRanges()[0]
        record["present"] = 1
        record["own_lo"], record["own_hi"] = begin, end
        record["halo_lo"], record["halo_hi"] = begin - left, right - end
        record["stride"] = (right - left + ENDS + 7) // 8 * 8
        self.local_size += dof * (end - begin)
        if self.energetic(k):
            record["ends"] = self.local_size
            self.local_size += ENDS
        self.work_size += dof * int(record["stride"])
        self.dms.append(dm)
        self._comms.append(sub)

    def _materials(self, k: int) -> None:
        record, layer, last = self.records[k], self.problem.layers[k], len(self.grids) - 1
        material = layer.material
        if isinstance(layer, FluidLayer):
            for name in ("gamma", "R", "cv", "kappa", "force", "gas_numbers", "transport_numbers"):
                record[name] = getattr(material, name)
            record["mu"] = 4.0 / 3.0 * material.mu
        else:
            for name in ("K", "kappa_e", "m0", "alpha", "force", "gruneisen", "pressing_numbers"):
                record[name] = getattr(material, name)
        record["end_kind"] = INTERFACE_END
        for side, end in ((0, self.problem.left), (1, self.problem.right)):
            if k == (0, last)[side]:
                record["end_kind"][side], record["end_degree"][side] = end.kind, degree_of(end, self._order)
                record["end_apart"][side] = end.kind in (OPEN, DIRICHLET)
                record["end_thermal"][side] = heat_of(end)[0]
                if "x" not in in_time(end):
                    record["end_x"][side] = getattr(end, "x", 0.0)
                record["unloaded"][side] = (end.kind == WALL and self.grids[k].stretched) or (
                    self._conservative and record["kind"] == SOLID
                )
            elif self._conservative:
                record["unloaded"][side] = SHARED_HEAT if self._conducts(k) and self._conducts(k + 2 * side - 1) else UNLOADED

    def energetic(self, k: int) -> bool:
        """The kinetic energies of the ends of layer k are unknowns, too."""
        return bool(self._conservative and self.records[k]["kind"] == SOLID)

    def _conducts(self, k: int) -> bool:
        """Layer k conducts heat."""
        material = self.problem.layers[k].material
        return getattr(material, "kappa", 0.0) > 0 or getattr(material, "kappa_e", 0.0) > 0

    def neighbours(self, k: int) -> tuple[int, int]:
        """World ranks that own the points left and right of this rank's part of layer k, -1 where none does."""
        ranks = [rank for rank, _, _ in self.shares[k]]
        if self.comm.rank not in ranks:
            return -1, -1
        at = ranks.index(self.comm.rank)
        return (ranks[at - 1] if at > 0 else -1), (ranks[at + 1] if at + 1 < len(ranks) else -1)

    def local(self, k: int, array: np.ndarray) -> np.ndarray:
        """View, shape (owned points, dof), of layer k in this rank's part of a solution vector."""
        record = self.records[k]
        dof = DOF[record["kind"]]
        count = int(record["own_hi"] - record["own_lo"])
        return array[record["start"] : record["start"] + dof * count].reshape(count, dof)

    def ends(self, k: int, array: np.ndarray) -> np.ndarray:
        """View, shape (2,), of the kinetic energies of the end points of layer k there; (0,) where there are none."""
        at = int(self.records[k]["ends"])
        return array[at : at + ENDS] if at >= 0 else array[:0]

    def owned_X(self, k: int) -> np.ndarray:
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
