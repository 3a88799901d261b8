"""Layers and interfaces: what all ranks know of them, a record and the material of each, and what a
rank has of them.

The solution is one world vector; its part on a rank is the concatenation of the rank's parts of the
layers. A part has planes, one unknown of all points after the other: gas rho, rho u, e; solid u,
sigma, T, x.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fsipetsc.boundaries import Wall
from fsipetsc.errors import InputError
from fsipetsc.kernels.procedure import Procedure
from fsipetsc.materials.fluid import Fluid, force_in
from fsipetsc.materials.solid import Elastic, Solid
from fsipetsc.operators.sbp import SBPOperator, row_length
from fsipetsc.paper import rates, steps
from fsipetsc.paper.coupling import Sides
from fsipetsc.paper.ends import OF_GAS, degree_of
from fsipetsc.paper.rates import Gas
from fsipetsc.paper.stencils import Stencils
from fsipetsc.parallel.block_shares import Extent, Share, share_out
from fsipetsc.parallel.exchange import Reach, Route
from fsipetsc.problem import Problem
from fsipetsc.state import Seen

Array = np.ndarray
#: kind of layer -> unknowns of a point
DOF = {"fluid": 3, "solid": 4}
#: points by which a gas may grow, beside an eighth of its own
SPARE = 16

#: what the paper's method has of options that choose between methods
HAS = {
    "fsi_mapping": ("auto", "rigid"),
    "fsi_dissipation": (0.0, -1.0),
    "fsi_shock": (0.0,),
    "fsi_convection": ("auto", "divergence"),
}
_I, _F = np.int64, np.float64
#: What procedures know of a layer. X = anchor + (i - anchor_index) h.
RECORD = np.dtype(
    [
        ("number", _I),  # of the layer, from the left
        ("present", _I),  # 1: this rank owns points of the layer
        ("n", _I),  # points, some of them held in reserve,
        ("lo", _I),  # the first and the last active one: in a gas interface point and ghost point
        ("hi", _I),
        ("least", _I),  # active points that the operator and the end conditions need
        ("anchor_index", _I),
        ("own_lo", _I),  # this rank owns own_lo <= i < own_hi
        ("own_hi", _I),
        ("halo_lo", _I),  # and has so many points of others before them
        ("h", _F),
        ("anchor", _F),
        ("s", _F),  # velocity of a gas's frame, that of its interface point
        ("x_interface", _F),  # x of a gas's interface
        ("outer", _I),  # which end of a gas is its boundary, 0 or 1
        # of what stands at the ends (fsipetsc.boundaries)
        ("end_x", _F, (2,)),  # of a boundary
        ("end_data", _F, (2, 4)),
        ("end_heat", _F, (2,)),  # the temperature or heat flux at the end of a solid
    ],
    align=True,
)


def law_of(material: Fluid | Solid) -> Gas | Elastic:
    """The material of a layer as formulas. InputError for a force of more than one dimension."""
    if not isinstance(material, Fluid):
        return material.elastic
    mu, kappa, gamma = 4.0 / 3.0 * material.mu, material.kappa, material.gamma
    (force,) = force_in(material.force, 1, "Fluid")
    return Gas(material.gas_law, material.transport_law, mu, kappa, gamma, force)


def check_form(problem: Problem, opt: Mapping[str, Any]) -> None:
    """InputError for options in force, or for a problem, that the paper's method does not have."""
    layers = problem.layers
    found = [f"-{name} {opt[name]}" for name, values in HAS.items() if opt[name] not in values]
    found += [f"{layer} has a spacing of its own" for layer in layers if layer.cells]
    found += [] if problem.interfaces else ["there is no interface"]
    two = len(layers) > 3 or sum(layer.kind == "solid" for layer in layers) > 1
    found += ["a gas lies between two solids"] * two
    for layer, end in ((layers[0], problem.left), (layers[-1], problem.right)):
        if isinstance(end, Wall) and (end.moves or end.heated):
            found.append(f"the wall of {layer} {'moves' if end.moves else 'is not insulated'}")
    if found:
        raise InputError(
            f"{found[0]}: the paper's couplings are of a solid between gases in rigid frames, on "
            "grids of one spacing: take -fsi_coupling conservative"
        )


def check_ends(problem: Problem, h: float) -> None:
    """InputError if the outer end of a gas is not where its X says, to within a cell of h [m]."""
    for side, end in enumerate((problem.left, problem.right)):
        layer, solid = problem.layers[-side], problem.layers[1 - 3 * side]
        if layer.kind == "fluid":
            x = solid.values("initial", np.array(solid.X))[3][side]  # of the interface
            wanted = layer.X[side] - layer.X[1 - side] + x
            if abs(end.x - wanted) > h:
                what = f"{layer}: its {type(end).__name__} stands at x = {end.x:g}"
                raise InputError(f"{what}, but X and the interface say x = {wanted:g}")


def make_records(problem: Problem, op: SBPOperator, h: float) -> Array:
    """What is the same on all ranks; a gas may grow by a third, or by an eighth and SPARE points.
    InputError where h does not fit the solid or a layer is too short for the closures.
    """
    records = np.zeros(len(problem.layers), RECORD)
    for k, layer in enumerate(problem.layers):
        record, fluid = records[k], layer.kind == "fluid"
        cells = layer.fitting(h)
        record["number"], record["h"], record["outer"] = k, h, k > 0
        record["end_x"] = [getattr(problem.end(k, side), "x", 0.0) for side in (0, 1)]
        room, least = 0, max(4, op.min_points)
        if fluid:
            # the ghost point is the first one at or beyond the boundary
            cells = int(np.ceil((layer.X[1] - layer.X[0]) / h - 1e-9))
            degree = degree_of(problem.left if k == 0 else problem.right, op.p)
            room = max(SPARE + max(1, cells // 8), cells // 3)
            # the treatment of the interface must not change the points of a boundary's formulas; a
            # new point takes one more than the degree of its extrapolation
            nodes = max(degree, *(end.new + 1 for end in OF_GAS.values()))
            least = max(op.min_points, nodes + 2, degree + 1 + row_length(op))
        first = room if k == 0 else 0  # spare points are on the outer side
        at_right = fluid and k == 0  # the anchor is the interface
        record["n"], record["least"] = cells + 1 + room, least
        record["lo"], record["hi"] = first, first + cells
        record["anchor"], record["anchor_index"] = layer.X[at_right], (first + cells) * at_right
        if cells + 1 < least:
            raise InputError(
                f"{layer} has {cells + 1} points with -fsi_h {h:g}; the {op.name} operator "
                f"(-fsi_order {op.order}) needs {least}: take a smaller -fsi_h or a lower order"
            )
    return records


def shares_of(
    size: int, problem: Problem, op: SBPOperator, records: Array, halo: int, mode: str
) -> list[Share]:
    """The share of each layer, for ``size`` ranks. Active points alone are work; the outermost rank
    of a gas has those in reserve. RanksError.
    """
    smallest, found = [max(halo, op.rows + 1)] * 3, []
    active = zip(problem.layers, (records["hi"] - records["lo"] + 1).tolist(), strict=True)
    extents = [Extent(layer.kind, (n,), (False,), *smallest) for layer, n in active]
    for record, share in zip(records, share_out(extents, size, mode), strict=True):
        cuts = [cut + int(record["lo"]) for cut in share.cuts[0][1:-1]]
        found.append(Share(share.ranks, ((0, *cuts, int(record["n"])),)))
    return found


def note_share(record: np.void, share: Share, rank: int, halo: int) -> int:
    """Note in the record what a rank owns. Returns how many points it has, with halos."""
    if rank not in share.ranks:
        return 0
    ((begin, end),), n = share.part(rank), int(record["n"])
    record["present"], record["own_lo"], record["own_hi"] = 1, begin, end
    record["halo_lo"] = min(halo, begin)
    return min(end + halo, n) - max(begin - halo, 0)


def used_up(record: Any, problem: Problem, op: SBPOperator, exhausted: bool) -> str:
    """Say that a gas has no points left, or else too few, and where it is; record: its own."""
    too_short = f"become too short (the {op.name} operator needs {int(record['least'])} points)"
    what = "used up its points" if exhausted else too_short
    m, x, end = problem.unit("m"), record["x_interface"], record["end_x"][record["outer"]]
    return (
        f"fluid {problem.layers[record['number']]} has {what}, with its interface at "
        f"x = {x:.6g}{m} and its boundary at x = {end:.6g}{m}"
    )


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

    def routes(self, me: int, memory: Array) -> list[Route]:
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
            found.append(Route(sent, {} if me == owner else {owner: frame}))
        reach = Reach(self.share, (False,), halo, False, False)
        points, own = reach.routes(me, len(self.local), 0, place_in(memory, self.local))
        of_memory = {rank: own.own[1][places] for rank, places in points.sent.items()}
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
                fields = [rho, rho * u, self.law.total_energy(rho, u, T)]
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
        about = solid.op, kind, gas.law, solid.law, self.side == 1, float(solid.record["h"])
        self.sides = Sides(*about, gas.records, points, firsts, self.jump, notes, k)
        self.routes = []  # each owner sends its own rows, the others go into the rooms
        if self.here[0] != self.here[1]:
            mine, other = self.here.index(True), self.here.index(False)
            beyond = owners[other]
            self.routes = [Route({beyond: places[mine]}, {beyond: places[other]})]


def place_in(memory: Array, part: Array) -> int:
    """Where the numbers of a part of a memory begin."""
    return (part.ctypes.data - memory.ctypes.data) // 8
