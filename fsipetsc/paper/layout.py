"""What is known of layers on all ranks: their materials, a record of each, who owns which points.

The solution is one world vector; its part on a rank is the concatenation of the rank's parts of the
layers. A part has planes, one unknown of all points after the other: gas rho, rho u, e; solid u,
sigma, T, x.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.boundaries import Wall
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid, force_in
from fsipetsc.materials.solid import Elastic, Solid
from fsipetsc.operators.sbp import SBPOperator, row_length
from fsipetsc.paper.ends import OF_GAS, degree_of
from fsipetsc.parallel.block_shares import Extent, Share, share_out
from fsipetsc.problem import Problem
from fsipetsc.state import State, loose

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


class Gas(NamedTuple):
    """The material of a gas, as formulas: its laws are those of fsipetsc.materials.

    mu: 4/3 of the shear viscosity [Pa s]; kappa [W/(m K)]; force: body force per mass [m/s2].

    law: the equation of state, of rho, T, and the internal energy per mass e; transport: what mu
    and kappa are multiplied with.
    """

    law: Any
    transport: Any
    mu: float
    kappa: float
    gamma: float
    force: float

    def viscosity(self, T):
        """mu' = 4/3 mu(T)."""
        return self.mu * self.transport.viscosity(T)

    def conductivity(self, T):
        """kappa(T)."""
        return self.kappa * self.transport.conductivity(T)

    def velocity_and_temperature(self, rho, m, E):
        """(u, T) from (rho, rho u, e), the last one per volume."""
        u = m / rho
        return u, self.law.temperature(rho, E / rho - 0.5 * u * u)

    def total_energy(self, rho, u, T):
        """e, per volume."""
        return rho * (self.law.internal_energy(rho, T) + 0.5 * u * u)


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


def loose_forces(state: State) -> list[str]:
    """Forces that do not keep rest: frames are cut where walls are, and the couplings bring
    stresses together.
    """
    forced = [v for v in state.problem.layers if v.kind == "fluid" and any(v.material.force)]
    return [f"{loose(gas.name)}; -fsi_coupling conservative keeps rest" for gas in forced]
