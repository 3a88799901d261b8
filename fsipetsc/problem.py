"""What a case says: the layers from left to right, what stands at the ends, initial and exact data.

All functions take arrays of Lagrangian coordinates X and, where they depend on time, t. A case
never sees a vector of PETSc's or a rank.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NoReturn

from fsipetsc.blame import place_of_caller
from fsipetsc.boundaries import Boundary, SolidEnd, Wall, closes, in_time, needs_stretching
from fsipetsc.checks import Array, Fields, described, extent, function
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid

UNITS = ("SI", "none")
#: what the grid of a gas does: it goes with the interface, over the embedded boundary; or it is
#: stretched between its ends
MAPPINGS = ("rigid", "stretched")


@dataclass(frozen=True)
class FluidLayer:
    """A layer of gas between X[0] and X[1]: one end is an interface, the other an embedded
    boundary.

    initial(X) -> (rho, u, T); exact(X, t) -> the same; forcing(X, t) -> right-hand sides of (rho,
    rho u, e).
    mapping: one of MAPPINGS, or None for that of -fsi_mapping. Rigid: at time t the gas at X
    stands at x = X - X_I + x_I, I its interface: see docs/cases.md; outside X[0], X[1] the
    functions are asked for points that the grid holds in reserve. Stretched: it stands at x_0 + (X
    - X[0]) (x_1 - x_0) / (X[1] - X[0]) between the places x_0, x_1 of its ends. InputError for
    what is of the wrong kind.
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
        if self.mapping is not None and self.mapping not in MAPPINGS:
            known = " or ".join(map(repr, MAPPINGS))
            raise InputError(
                f"FluidLayer '{self.name}': mapping is {described(self.mapping)}: "
                f"expected {known} or None"
            )


@dataclass(frozen=True)
class SolidLayer:
    """A solid between the Lagrangian coordinates X[0] and X[1].

    initial(X) -> (u, sigma, T, x); exact(X, t) -> the same; forcing(X, t) -> right-hand sides of
    the same. InputError for
    what is of the wrong kind.
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


def _check_layer(layer: Layer, material: type, values: str) -> None:
    """InputError for the first thing that is wrong with a layer; its X becomes two floats."""
    kind = type(layer).__name__
    if (
        not isinstance(layer.name, str)
        or not layer.name.isprintable()
        or not layer.name.strip()
        or "|" in layer.name
    ):
        raise InputError(
            f"{kind}: name is {described(layer.name)}: expected a text of one line without |"
        )
    what = f"{kind} '{layer.name}'"
    if not isinstance(layer.material, material):
        raise InputError(
            f"{what}: material is {described(layer.material)}: expected a {material.__name__}"
        )
    object.__setattr__(layer, "X", extent(layer.X, what))
    object.__setattr__(layer, "place", place_of_caller())  # for what shows later
    function(layer.initial, f"{what}: initial", f"initial(X) -> {values}")
    function(layer.exact, f"{what}: exact", f"exact(X, t) -> {values}", optional=True)
    function(
        layer.forcing, f"{what}: forcing", "forcing(X, t) -> the right-hand sides", optional=True
    )


Layer = FluidLayer | SolidLayer


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
        self._check_kinds()
        layers = self.layers
        kinds = [layer.kind for layer in layers]
        if not kinds or any(a == b for a, b in zip(kinds, kinds[1:], strict=False)):
            what = "the layers must alternate between fluid and solid, and be one at least"
            raise InputError(f"{what}; got {kinds}")
        for end, layer in ((self.left, layers[0]), (self.right, layers[-1])):
            if isinstance(end, SolidEnd) != (layer.kind == "solid"):
                gas, solid = "Wall, Open or Dirichlet", "clamped(…), free(…) or absorbing(…)"
                what = f"at the outer end of the {layer.kind} layer '{layer.name}' stands"
                fit = gas if layer.kind == "fluid" else solid
                raise InputError(f"{what} {described(end)}: expected {fit}")
        for k, layer in enumerate(layers):
            if getattr(layer, "mapping", None) == "rigid" and not self._may_be_rigid(k):
                raise InputError(
                    f"layer '{layer.name}' has mapping='rigid': expected 'stretched' or None, "
                    "because it has not one interface and one end that insulates and stays there"
                )
        for a, b in zip(layers, layers[1:], strict=False):
            if abs(a.X[1] - b.X[0]) > 1e-12 * max(abs(a.X[1]), a.X[1] - a.X[0]):
                places = f"one ends at X = {a.X[1]:.10g}, the other begins at {b.X[0]:.10g}"
                what = f"layers '{a.name}' and '{b.name}' do not meet"
                raise InputError(f"{what}: {places}: expected the same X")

    def _check_kinds(self) -> None:
        layers, notes, kinds = self.layers, self.notes, (FluidLayer, SolidLayer)
        if isinstance(layers, str) or not isinstance(layers, Sequence):
            _refuse("layers", layers, "a tuple of FluidLayer and SolidLayer")
        for k, layer in enumerate(layers):
            if not isinstance(layer, kinds):
                _refuse(f"layers[{k}]", layer, "a FluidLayer or a SolidLayer")
            if layer.name in (other.name for other in layers[:k]):
                what = f"two layers are named '{layer.name}'"
                raise InputError(f"Problem: {what}: expected a name for each, for results")
        for name, end in (("left", self.left), ("right", self.right)):
            if not isinstance(end, Boundary):
                _refuse(name, end, "an end, as Wall(x) or free(stress)")
        form = "jumps(k, t) -> (g_u, g_stress, g_T, g_flux)"
        function(self.jumps, "Problem: jumps", form, optional=True)
        if not isinstance(notes, (tuple, list)) or not all(isinstance(n, str) for n in notes):
            _refuse("notes", notes, "a tuple of texts")
        if self.units not in UNITS:
            _refuse("units", self.units, " or ".join(map(repr, UNITS)))
        object.__setattr__(self, "layers", tuple(layers))

    def _may_be_rigid(self, k: int) -> bool:
        """Whether a gas has one interface and one end, which insulates and stays where it is."""
        last = len(self.layers) - 1
        ends = [end for at, end in ((0, self.left), (last, self.right)) if at == k]
        return len(ends) == 1 and not needs_stretching(ends[0])

    def unit(self, name: str) -> str:
        """What stands behind a number in a message: " m", or nothing if the problem has no
        dimensions.
        """
        return f" {name}" if self.units == "SI" else ""

    @property
    def interfaces(self) -> tuple[tuple[int, int], ...]:
        """(fluid layer, solid layer) of each interface, left to right."""
        pairs = zip(range(len(self.layers)), range(1, len(self.layers)), strict=False)
        return tuple((a, b) if self.layers[a].kind == "fluid" else (b, a) for a, b in pairs)

    @property
    def steady_data(self) -> bool:
        """No boundary data, jump or forcing that depends on time."""
        timed = any(in_time(end) for end in (self.left, self.right))
        return (
            not timed and self.jumps is None and all(layer.forcing is None for layer in self.layers)
        )

    @property
    def invariants(self) -> dict[str, Any]:
        """What must not change, as JSON holds it: see fsipetsc.scheme.conservation_check.drifts,
        which takes it.

        masses: (name, number among the fluids) of the gas layers that nothing enters or leaves;
        inertia [kg/m2] and heat_capacity [J/(m2 K)] of the solids, cv of the gases: what is large
        there; energy: whether that of all layers is kept. Momentum less the impulse of ends and
        body forces always is. Empty where forcing or jumps change all.
        """
        if self.jumps is not None or any(layer.forcing for layer in self.layers):
            return {}
        last = len(self.layers) - 1
        open_at = {
            k
            for k, end in ((0, self.left), (last, self.right))
            if not isinstance(end, (Wall, SolidEnd))
        }
        fluids = [
            (k, layer) for k, layer in enumerate(self.layers) if isinstance(layer, FluidLayer)
        ]
        solids = [layer for layer in self.layers if isinstance(layer, SolidLayer)]
        closed = closes(self.left) and closes(self.right)
        return {
            "masses": [[layer.name, i] for i, (k, layer) in enumerate(fluids) if k not in open_at],
            "inertia": sum(v.material.m0 * (v.X[1] - v.X[0]) for v in solids),
            "heat_capacity": sum(
                v.material.alpha * v.material.m0 * (v.X[1] - v.X[0]) for v in solids
            ),
            "cv": [layer.material.cv for _, layer in fluids],
            "energy": closed
            and not any(getattr(layer.material, "force", 0.0) for layer in self.layers),
        }


def _refuse(name: str, value: Any, expected: str) -> NoReturn:
    raise InputError(f"Problem: {name} is {described(value)}: expected {expected}")
