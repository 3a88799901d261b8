"""What a rank has of layers, which live on the ranks that own points of them, and of interfaces.

All ranks know the record and the material of each.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.kernels.procedure import Procedure
from fsipetsc.operators.bands import Patch
from fsipetsc.paper import rates, steps
from fsipetsc.paper.coupling import Face
from fsipetsc.paper.layout import DOF, law_of
from fsipetsc.paper.stencils import Stencils
from fsipetsc.parallel.block_shares import Share
from fsipetsc.parallel.exchange import Halo, Reach, halo_of
from fsipetsc.state import Seen

Array = np.ndarray
_NONE = np.zeros(0, np.int64), np.zeros(0, np.int64)


class Layer:
    """A layer and this rank's points of it.

    numbers, X, forcing: of the points of this rank; local: (unknowns, points with halos), of which
    owned is a view. part: what procedures take; does: these, by name. place: of its numbers in this
    rank's part of a solution.
    """

    does: dict[str, Procedure]

    def __init__(
        self,
        layer: Any,
        ends: tuple[Any, ...],
        records: Array,
        share: Share,
        op: Stencils,
        local: Array,
        place: slice,
        vectors: Sequence[Array],
        bounds: Array,
        batch: Array,
    ) -> None:
        self.layer, self.op, self.share, self.local, self.place = layer, op, share, local, place
        self.law = law_of(layer.material)
        self.records, self.record = records, records[0]
        record = self.record
        self.number, self.is_gas = int(record["number"]), layer.kind == "fluid"
        self.present = bool(record["present"])
        self.numbers = own = np.arange(record["own_lo"], record["own_hi"])
        self.X = record["anchor"] + (own - record["anchor_index"]) * record["h"]
        before = int(record["halo_lo"])
        self.owned = local[:, before : before + own.size]
        planes = DOF[layer.kind], own.size
        self.forcing = np.zeros(planes) if layer.forcing is not None else None
        self._scratch = np.zeros((rates.ROWS, max(local.shape[1], rates.PIECE + 2 * op.halo)))
        of_points = *(v[place].reshape(planes) for v in vectors), self.forcing, self._scratch
        self.part = steps.Part(op, ends, self.law, records, local, *of_points, bounds, batch)

    def halos(self, me: int, memory: Array) -> list[Halo]:
        """What this rank, ``me``, exchanges with others in a memory: of a gas its frame, (4.20),
        (4.25), which the rank of its interface knows, and halos.
        """
        if not self.present or len(self.share.ranks) == 1:
            return []
        found, halo = [], self.op.halo
        if self.is_gas:
            fields, at = self.records.dtype.fields, place_in(memory, self.records)
            frame = np.array([at + fields[name][1] // 8 for name in ("s", "x_interface")])
            owner = self.share.ranks[0 if self.record["outer"] else -1]
            others = [rank for rank in self.share.ranks if rank != owner]
            sent = dict.fromkeys(others, frame) if me == owner else {}
            found.append(Halo(sent, {} if me == owner else {owner: frame}, _NONE, _NONE))
        dof, n = self.local.shape
        patch = Patch((self.numbers.size, 1, 1), (n, 1, 1), (int(self.record["halo_lo"]), 0, 0))
        reach = Reach(self.share, (False,), halo, False, False)
        points = halo_of(reach, me, patch, self.numbers, dof, 0, place_in(memory, self.local))
        of_memory = {rank: points.inside[1][places] for rank, places in points.sent.items()}
        return [*found, points._replace(sent=of_memory)]

    def of(self, array: Array) -> Array:
        """View, (owned points, unknowns), of this layer in this rank's part of a solution."""
        return array[self.place].reshape(len(self.local), -1).T

    @property
    def active(self) -> slice:
        """The active ones among the points that this rank owns."""
        own, begin, end = (int(self.record[name]) for name in ("own_lo", "lo", "hi"))
        return slice(max(begin - own, 0), max(end + 1 - own, 0))

    def set_initial(self, y: Array) -> None:
        """Fill y, (owned points, unknowns), with initial data; InputError, here alone perhaps."""
        fields = self.layer.values("initial", self.X, active=self.active)
        if self.layer.exact is not None:  # what is wrong with it is not found out at the end
            self.layer.values("exact", self.X, 0.0, self.active)
        if self.is_gas:
            rho, u, T = fields
            with np.errstate(all="ignore"):  # what comes of it is monitored
                e = rho * (self.layer.material.internal_energy(rho, T) + 0.5 * u * u)
                fields = [rho, rho * u, e]
        y[:] = np.stack(fields, axis=-1)

    def set_forcing(self, t: float) -> None:
        """Evaluate the forcing at time t [s]. InputError, here alone perhaps."""
        if self.forcing is not None:
            values = self.layer.values("forcing", self.X, t, self.active)
            self.forcing[:] = 0.0
            self.forcing[:, self.active] = np.stack(values)[:, self.active]

    # what is said of them

    @np.errstate(all="ignore")
    def saved(self) -> Array:
        """(owned points, 5): of a gas rho, u, T, p, x, NaN where inactive; of a solid u, sigma, T,
        x, p."""
        out = np.full((5, self.owned.shape[1]), np.nan)
        if self.is_gas:
            rho, m, e = self.owned[:, self.active]
            u, T = self.law.velocity_and_temperature(rho, m, e)
            x = self.X[self.active] - self.record["anchor"] + self.record["x_interface"]
            out[:, self.active] = rho, u, T, self.law.law.pressure(rho, T), x
        else:
            self.does["stretch"]()
            x_X = self._scratch[0, self.record["halo_lo"] :][: out.shape[1]] / self.record["h"]
            out[:4], out[4] = self.owned, self.law.pressure(self.owned[2], x_X)
        return np.ascontiguousarray(out.T)

    def powers(self, t: float, power: int) -> Array:
        """(unknowns,): h sum |error|^power at t [s] over active points without ghosts; InputError,
        here alone perhaps."""
        exact = np.array(self.layer.values("exact", self.X, t, self.active))
        ghosts = self.is_gas * (np.arange(2) == self.record["outer"])
        first, last = self.record["lo"] + ghosts[0], self.record["hi"] - ghosts[1]
        counted = (self.numbers >= first) & (self.numbers <= last)
        apart = self.saved()[counted, : len(exact)].T - exact[:, counted]
        return self.record["h"] * np.sum(np.abs(apart) ** power, axis=1)

    def seen(self) -> Seen:
        X, numbers = self.X[self.active], self.numbers[self.active]
        if self.is_gas:
            rho, u, T, _, x = self.saved()[self.active].T
            values = {"rho": rho, "u": u, "T": T}
        else:
            u, sigma, T, x = self.owned
            # by the next point, as it is monitored
            beyond = self.local[3, self.record["halo_lo"] + 1 :]
            after = np.append(beyond, x[-1:] + self.record["h"])[: len(x)]
            x_X = (after - x) / self.record["h"]
            p = self.law.pressure(T, x_X)
            modulus = self.law.wave_modulus(T, p, np.minimum(sigma, p), x_X)
            values = {"x": x, "x_X": x_X, "u": u, "sigma": sigma, "T": T, "m0 c^2": modulus}
        return Seen(self.number, numbers, values, x[:, None], X[:, None])


class Interface:
    """An interface. side: 1 if the gas lies right of the solid, else 0; here: whether this rank,
    ``me``, owns gas and solid beside it; sides: what procedures take.

    Each of two owners gets the rows of the other one in a room, (unknowns, points), and both solve
    the same small system.
    """

    does: dict[str, Procedure]

    def __init__(
        self,
        kind: str,
        pair: Sequence[Layer],
        k: int,
        notes: Array,
        rooms: Array,
        memory: Array,
        me: int,
    ) -> None:
        gas, solid = pair
        self.side, self.jump = int(gas.number > solid.number), np.zeros(4)
        face = Face(kind, gas.law, solid.law, self.side == 1, float(solid.record["h"]))
        n, found = solid.op.n, []
        for v, room, step in zip(pair, np.split(rooms[k], [len(gas.local)]), (1, -1)):
            step *= 2 * self.side - 1  # inwards from the interface
            owner = v.share.ranks[0 if step > 0 else -1]  # it has all of these rows
            of, points, first = rooms, room, 0 if step > 0 else n - 1
            if owner == me:
                at = v.record["lo" if step > 0 else "hi"] - v.record["own_lo"]
                of, points, first = memory, v.local, int(at + v.record["halo_lo"])
            columns = first + step * np.arange(n)
            rows = place_in(of, points) + points.shape[1] * np.arange(len(points))[:, None]
            found.append((owner, points, first, (rows + columns).ravel()))
        owners, points, firsts, places = zip(*found)
        self.here = [owner == me for owner in owners]
        self.sides = steps.Sides(solid.op, face, gas.records, *points, *firsts, self.jump, notes, k)
        self.halos = []  # each owner sends its own rows, the others go into the rooms
        if self.here[0] != self.here[1]:
            mine, other = self.here.index(True), self.here.index(False)
            beyond = owners[other]
            self.halos = [Halo({beyond: places[mine]}, {beyond: places[other]}, _NONE, _NONE)]


def place_in(memory: Array, part: Array) -> int:
    """Where the numbers of a part of a memory begin."""
    return (part.ctypes.data - memory.ctypes.data) // 8
