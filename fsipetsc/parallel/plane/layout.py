"""Who owns what in two dimensions: a DMDA for each layer on a communicator of its own, and the world vector that holds all.

On each rank the solution is the concatenation of the rank's blocks of the layers, (J, J rho, J rho u, J rho v, J e) or (x,
y, u, v, T) of a point side by side (x, y: displacement), and behind them the kinetic energies of the end points of solids
at interfaces, interface by interface, of the columns that the rank owns. Last come, of each layer that it has a part of, the
GAINED numbers of fsipetsc.scheme.plane.gains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.boundaries.plane import PERIODIC
from fsipetsc.operators.sbp import SBPOperator
from fsipetsc.parallel.plane.grids import PlaneGrid, share_out
from fsipetsc.physics.layer import FLUID, SOLID
from fsipetsc.physics.plane.layer import COUPLED, DOF, ELASTIC, GAINED, NOWHERE, PLANE_LAYER
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem


@dataclass(frozen=True)
class Meeting:
    """Where an interface is: its layers (fluid, solid), rows that meet, the columns of the gas, of the solid ``shift`` less."""

    layers: tuple[int, int]
    rows: tuple[int, int]
    first: int
    end: int
    shift: int


class PlaneLayout:
    """Ownership of all layers on all ranks. Collective on ``comm``.

    Attributes: grids, shares, records (PLANE_LAYER), dms (a DMDA or None per layer), starts (of this rank's block of each
    layer in its part of the solution, and at [-1] the doubles of that), offsets (of the parts of all ranks in the world
    vector), halo (points), meetings.
    """

    def __init__(
        self, comm: MPI.Comm, problem: PlaneProblem, op: SBPOperator, grids: list[PlaneGrid], partition: str = "auto"
    ) -> None:
        self.comm, self.problem, self.grids = comm, problem, grids
        self.halo = 2 * op.p
        self.shares = share_out(grids, [layer.kind for layer in problem.layers], op, comm.size, partition)
        self.meetings = [self._meeting(fluid, solid) for fluid, solid in problem.interfaces]
        self._sizes = [self._blocks(rank) for rank in range(comm.size)]
        self.offsets = np.cumsum([0, *(sum(sizes) for sizes in self._sizes)])
        self.starts = np.cumsum([0, *self._sizes[comm.rank]])
        self.local_size = int(self.starts[-1])
        self.records = np.zeros(len(grids), PLANE_LAYER)
        self.dms: list[PETSc.DMDA | None] = []
        self._comms: list[MPI.Comm] = []
        for k in range(len(grids)):
            self._place(k)
            self._materials(k)
            self._edges(k)
        own = [(*np.diff(self.records[k]["own_y"]), *np.diff(self.records[k]["own_x"]), DOF) for k in range(len(grids))]
        cuts = self.starts.tolist()
        self._parts = [(slice(*cuts[k : k + 2]), tuple(map(int, shape))) for k, shape in enumerate(own)]

    def _meeting(self, fluid: int, solid: int) -> Meeting:
        gas, elastic = self.grids[fluid], self.grids[solid]
        shift = elastic.column - gas.column
        rows = (gas.ny - 1, 0) if fluid < solid else (0, elastic.ny - 1)
        return Meeting((fluid, solid), rows, shift, shift + elastic.nx, shift)

    def _blocks(self, rank: int) -> list[int]:
        """Doubles that a rank owns of each layer, of the kinetic energies at each interface, and of what each layer gains."""
        sizes = []
        for share in self.shares:
            a, b, c, d = share.block(rank) if rank in share.ranks else (0, 0, 0, 0)
            sizes.append((b - a) * (d - c) * DOF)
        for meeting in self.meetings:
            sizes.append(self._energies(meeting, rank))
        return sizes + [GAINED if rank in share.ranks else 0 for share in self.shares]

    def _energies(self, meeting: Meeting, rank: int) -> int:
        """Columns of a solid at an interface whose end points a rank owns."""
        share = self.shares[meeting.layers[1]]
        if rank not in share.ranks:
            return 0
        a, b, c, d = share.block(rank)
        return b - a if c <= meeting.rows[1] < d else 0

    def places(self, rank: int) -> list[tuple[str, tuple[slice, ...], int, tuple[int, ...]]]:
        """What a rank has of the solution: "layerK" or, of interface N, "energiesN", place in it, where it begins, shape."""
        found, at = [], 0
        for k, share in enumerate(self.shares):
            if rank in share.ranks:
                a, b, c, d = share.block(rank)
                found.append((f"layer{k}", (slice(c, d), slice(a, b)), at, (d - c, b - a, DOF)))
            at += self._sizes[rank][k]
        for number, meeting in enumerate(self.meetings):
            count = self._sizes[rank][len(self.grids) + number]
            if count:
                a = self.shares[meeting.layers[1]].block(rank)[0]
                found.append((f"energies{number}", (slice(a, a + count),), at, (count,)))
            at += count
        return found

    def gains_at(self, rank: int) -> list[tuple[int, int]]:
        """(layer, where what it has gained stands in a rank's part) of the layers that the rank has a part of."""
        sizes = np.cumsum([0, *self._sizes[rank]])[len(self.grids) + len(self.meetings) :]
        return [(k, int(sizes[k])) for k, share in enumerate(self.shares) if rank in share.ranks]

    def index(self, k: int, columns: np.ndarray, row: int) -> np.ndarray:
        """Numbers in the world vector of the first unknowns of the points of layer k in a row."""
        found = np.empty(columns.size, np.int64)
        for rank in np.unique(owners := self.shares[k].owners(columns, row)):
            a, b, c, _ = self.shares[k].block(rank)
            here = owners == rank
            start = self.offsets[rank] + sum(self._sizes[rank][:k])
            found[here] = start + ((row - c) * (b - a) + columns[here] - a) * DOF
        return found

    def index_of_energies(self, number: int, columns: np.ndarray) -> np.ndarray:
        """Numbers in the world vector of the kinetic energies at interface ``number``, by columns of the solid."""
        meeting, found = self.meetings[number], np.empty(columns.size, np.int64)
        k = meeting.layers[1]
        for rank in np.unique(owners := self.shares[k].owners(columns, meeting.rows[1])):
            here = owners == rank
            start = self.offsets[rank] + sum(self._sizes[rank][: len(self.grids) + number])
            found[here] = start + columns[here] - self.shares[k].block(rank)[0]
        return found

    def _place(self, k: int) -> None:
        """Make the DMDA of layer k on its owners, and note what this rank has of it."""
        grid, share, record = self.grids[k], self.shares[k], self.records[k]
        mine = self.comm.rank in share.ranks
        sub = self.comm.Split(0 if mine else MPI.UNDEFINED, self.comm.rank)
        record["kind"] = FLUID if isinstance(self.problem.layers[k], PlaneFluidLayer) else SOLID
        record["ny"], record["h_x"], record["h_y"] = grid.ny, grid.h_x, grid.h_y
        if not mine:
            self.dms.append(None)
            return
        kinds = PETSc.DM.BoundaryType
        dm = PETSc.DMDA().create(
            dim=2,
            dof=DOF,
            sizes=(grid.nx, grid.ny),
            proc_sizes=(len(share.columns) - 1, len(share.rows) - 1),
            ownership_ranges=tuple(np.diff(cuts).astype(PETSc.IntType) for cuts in (share.columns, share.rows)),
            boundary_type=(kinds.PERIODIC if grid.periodic else kinds.NONE, kinds.NONE),
            stencil_type=PETSc.DMDA.StencilType.BOX,
            stencil_width=self.halo,
            comm=sub,
        )
        (first_x, first_y), (width, height) = dm.getGhostCorners()
        (own_x, own_y), (columns, rows) = dm.getCorners()
        record["width"], record["height"], record["first_x"], record["first_y"] = width, height, first_x, first_y
        record["own_x"] = own_x - first_x, own_x - first_x + columns
        record["own_y"] = own_y - first_y, own_y - first_y + rows
        record["end_x"] = (-NOWHERE, NOWHERE) if grid.periodic else (-first_x, grid.nx - 1 - first_x)
        record["end_y"] = -first_y, grid.ny - 1 - first_y
        self.dms.append(dm)
        self._comms.append(sub)

    def _materials(self, k: int) -> None:
        record, layer = self.records[k], self.problem.layers[k]
        material = layer.material
        if isinstance(layer, PlaneFluidLayer):
            for name in ("gamma", "R", "cv", "mu", "kappa", "gas_numbers", "transport_numbers"):
                record[name] = getattr(material, name)
            record["force"] = layer.force
        else:
            for name in ("m0", "mu_e", "lambda_e", "p_ref", "alpha", "kappa_e", "force"):
                record[name] = getattr(material, name)
            record["heat"] = COUPLED if material.heat == "coupled" else ELASTIC

    def _edges(self, k: int) -> None:
        """What stands at the four edges of layer k."""
        record, layer = self.records[k], self.problem.layers[k]
        record["edge_x"] = PERIODIC if self.grids[k].periodic else (layer.left.kind, layer.right.kind)
        ends = [self.problem.edge(k, 0), self.problem.edge(k, 1), layer.left, layer.right]
        for side in range(2):
            record["edge_y"][side] = INTERFACE_END if ends[side] is None else ends[side].kind
            record["beside"][side] = getattr(layer, "beside", layer.left).kind
        for edge, end in enumerate(ends):
            if end is not None and hasattr(end, "rho"):
                record["outside"][edge] = end.rho, end.u, end.v, end.T
            record["outside"][edge, 0] += getattr(end, "pressure", 0.0)
        for meeting in self.meetings:
            if k in meeting.layers:
                side = int(meeting.layers[1 - meeting.layers.index(k)] > k)
                shift = 0 if k == meeting.layers[0] else meeting.shift
                ends = np.array([meeting.first, meeting.end]) - shift - record["first_x"]
                record["face"][side] = (-NOWHERE, NOWHERE) if self.grids[k].periodic else ends

    def local(self, k: int, array: np.ndarray) -> np.ndarray:
        """View, shape (owned rows, owned columns, DOF), of layer k in this rank's part of a solution vector."""
        part, shape = self._parts[k]
        return array[part].reshape(shape)

    def energies(self, number: int, array: np.ndarray) -> np.ndarray:
        """View of the kinetic energies at an interface there."""
        at = len(self.grids) + number
        return array[self.starts[at] : self.starts[at + 1]]

    @property
    def behind(self) -> slice:
        """What stands behind the layers in this rank's part of a solution vector."""
        return slice(int(self.starts[len(self.grids)]), self.local_size)

    def gains(self, k: int, array: np.ndarray) -> np.ndarray:
        """View of what layer k has gained there, (GAINED,)."""
        at = self.gains_begin(k)
        return array[at : at + (GAINED if self.dms[k] is not None else 0)]

    def gains_begin(self, k: int) -> int:
        """Where it begins there."""
        return int(self.starts[len(self.grids) + len(self.meetings) + k])

    def held(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """(columns, rows), numbers of those of layer k that this rank holds, halos among them."""
        record = self.records[k]
        return record["first_x"] + np.arange(record["width"]), record["first_y"] + np.arange(record["height"])

    def owned(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """(columns, rows) of those that it owns."""
        columns, rows = self.held(k)
        return columns[slice(*self.records[k]["own_x"])], rows[slice(*self.records[k]["own_y"])]

    def destroy(self) -> None:
        """Destroy the DMDAs, then their communicators. Collective."""
        for dm in self.dms:
            if dm is not None:
                dm.destroy()
        for sub in self._comms:
            sub.Free()
        self.dms, self._comms = [], []
