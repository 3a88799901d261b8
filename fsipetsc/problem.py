"""What a case says: the layers from left to right, what stands at the ends, initial and exact data.

All functions take arrays of Lagrangian coordinates X and, where they depend on time, t. A case
never sees a vector of PETSc's or a rank.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil, floor
from typing import Any

from fsipetsc.blame import place_of_caller
from fsipetsc.boundaries import Boundary, SolidEnd, Wall, closes, in_time
from fsipetsc.checks import Array, Fields, described, extent, function
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid

UNITS = ("SI", "none")


@dataclass(frozen=True)
class FluidLayer:
    """A layer of gas between X[0] and X[1]: one end is an interface, the other an embedded
    boundary.

    initial(X) -> (rho, u, T); exact(X, t) -> the same; forcing(X, t) -> right-hand sides of (rho,
    rho u, e).
    The coupling decides how the grid moves, see docs/cases.md; mapping, of older case files,
    changes nothing. InputError for what is of the wrong kind.
    """

    name: str
    material: Fluid
    X: tuple[float, float]
    initial: Callable[[Array], Fields]
    forcing: Callable[[Array, float], Fields] | None = None
    exact: Callable[[Array, float], Fields] | None = None
    mapping: str | None = None
    kind = "fluid"
    fields = ("rho", "u", "T", "p")

    def __post_init__(self) -> None:
        _check_layer(self, Fluid, "(rho, u, T)")


@dataclass(frozen=True)
class SolidLayer:
    """A solid between the Lagrangian coordinates X[0] and X[1].

    initial(X) -> (u, sigma, T, x); exact(X, t) -> the same; forcing(X, t) -> right-hand sides of
    the same. InputError for what is of the wrong kind.
    """

    name: str
    material: Solid
    X: tuple[float, float]
    initial: Callable[[Array], Fields]
    forcing: Callable[[Array, float], Fields] | None = None
    exact: Callable[[Array, float], Fields] | None = None
    kind = "solid"
    fields = ("u", "sigma", "T", "x", "p")

    def __post_init__(self) -> None:
        _check_layer(self, Solid, "(u, sigma, T, x)")

    def cells(self, h: float) -> int:
        """Cells of a spacing h [m]. InputError where it does not fit."""
        length = self.X[1] - self.X[0]
        width, cells = length / h, max(1, round(length / h))
        if abs(width - cells) > 1e-6 * max(1.0, width):
            fine, coarse = (length / max(1, n) for n in (ceil(width), floor(width)))
            raise InputError(
                f"-fsi_h {h:.10g} misses an interface: layer '{self.name}' of length {length:g} "
                f"would have {width:.6g} cells; the nearest spacings that fit are {fine:.10g} and "
                f"{coarse:.10g}"
            )
        return cells


Layer = FluidLayer | SolidLayer


def _check_layer(layer: Layer, material: type, values: str) -> None:
    """InputError for the first thing that is wrong with a layer; its X becomes two floats."""
    kind, name = type(layer).__name__, layer.name
    if not isinstance(name, str) or not name.isprintable() or not name.strip() or "|" in name:
        expected = "expected a text of one line without |"
        raise InputError(f"{kind}: name is {described(name)}: {expected}")
    what = f"{kind} '{name}'"
    if not isinstance(layer.material, material):
        found = described(layer.material)
        raise InputError(f"{what}: material is {found}: expected a {material.__name__}")
    object.__setattr__(layer, "X", extent(layer.X, what))
    object.__setattr__(layer, "place", place_of_caller())  # for what shows later
    function(layer.initial, f"{what}: initial", f"initial(X) -> {values}")
    function(layer.exact, f"{what}: exact", f"exact(X, t) -> {values}", optional=True)
    form = "forcing(X, t) -> the right-hand sides"
    function(layer.forcing, f"{what}: forcing", form, optional=True)


def _all_are(values: Any, kind: Any) -> bool:
    return isinstance(values, (tuple, list)) and all(isinstance(v, kind) for v in values)


@dataclass(frozen=True)
class Problem:
    """Layers that alternate between fluid and solid, left to right; one alone is enough.

    left, right: the conditions at the outer ends. jumps(k, t) -> (g_u, g_stress, g_T, g_flux) at
    interface k: u_s-u_f, sigma-p_s+p_f-mu' u_X, T_s-T_f, kappa_e/x_X T_X-kappa T_X; None where all
    are zero. notes: lines about the exact solution or the data that the result should carry.
    units: "SI", or "none" for a problem without dimensions. InputError for what does not fit
    together.
    """

    layers: tuple[Layer, ...]
    left: Boundary
    right: Boundary
    jumps: Callable[[int, float], tuple[float, float, float, float]] | None = None
    notes: tuple[str, ...] = ()
    units: str = "SI"
    dimension: int = field(default=1, init=False)

    def __post_init__(self) -> None:
        self._check_types()
        layers, kinds = self.layers, [layer.kind for layer in self.layers]
        if not kinds or any(a == b for a, b in zip(kinds, kinds[1:], strict=False)):
            what = "the layers must alternate between fluid and solid, and be one at least"
            raise InputError(f"{what}; got {kinds}")
        names = [layer.name for layer in layers]
        for name in names:
            if names.count(name) > 1:
                what = f"two layers are named '{name}'"
                raise InputError(f"Problem: {what}: expected a name for each, for results")
        for end, layer in ((self.left, layers[0]), (self.right, layers[-1])):
            if isinstance(end, SolidEnd) != (layer.kind == "solid"):
                gas, solid = "Wall, Open or Dirichlet", "clamped(…), free(…) or absorbing(…)"
                what = f"at the outer end of the {layer.kind} layer '{layer.name}' stands"
                fit = gas if layer.kind == "fluid" else solid
                raise InputError(f"{what} {described(end)}: expected {fit}")
        for a, b in zip(layers, layers[1:], strict=False):
            if abs(a.X[1] - b.X[0]) > 1e-12 * max(abs(a.X[1]), a.X[1] - a.X[0]):
                places = f"one ends at X = {a.X[1]:.10g}, the other begins at {b.X[0]:.10g}"
                what = f"layers '{a.name}' and '{b.name}' do not meet"
                raise InputError(f"{what}: {places}: expected the same X")

    def _check_types(self) -> None:
        """InputError for what is of the wrong kind; the layers become a tuple."""
        end, units = "an end, as Wall(x) or free(stress)", " or ".join(map(repr, UNITS))
        for name, good, expected in (
            ("layers", _all_are(self.layers, Layer), "a tuple of FluidLayer and SolidLayer"),
            ("left", isinstance(self.left, Boundary), end),
            ("right", isinstance(self.right, Boundary), end),
            ("notes", _all_are(self.notes, str), "a tuple of texts"),
            ("units", self.units in UNITS, units),
        ):
            if not good:
                found = described(getattr(self, name))
                raise InputError(f"Problem: {name} is {found}: expected {expected}")
        form = "jumps(k, t) -> (g_u, g_stress, g_T, g_flux)"
        function(self.jumps, "Problem: jumps", form, optional=True)
        object.__setattr__(self, "layers", tuple(self.layers))

    def unit(self, name: str) -> str:
        """The unit after a number in a message: " m", or nothing if the problem has no
        dimensions.
        """
        return f" {name}" if self.units == "SI" else ""

    @property
    def interfaces(self) -> tuple[tuple[int, int], ...]:
        """(fluid layer, solid layer) of each interface, left to right."""
        pairs = zip(range(len(self.layers)), range(1, len(self.layers)), strict=False)
        return tuple((a, b) if self.layers[a].kind == "fluid" else (b, a) for a, b in pairs)

    @property
    def interface_names(self) -> list[str]:
        """As "gas | rod", left to right."""
        pairs = zip(self.layers, self.layers[1:], strict=False)
        return [f"{a.name} | {b.name}" for a, b in pairs]

    @property
    def steady_data(self) -> bool:
        """No boundary data, jump or forcing that depends on time."""
        forced = self.jumps is not None or any(layer.forcing for layer in self.layers)
        return not forced and not any(in_time(end) for end in (self.left, self.right))

    @property
    def invariants(self) -> dict[str, Any]:
        """What must not change, as JSON holds it: see fsipetsc.scheme.conservation_check.Drifts,
        which takes it.

        masses: (name, numbers among the fluids) of the gas layers that nothing enters or leaves;
        energy: whether that of all layers is kept. Empty where forcing or jumps change all.
        """
        if self.jumps is not None or any(layer.forcing for layer in self.layers):
            return {}
        ends = (0, self.left), (len(self.layers) - 1, self.right)
        open_at = {k for k, end in ends if not isinstance(end, (Wall, SolidEnd))}
        fluids = [(k, v) for k, v in enumerate(self.layers) if isinstance(v, FluidLayer)]
        pulled = any(isinstance(v, SolidLayer) and v.material.force for v in self.layers)
        return {
            "masses": [[v.name, [i]] for i, (k, v) in enumerate(fluids) if k not in open_at],
            "energy": closes(self.left) and closes(self.right) and not pulled,
        }
