"""What a rank has of layers and interfaces, and what it exchanges of them with other ranks.

A layer lives on the ranks that own points of it. All ranks know its record and its material.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.paper import rates, steps
from fsipetsc.paper.coupling import Face
from fsipetsc.paper.laws import law_of
from fsipetsc.paper.layout import DOF
from fsipetsc.paper.outer_ends import Ends
from fsipetsc.paper.stencils import Stencils
from fsipetsc.parallel.exchange import Exchange
from fsipetsc.state import Seen

Array = np.ndarray


class Layer:
    """Layer number k, and this rank's points of it.

    layer, ends: what the case says; law: its material; record: of records, that of it alone.
    numbers, X, local, owned, forcing: of the points of this rank, local with halos; part: what
    procedures take, does: these, by name, once they are recorded; ranks: that own the first and the
    last point. Collective, as are all methods on ranks that have points.
    """

    does: dict[str, Procedure]

    def __init__(
        self,
        layer: Any,
        ends: Ends,
        records: Array,
        share: Sequence[tuple[int, int, int]],
        op: Stencils,
        memory: Sequence[Array],
        at: int,
        batch: Array,
    ) -> None:
        self.layer, self.op, self.records = layer, op, records
        self.law = law = law_of(layer.material)
        self.record = record = records[0]
        self.number, self.is_gas = int(record["number"]), layer.kind == "fluid"
        self.present = bool(record["present"])
        self.ranks, dof = (share[0][0], share[-1][0]), DOF[layer.kind]
        self.numbers = own = np.arange(record["own_lo"], record["own_hi"])
        self.X = record["anchor"] + (own - record["anchor_index"]) * record["h"]
        count, before, after = len(own), int(record["halo_lo"]), int(record["halo_hi"])
        self._place = slice(at, at + dof * count)  # in this rank's part of a solution
        self.local = np.zeros((before + count + after, dof))
        self.owned = self.local[before : before + count]
        self.forcing = np.zeros((count, dof)) if layer.forcing is not None else None
        room = max(len(self.local), rates.PIECE + 2 * op.halo)
        self._scratch = np.zeros((rates.ROWS, room))
        points = self.local, self.owned, *map(self.of, memory), self.forcing, self._scratch
        self.part = steps.Part(op, ends, law, records, *points, batch)
        self._share = share
        #: rank of the interface of a gas, which knows its frame
        self._owner = share[0 if record["outer"] else -1][0]
        self.exchanges: list[Exchange] = []

    def connect(self, comm: MPI.Comm) -> None:
        """Make the exchanges of this layer: of its frame, (4.20), (4.25), if it is a gas, and of
        halos. Collective.
        """
        if not self.present or len(self._share) == 1:
            return
        tag, me = 16 + 2 * self.number, comm.rank
        none = np.zeros(0, np.int64), np.zeros(0, np.int64)
        if self.is_gas:
            numbers = self.records.view(np.float64)
            names = "s", "x_interface"
            frame = np.array([self.records.dtype.fields[name][1] // 8 for name in names])
            others = [rank for rank, *_ in self._share if rank != self._owner]
            sent = dict.fromkeys(others, frame) if me == self._owner else {}
            received = {} if me == self._owner else {self._owner: frame}
            self.exchanges.append(Exchange(comm, tag, sent, received, none, numbers, numbers))
        first, dof = int(self.record["own_lo"] - self.record["halo_lo"]), self.local.shape[1]

        def places(begin: int, end: int) -> Array:
            return np.arange(dof * (begin - first), dof * (end - first))

        n, halo = int(self.record["n"]), int(self.record["halo"])
        spans = {rank: (a, b, max(a - halo, 0), min(b + halo, n)) for rank, a, b in self._share}
        a, b, low, high = spans.pop(me)
        sent, received = {}, {}
        for rank, (begin, end, from_, to) in spans.items():
            if max(a, from_) < min(b, to):
                sent[rank] = places(max(a, from_), min(b, to))
            if max(begin, low) < min(end, high):
                received[rank] = places(max(begin, low), min(end, high))
        local = self.local.reshape(-1)
        halos = Exchange(comm, tag + 1, sent, received, none, local, local)
        self.exchanges.append(halos)

    def record_on(self, code: Code, place: str, of_steps: steps.Steps) -> None:
        """Record the procedures of the layer, which stands at a place: left, solid or right."""
        self.does = steps.of_layer(code, place, self.part, of_steps)

    def stage(self, number: int) -> list[Procedure]:
        """What finds the rates of a stage, which fulfils the conditions but for the ghost point,
        and makes the next one. In the first stage, which is the completed solution, it is filled.
        """
        filled = number == 0 or not self.is_gas
        names = [*([] if filled else ["fill"]), "rates"]
        names += [] if number == steps.RATES_ALONE else [f"advance_{number}"]
        return [self.does[name] for name in names]

    def of(self, array: Array) -> Array:
        """View, shape (owned points, unknowns), of this layer in this rank's part of a solution."""
        return array[self._place].reshape(-1, self.local.shape[1])

    @property
    def active(self) -> slice:
        """The active ones among the points that this rank owns."""
        own, begin, end = (int(self.record[name]) for name in ("own_lo", "lo", "hi"))
        return slice(max(begin - own, 0), max(end + 1 - own, 0))

    def rows_from(self, side: int) -> Array:
        """Numbers, among the points that this rank owns, of those that D reaches from an end."""
        inward = np.arange(self.op.n)
        rows = self.record["hi"] - inward if side else self.record["lo"] + inward
        return rows - self.record["own_lo"]

    def set_initial(self, y: Array) -> dict[tuple[int, int], float]:
        """Fill y, (owned points, unknowns), with initial data; InputError, here alone perhaps.

        Returns (number, end) -> x [m] of the ends of a solid that this rank owns.
        """
        fields = self.layer.first_values(self.X, self.active)
        if self.layer.exact is not None:  # what is wrong with it is not found out at the end
            self.layer.values("exact", self.X, 0.0, self.active)
        if self.is_gas:
            rho, u, T = fields
            with np.errstate(all="ignore"):  # what comes of it is monitored
                e = rho * (self.layer.material.internal_energy(rho, T) + 0.5 * u * u)
                y[:] = np.stack([rho, rho * u, e], axis=-1)
            return {}
        y[:] = np.stack(fields, axis=-1)
        first, last = self.record["own_lo"] == 0, self.record["own_hi"] == self.record["n"]
        ends = {(self.number, 0): fields[3][0]} if first else {}
        return {**ends, **({(self.number, 1): fields[3][-1]} if last else {})}

    # what is said of them

    @np.errstate(all="ignore")
    def saved(self) -> Array:
        """(owned points, 5): of a gas rho, u, T, p, x, NaN where inactive; of a solid u, sigma, T,
        x, p."""
        out = np.full((len(self.owned), 5), np.nan)
        if self.is_gas:
            rho, m, e = self.owned[self.active].T
            u, T = self.law.velocity_and_temperature(rho, m, e)
            x = self.X[self.active] - self.record["anchor"] + self.record["x_interface"]
            out[self.active] = np.stack([rho, u, T, self.law.law.pressure(rho, T), x], axis=-1)
            return out
        self.does["stretch"]()
        x_X = self._scratch[1, self.record["halo_lo"] :][: len(out)] / self.record["h"]
        out[:, :4], out[:, 4] = self.owned, self.law.pressure(self.owned[:, 2], x_X)
        return out

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
        """Values at active points."""
        X, numbers = self.X[self.active], self.numbers[self.active]
        if self.is_gas:
            rho, u, T, _, x = self.saved()[self.active].T
            values = {"rho": rho, "u": u, "T": T}
        else:
            u, sigma, T, x = self.owned.T
            x_X = self._stretch()
            p = self.law.pressure(T, x_X)
            modulus = self.law.wave_modulus(T, p, np.minimum(sigma, p), x_X)
            values = {"x": x, "x_X": x_X, "u": u, "sigma": sigma, "T": T, "m0 c^2": modulus}
        return Seen(self.number, numbers, values, x[:, None], X[:, None])

    def _stretch(self) -> Array:
        """x_X of a solid at the owned points, each by the next one, as it is monitored."""
        x, h = self.owned[:, 3], self.record["h"]
        after = np.append(self.local[self.record["halo_lo"] + 1 :, 3], x[-1:] + h)[: len(x)]
        stretch: Array = (after - x) / h
        return stretch

    def shortest(self) -> tuple[float, int, float, float]:
        """Of a solid: least x_X, number and X of the point, what pushes it together [Pa]."""
        x_X = self._stretch()
        i, (_, sigma, T, _) = int(np.argmin(x_X)), self.owned.T
        push = self.law.pressure(T[i], x_X[i]) - sigma[i]
        return float(x_X[i]), int(self.numbers[i]), float(self.X[i]), float(push)

    # stages

    def exchange(self) -> list[Any]:
        """After interfaces are coupled: the outer ends of a solid, and all exchanges."""
        return [*([] if self.is_gas else [self.does["close"]]), *self.exchanges]

    def fill_halos(self) -> None:
        """Fill the halos of the stage; who has a whole layer has none."""
        for exchange in self.exchanges:
            exchange()

    def destroy(self) -> None:
        """Release the messages."""
        for exchange in self.exchanges:
            exchange.destroy()


class Interface:
    """Interface number k. jump: prescribed jumps; side: 1 if the gas lies right of the solid, else
    0; here: whether this rank owns gas and solid beside it; notes: (steps.NOTES, interfaces); does:
    its procedures by name, once they are recorded."""

    does: dict[str, Procedure]

    def __init__(
        self, comm: MPI.Comm, k: int, kind: str, gas: Layer, solid: Layer, notes: Array
    ) -> None:
        self.side = side = int(gas.number > solid.number)
        self.jump, self._tag, self._comm = np.zeros(4), k, comm
        face = Face(kind, gas.law, solid.law, side == 1, float(solid.record["h"]))
        self._points = points = gas.owned, solid.owned
        self._at = at = gas.rows_from(1 - side), solid.rows_from(side)
        n, widths = len(at[0]), [q.shape[1] for q in points]
        self._rows = np.zeros(n * sum(widths))
        cut = n * widths[0]
        rows = self._rows[:cut].reshape(n, -1), self._rows[cut:].reshape(n, -1)
        memory = gas.records, *points, *at, *rows, self.jump, notes, k
        self._sides = steps.Sides(solid.op, face, *memory)
        # the rank with the last point of a layer has all of the rows, see parallel.block_shares
        self._owners = gas.ranks[1 - side], solid.ranks[side]
        self.here = [owner == comm.rank for owner in self._owners]

    def record_on(self, code: Code) -> None:
        """Record the procedures of the interface."""
        self.does = steps.of_interface(code, ("left", "right")[self.side], self._sides)

    def connect(self) -> None:
        """Make the exchanges of the rows of both sides, if they have different owners: these swap
        rows, and each solves the same small system. Collective.
        """
        self.exchanges: list[Exchange] = []
        if self.here[0] == self.here[1]:
            return
        mine, cut = self.here.index(True), self._at[0].size * self._points[0].shape[1]
        rows = np.arange(cut), np.arange(cut, self._rows.size)
        width = self._points[mine].shape[1]
        at = (self._at[mine][:, None] * width + np.arange(width)).ravel()
        points, owner = self._points[mine].reshape(-1), self._owners[1 - mine]
        swapped = {owner: at}, {owner: rows[1 - mine]}, (at, rows[mine]), points, self._rows
        back = {}, {}, (rows[mine], at), self._rows, points
        about = self._comm, self._tag
        self.exchanges = [Exchange(*about, *swapped), Exchange(*about, *back)]

    def coupling(self) -> list[Any]:
        """What couples the two sides in the stage."""
        if all(self.here):
            return [self.does[name] for name in ("take", "couple", "put")]
        if not any(self.here):
            return []
        taken, put = self.exchanges
        return [taken, self.does["couple"], put]

    def note(self) -> list[Procedure]:
        """What notes the interface: the owner of the solid does."""
        return [self.does["note"]] if self.here[1] else []

    def destroy(self) -> None:
        """Release the messages."""
        for exchange in self.exchanges:
            exchange.destroy()
