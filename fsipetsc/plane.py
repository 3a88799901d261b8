"""What a case in two dimensions says: the layers one above the other, what stands at their edges, initial and exact data.

All functions take arrays of reference coordinates X, Y of one shape, rows of equal Y, and, where they depend on time, t.
The grid of a solid is Lagrangian. That of a gas is straight in Y between the lines that its lower and its upper edge have
become.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from fsipetsc.blame import place_of_caller
from fsipetsc.boundaries import plane as edges
from fsipetsc.boundaries.plane import Edge, NoSlip, Periodic
from fsipetsc.checks import NONNEGATIVE, POSITIVE, Array, Fields, described, extent, function, number, numbers
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas, in_python
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.own_laws import check_energy
from fsipetsc.physics.plane.log_solid import log_solid
from fsipetsc.physics.plane.neo_hookean import neo_hookean
from fsipetsc.physics.plane.st_venant_kirchhoff import st_venant_kirchhoff

Initial = Callable[[Array, Array], Fields]
Timed = Callable[[Array, Array, float], Fields]
#: laws of solids by name
ELASTIC = {"log": log_solid, "neo-hookean": neo_hookean, "svk": st_venant_kirchhoff}
HEATS = ("coupled", "elastic")
PERIODIC, STICKS = Periodic(), NoSlip()


@dataclass(frozen=True)
class PlaneSolid:
    """Hyperelastic material in plane strain; see fsipetsc.physics.plane.solid.

    mu_e, lambda_e: Lame's constants [Pa]; kappa_e: heat conductivity [W/(m K)]; m0: density at rest [kg/m3]; alpha: specific
    heat [J/(kg K)]; p_ref: pressure under which it is free of strain [Pa]; law: "log" (the paper's), "neo-hookean", "svk",
    or what fsipetsc.physics.own_laws.elastic_law returns; heat: "coupled" (the paper's: what stresses do becomes heat) or
    "elastic" (beside an elastic energy). InputError for what is no number or out of range.
    """

    mu_e: float
    lambda_e: float
    kappa_e: float
    m0: float
    alpha: float
    p_ref: float = 0.0
    law: str | Formulas = "log"
    heat: str = "coupled"
    force: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        ranges = {"mu_e": NONNEGATIVE, "lambda_e": NONNEGATIVE, "kappa_e": NONNEGATIVE, "m0": POSITIVE, "alpha": POSITIVE}
        numbers(self, "PlaneSolid", {**ranges, "p_ref": ""})
        if not self.K > 0.0:
            raise InputError("PlaneSolid: mu_e and lambda_e are 0: expected one of them above 0")
        if not (hasattr(self.law, "modulus") if isinstance(self.law, Formulas) else self.law in tuple(ELASTIC)):
            known = f"{', '.join(map(repr, ELASTIC))}, or what elastic_law(…) returns"
            raise InputError(f"PlaneSolid: law is {described(self.law)}: expected {known}")
        if self.heat not in HEATS:
            raise InputError(f"PlaneSolid: heat is {described(self.heat)}: expected {' or '.join(map(repr, HEATS))}")
        if getattr(self.formulas, "own", False):
            if self.heat == "elastic" and not self.formulas.knows_energy:
                raise InputError("PlaneSolid: its law has no formula energy(c, F), which heat='elastic' needs")
            check_energy(self.formulas, self)
        object.__setattr__(self, "force", _force(self.force, "PlaneSolid"))

    @property
    def K(self) -> float:
        """2 mu_e + lambda_e [Pa]."""
        return 2.0 * self.mu_e + self.lambda_e

    @property
    def formulas(self) -> Formulas:
        """Those of the law."""
        return self.law if isinstance(self.law, Formulas) else ELASTIC[self.law]

    def stress(self, F: Fields) -> Fields:
        """(P_11, P_12, P_21, P_22) [Pa] for (F_11, F_12, F_21, F_22), by numpy."""
        stress: Fields = in_python(self.formulas.stress)(in_python(self.formulas.constants)(self), F)
        return stress


@dataclass(frozen=True)
class PlaneFluidLayer:
    """A layer of gas between Y[0] and Y[1].

    initial(X, Y) -> (rho, u, v, T); exact(X, Y, t) -> the same; forcing(X, Y, t) -> right-hand sides of (rho, rho u, rho v,
    e) at a point of the grid. left, right: its edges in X. beside: what the lower or upper edge is where the solid that it
    meets ends. cells: across the layer; None: as many as -fsi_h wants. force: body force per mass (x, y) [m/s2].
    InputError.
    """

    name: str
    material: Fluid
    Y: tuple[float, float]
    initial: Initial
    left: Edge = PERIODIC
    right: Edge = PERIODIC
    beside: Edge = STICKS
    cells: int | None = None
    force: tuple[float, float] = (0.0, 0.0)
    forcing: Timed | None = None
    exact: Timed | None = None
    kind = "fluid"
    fields = ("rho", "u", "v", "T", "p", "J", "x", "y")

    def __post_init__(self) -> None:
        _check_layer(self, Fluid, "(rho, u, v, T)", edges.GAS)
        object.__setattr__(self, "force", _force(self.force, f"PlaneFluidLayer '{self.name}'"))
        if self.material.force != 0.0:
            raise InputError(f"PlaneFluidLayer '{self.name}': expected force=(x, y) here, not in its material")


@dataclass(frozen=True)
class PlaneSolidLayer:
    """A solid between Y[0] and Y[1], and between X[0] and X[1] where it does not reach over the whole problem.

    initial(X, Y) -> (u, v, T, x, y); exact(X, Y, t) -> the same; forcing(X, Y, t) -> right-hand sides of the same. left,
    right, cells: as of PlaneFluidLayer. InputError.
    """

    name: str
    material: PlaneSolid
    Y: tuple[float, float]
    initial: Initial
    X: tuple[float, float] | None = None
    left: Edge = PERIODIC
    right: Edge = PERIODIC
    cells: int | None = None
    forcing: Timed | None = None
    exact: Timed | None = None
    kind = "solid"
    fields = ("u", "v", "T", "s_xx", "s_xy", "s_yy", "x", "y")

    def __post_init__(self) -> None:
        _check_layer(self, PlaneSolid, "(u, v, T, x, y)", edges.SOLID)
        if self.X is not None:
            object.__setattr__(self, "X", extent(self.X, f"PlaneSolidLayer '{self.name}'"))


Layer = PlaneFluidLayer | PlaneSolidLayer


def _force(value: Any, owner: str) -> tuple[float, float]:
    try:
        x, y = value
    except (TypeError, ValueError):
        raise InputError(f"{owner}: force is {described(value)}: expected (x, y), two numbers [m/s2]") from None
    return number(x, f"{owner}: force[0]"), number(y, f"{owner}: force[1]")


def _check_layer(layer: Layer, material: type, values: str, kinds: frozenset[int]) -> None:
    """InputError for the first thing that is wrong with a layer; its Y becomes two floats."""
    what = f"{type(layer).__name__} '{layer.name}'"
    if not isinstance(layer.name, str) or not layer.name.isprintable() or not layer.name.strip() or "|" in layer.name:
        raise InputError(f"{type(layer).__name__}: name is {described(layer.name)}: expected a text of one line without |")
    if not isinstance(layer.material, material):
        raise InputError(f"{what}: material is {described(layer.material)}: expected a {material.__name__}")
    object.__setattr__(layer, "Y", extent(layer.Y, what))
    object.__setattr__(layer, "place", place_of_caller())
    function(layer.initial, f"{what}: initial", f"initial(X, Y) -> {values}")
    function(layer.exact, f"{what}: exact", f"exact(X, Y, t) -> {values}", optional=True)
    function(layer.forcing, f"{what}: forcing", "forcing(X, Y, t) -> the right-hand sides", optional=True)
    for name in ("left", "right", "beside") if layer.kind == "fluid" else ("left", "right"):
        _check_edge(getattr(layer, name), f"{what}: {name}", kinds)
    if (layer.left.kind == edges.PERIODIC) != (layer.right.kind == edges.PERIODIC):
        raise InputError(f"{what}: one of left and right is Periodic: expected both or neither")
    if layer.cells is not None and (isinstance(layer.cells, bool) or not isinstance(layer.cells, int) or layer.cells < 1):
        raise InputError(f"{what}: cells is {described(layer.cells)}: expected a whole number above 0 or None")


def _check_edge(edge: object, what: str, kinds: frozenset[int]) -> None:
    if not isinstance(edge, Edge):
        raise InputError(f"{what} is {described(edge)}: expected an edge, as NoSlip() or Clamped()")
    if edges.moves(edge) and not what.startswith("PlaneProblem"):
        raise InputError(f"{what} moves: expected that of the lower or upper edge of the problem only")
    if edge.kind not in kinds:
        of = "solid" if edge.kind in edges.SOLID else "gas"
        raise InputError(f"{what} is {described(edge)}, an edge of a {of}")


@dataclass(frozen=True)
class PlaneProblem:
    """Layers that alternate between gas and solid, from below; one alone is enough.

    X: (left, right) [m]; lower, upper: what stands at the edges of the lowest and the topmost layer. jumps(k, X, t) ->
    (g_x, g_y, g_q): traction [Pa] and heat [W/m2] per reference length that interface k, between the layers k and k + 1,
    supplies from outside; None where it supplies none. notes, units: as of fsipetsc.problem.Problem. InputError for what
    does not fit together.
    """

    layers: tuple[Layer, ...]
    X: tuple[float, float]
    lower: Edge
    upper: Edge
    jumps: Callable[[int, Array, float], Fields] | None = None
    notes: tuple[str, ...] = ()
    units: str = "SI"
    dimension: int = field(default=2, init=False)

    def __post_init__(self) -> None:
        layers = tuple(self.layers)
        object.__setattr__(self, "layers", layers)
        object.__setattr__(self, "X", extent(self.X, "PlaneProblem"))
        if not layers or not all(isinstance(layer, (PlaneFluidLayer, PlaneSolidLayer)) for layer in layers):
            raise InputError("PlaneProblem: layers: expected one or more of PlaneFluidLayer and PlaneSolidLayer")
        for below, above in zip(layers, layers[1:], strict=False):
            if below.kind == above.kind:
                both = f"layers '{below.name}' and '{above.name}' are both {below.kind}"
                raise InputError(f"PlaneProblem: {both}: expected a solid next to a gas")
            if abs(below.Y[1] - above.Y[0]) > 1e-9 * (below.Y[1] - below.Y[0]):
                raise InputError(
                    f"PlaneProblem: layer '{below.name}' ends at Y = {below.Y[1]:g}, '{above.name}' begins at {above.Y[0]:g}"
                )
        periodic = {layer.left.kind == edges.PERIODIC for layer in layers if getattr(layer, "X", None) is None}
        if len(periodic) > 1:
            raise InputError("PlaneProblem: some layers are Periodic in X: expected all or none")
        for name, layer in (("lower", layers[0]), ("upper", layers[-1])):
            _check_edge(getattr(self, name), f"PlaneProblem: {name}", edges.GAS if layer.kind == "fluid" else edges.SOLID)
            if layer.kind == "solid" and edges.moves(getattr(self, name)):
                raise InputError(f"PlaneProblem: {name}: Given of a solid has x among its values: expected no other x")

    @property
    def periodic(self) -> bool:
        """Whether the layers go on in X."""
        return any(layer.left.kind == edges.PERIODIC for layer in self.layers)

    @property
    def interfaces(self) -> tuple[tuple[int, int], ...]:
        """(fluid layer, solid layer) of each interface, from below."""
        pairs = zip(range(len(self.layers)), range(1, len(self.layers)), strict=False)
        return tuple((a, b) if self.layers[a].kind == "fluid" else (b, a) for a, b in pairs)

    def slips(self, k: int) -> bool:
        """Whether gas layer k slips along solids: without viscosity nothing holds it."""
        return getattr(self.layers[k].material, "mu", None) == 0.0

    def span(self, k: int) -> tuple[float, float]:
        """(left, right) of layer k [m]."""
        return getattr(self.layers[k], "X", None) or self.X

    def edge(self, k: int, side: int) -> Edge | None:
        """What stands at the lower (0) or upper edge of layer k, None for an interface."""
        if side == 0:
            return self.lower if k == 0 else None
        return self.upper if k == len(self.layers) - 1 else None

    def unit(self, name: str) -> str:
        """What stands behind a number in a message: " m", or nothing if the problem has no dimensions."""
        return f" {name}" if self.units == "SI" else ""

    @property
    def invariants(self) -> dict[str, Any]:
        """What must not change: see fsipetsc.problem.Problem.invariants. Less what comes in through edges, masses, momentum
        and, where no solid is driven by data at its edges, the energy; the entropy where nothing comes in and stresses do
        not heat. Where a solid covers a part of X, the norms of gas and solid differ next to its ends: what these give each
        other is the same as far as that goes, and not to round-off.
        """
        if self.jumps is not None or any(layer.forcing for layer in self.layers):
            return {}
        fluids = [layer for layer in self.layers if isinstance(layer, PlaneFluidLayer)]
        closed = all(edges.holds_energy(end) for k in range(len(self.layers)) for end in self.edges(k))
        numbered = [(k, layer) for k, layer in enumerate(self.layers) if isinstance(layer, PlaneSolidLayer)]
        solids = [(layer.material, self._area(k)) for k, layer in numbered]
        driven = any(end.kind == edges.GIVEN for k, _ in numbered for end in self.edges(k))
        whole = all(self.span(k) == self.X for k in range(len(self.layers)))
        return {
            "masses": [[layer.name, number] for number, layer in enumerate(fluids)],
            "momentum": whole,
            "energy": whole and not driven,
            "entropy": closed and all(solid.heat == "elastic" for solid, _ in solids),
            "inertia": sum(solid.m0 * area for solid, area in solids),
            "heat_capacity": sum(solid.m0 * solid.alpha * area for solid, area in solids),
            "cv": [layer.material.cv for layer in fluids],
        }

    def _area(self, k: int) -> float:
        (left, right), (low, high) = self.span(k), self.layers[k].Y
        return (right - left) * (high - low)

    def edges(self, k: int) -> list[Edge]:
        """What stands at the edges of layer k but for interfaces."""
        layer = self.layers[k]
        beside = [layer.beside] if isinstance(layer, PlaneFluidLayer) else []
        return [end for end in (self.edge(k, 0), self.edge(k, 1), layer.left, layer.right, *beside) if end is not None]

    @property
    def steady_data(self) -> bool:
        """No boundary data or forcing that depends on time."""
        ends = [end for k in range(len(self.layers)) for end in self.edges(k)]
        timed = any(callable(getattr(end, "T", None)) or end.kind == edges.GIVEN or edges.moves(end) for end in ends)
        return not timed and self.jumps is None and all(layer.forcing is None for layer in self.layers)
