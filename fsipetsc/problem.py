"""What a case says: the layers from left to right, what stands at the ends, initial and exact data.

All functions take arrays of Lagrangian coordinates X and, where they depend on time, t. A case
never sees a vector of PETSc's or a rank.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, InitVar, dataclass, field
from math import ceil, floor
from typing import Any, ClassVar

import numpy as np

from fsipetsc import checks
from fsipetsc.blame import place_of, place_of_caller
from fsipetsc.blocks.conditions import steady
from fsipetsc.blocks.values import NOWHERE, block_values, checked
from fsipetsc.boundaries import Boundary
from fsipetsc.checks import Array, Fields, check_name, described, extent, function
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import Solid

#: what can stand at the outer end of a layer
ENDS = {"fluid": "Wall, Open or Dirichlet", "solid": "clamped(…), free(…) or absorbing(…)"}


@dataclass(frozen=True)
class _Layer:
    """What a layer of gas and one of a solid have. cells: between its ends, or h: their size [m],
    to which the nearest that fits is taken; None: by -fsi_h. fields: names of what is saved of it;
    unknowns: of a solid, what all functions return. material_class: what its material must be.
    """

    name: str
    material: Any
    X: tuple[float, float]
    initial: Callable[[Array], Fields]
    forcing: Callable[[Array, float], Fields] | None = None
    exact: Callable[[Array, float], Fields] | None = None
    _: KW_ONLY
    cells: int | None = None
    h: InitVar[float | None] = None
    material_class: ClassVar[type]
    fields: ClassVar[tuple[str, ...]]

    def __post_init__(self, h: float | None) -> None:
        kind, wanted = type(self).__name__, self.material_class
        check_name(self.name, kind)
        what = f"{kind} '{self.name}'"
        if not isinstance(self.material, wanted):
            found = described(self.material)
            raise InputError(f"{what}: material is {found}: expected a {wanted.__name__}")
        object.__setattr__(self, "X", extent(self.X, what))
        object.__setattr__(self, "cells", checks.own_cells(self.cells, h, self.X, what))
        object.__setattr__(self, "place", place_of_caller())  # for what shows later
        form = f"initial(X) -> ({', '.join(self.fields[:-1])})"
        function(self.initial, f"{what}: initial", form)
        function(self.exact, f"{what}: exact", "exact(X, t) -> the same", optional=True)
        form = "forcing(X, t) -> the right-hand sides"
        function(self.forcing, f"{what}: forcing", form, optional=True)

    def __str__(self) -> str:
        return f"layer '{self.name}'"

    def values(self, what: str, X: Array, t: float, active: slice = slice(None)) -> list[Array]:
        """Values of initial, exact or forcing at points X (n,); see fsipetsc.blocks.values.

        They count at the active points only: what a function gives for points that the grid holds
        in reserve may be anything of the right shape. InputError, perhaps on this rank alone.
        """
        return block_values(self, what, X[None], t, active)

    def first_values(self, X: Array, active: slice = slice(None)) -> list[Array]:
        """The initial data. InputError, perhaps on this rank alone."""
        return self.values("initial", X, 0.0, active)

    def fitting(self, h: float) -> int:
        """Cells of the size h [m] that -fsi_h says. InputError."""
        return checks.cells_of(self.X, h, f"-fsi_h {h:g}: {self}")


@dataclass(frozen=True)
class FluidLayer(_Layer):
    """A layer of gas in one dimension.

    X are coordinates of a grid that moves; the [coupling](cases.md#one-dimension-layers-and-ends)
    decides how. Functions get an array of coordinates, (n,) [m], and t [s]; each number that they
    return is an array of that shape or a float.

    Args:
        name: name of the layer, without |.
        material: a `Fluid`.
        X: (left, right) at the start [m].
        initial: `initial(X)` returns rho [kg/m3], u [m/s], T [K].
        forcing: `forcing(X, t)` returns the right-hand sides of rho [kg/(m3 s)], rho u [N/m3] and
            the energy per volume e [W/m3]; None: 0.
        exact: `exact(X, t)` returns what `initial` does, where an exact solution is known.
        cells: number of cells between its ends; None: by h.
        h: size of the cells [m], to which the nearest that fits is taken; None: -fsi_h.
        mapping: of older case files; it changes nothing.
    """

    mapping: str | None = None
    kind = "fluid"
    material_class = Fluid
    fields = ("rho", "u", "T", "p")


@dataclass(frozen=True)
class SolidLayer(_Layer):
    """A layer of an elastic solid in one dimension, in Lagrangian coordinates X.

    Functions get an array of coordinates, (n,) [m], and t [s]; each number that they return is an
    array of that shape or a float.

    Args:
        name: name of the layer, without |.
        material: a `Solid`.
        X: (left, right) [m]; the length is a multiple of `-fsi_h`.
        initial: `initial(X)` returns u [m/s], sigma [Pa], T [K], x [m]; x rises with X.
        forcing: `forcing(X, t)` returns the right-hand sides of the same, per second; None: 0.
        exact: `exact(X, t)` returns what `initial` does, where an exact solution is known.
        cells: number of cells between its ends; None: by h.
        h: size of the cells [m], to which the nearest that fits is taken; None: -fsi_h.
    """

    kind = "solid"
    material_class = Solid
    fields = ("u", "sigma", "T", "x", "p")
    unknowns = fields[:-1]

    def first_values(self, X: Array, active: slice = slice(None)) -> list[Array]:
        """The initial data; x must rise. InputError, perhaps on this rank alone."""
        found = super().first_values(X, active)
        if not np.all(rises := np.diff(found[3][active]) > 0):
            at = f"after X = {X[active][np.argmin(rises)]:.6g}: expected positions [m]"
            where = f"{place_of(self.initial)}: initial of {self}"
            raise InputError(f"{where}: x does not rise with X {at}", collective=False)
        return found

    def fitting(self, h: float) -> int:
        """The same, which end at its interfaces. InputError where they do not."""
        length, cells = self.X[1] - self.X[0], super().fitting(h)
        width = length / h
        if abs(width - cells) > 1e-6 * max(1.0, width):
            near = sorted({max(1, floor(width)), ceil(width)})
            raise InputError(
                f"-fsi_h {h:.10g} misses an interface: {self} of length {length:g} would have "
                f"{width:.6g} cells; {' and '.join(f'{length / n:.10g}' for n in near)} would fit, "
                "or the layer may have cells=… of its own"
            )
        return cells


@dataclass(frozen=True)
class Problem:
    """A problem in one dimension: layers of gas and solid in turn, from left to right.

    Args:
        layers: one or more of `FluidLayer` and `SolidLayer`, with different names.
        left: the condition at the left end: `Wall`, `Open` or `Dirichlet` of a gas, `clamped`,
            `free` or `absorbing` of a solid.
        right: that at the right end.
        jumps: `jumps(k, t)` returns what is prescribed at interface k, counted from the left, at
            t [s], solid less gas: the jumps of velocity [m/s], stress [Pa], temperature [K] and
            heat flux [W/m2], which are u_s - u_f, sigma - p_s + p_f - mu' u_X, T_s - T_f,
            kappa_e/x_X T_X - kappa T_X. None: all are 0.
        notes: lines about the exact solution or the data, which the result carries.
        units: "SI", or "none" for a problem without dimensions.
    """

    layers: Sequence[FluidLayer | SolidLayer]
    left: Boundary
    right: Boundary
    jumps: Callable[[int, float], Sequence[Any]] | None = None
    notes: Sequence[str] = ()
    units: str = "SI"
    dimension: int = field(default=1, init=False)

    def __post_init__(self) -> None:
        given = self.layers
        if not isinstance(given, (tuple, list)) or not all(isinstance(v, _Layer) for v in given):
            expected = "expected a tuple of FluidLayer and SolidLayer"
            raise InputError(f"Problem: layers is {described(given)}: {expected}")
        object.__setattr__(self, "layers", tuple(given))
        form = "jumps(k, t) -> (g_u, g_stress, g_T, g_flux)"
        function(self.jumps, "Problem: jumps", form, optional=True)
        layers, kinds = self.layers, [layer.kind for layer in self.layers]
        if not kinds or any(a == b for a, b in zip(kinds, kinds[1:])):
            what = "the layers must alternate between fluid and solid, and be one at least"
            raise InputError(f"{what}; got {kinds}")
        names = [layer.name for layer in layers]
        if twice := [name for name in names if names.count(name) > 1]:
            what = f"two layers are named '{twice[0]}'"
            raise InputError(f"Problem: {what}: expected a name for each, for results")
        for end, layer in ((self.left, layers[0]), (self.right, layers[-1])):
            if getattr(end, "of", None) != layer.kind:
                stands = f"{type(end).__name__}(…)" if isinstance(end, Boundary) else described(end)
                what = f"at the outer end of the {layer.kind} {layer} stands {stands}"
                raise InputError(f"{what}: expected {ENDS[layer.kind]}")
        for a, b in zip(layers, layers[1:]):
            if abs(a.X[1] - b.X[0]) > 1e-12 * max(abs(a.X[1]), a.X[1] - a.X[0]):
                places = f"one ends at X = {a.X[1]:.10g}, the other begins at {b.X[0]:.10g}"
                what = f"layers '{a.name}' and '{b.name}' do not meet"
                raise InputError(f"{what}: {places}: expected the same X")

    def unit(self, name: str) -> str:
        """The unit after a number in a message: " m", or nothing without dimensions."""
        return f" {name}" if self.units == "SI" else ""

    def end(self, k: int, side: int) -> Boundary | None:
        """What stands at the left (0) or right (1) end of layer k, None where a layer does."""
        outer = {(0, 0): self.left, (len(self.layers) - 1, 1): self.right}
        return outer.get((k, side))

    def jumps_at(self, k: int, t: float) -> list[float]:
        """The prescribed jumps at interface k at time t [s]. InputError."""
        names = "g_u", "g_stress", "g_T", "g_flux"
        where = f"jumps at interface {k} at t = {t:.6g}"
        assert self.jumps is not None
        return [float(g[0]) for g in checked(self.jumps, (k, t), NOWHERE, names, where)]

    @property
    def interfaces(self) -> tuple[tuple[int, int], ...]:
        """(fluid layer, solid layer) of each interface, left to right."""
        pairs = zip(range(len(self.layers)), range(1, len(self.layers)))
        return tuple((a, b) if self.layers[a].kind == "fluid" else (b, a) for a, b in pairs)

    @property
    def interface_names(self) -> list[str]:
        """As "gas | rod", left to right."""
        return [f"{a.name} | {b.name}" for a, b in zip(self.layers, self.layers[1:])]

    @property
    def steady_data(self) -> bool:
        """No boundary data, jump or forcing that depends on time."""
        forced = self.jumps is not None or any(layer.forcing for layer in self.layers)
        return not forced and steady(self.left) and steady(self.right)

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
        open_at = {k for k, end in ends if end.passes}
        fluids = [(k, v) for k, v in enumerate(self.layers) if isinstance(v, FluidLayer)]
        pulled = any(np.any(layer.material.force) for layer in self.layers)
        return {
            "masses": [[v.name, [i]] for i, (k, v) in enumerate(fluids) if k not in open_at],
            "energy": self.left.closed and self.right.closed and not pulled,
        }
