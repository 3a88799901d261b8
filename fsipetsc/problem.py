"""Problems in one dimension: layers of gas and solid from left to right, with ends.

The paper's method takes a `Problem` as it is; for all else its layers become blocks.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import wraps
from itertools import pairwise
from math import ceil, floor
from typing import Any, ClassVar

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.maps import rectangle
from fsipetsc.boundaries import Boundary, Wall
from fsipetsc.checks import Array, Fields, block_values, cells_of, check, described, extent
from fsipetsc.errors import InputError
from fsipetsc.kernels.symbols import Symbol
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid, Solid
from fsipetsc.operators.sbp import OPERATORS

Function = Callable[..., Any]


@dataclass(frozen=True)
class _Layer:
    """What layers of both kinds have. fields: names of what is saved of a point."""

    name: str
    material: Any
    X: tuple[float, float]
    initial: Callable[[Array], Fields]
    forcing: Callable[[Array, float], Fields] | None = None
    exact: Callable[[Array, float], Fields] | None = None
    _: KW_ONLY
    cells: int | None = None
    kind: ClassVar[str]
    material_class: ClassVar[type]
    fields: ClassVar[tuple[str, ...]]

    def __post_init__(self) -> None:
        what, wanted = f"{type(self).__name__} {described(self.name)}", self.material_class
        if not isinstance(self.material, wanted):
            found = described(self.material)
            raise InputError(f"{what}: material is {found}: expected a {wanted.__name__}")
        object.__setattr__(self, "X", extent(self.X, what))
        kinds = {"name": "name", "cells": "cells", "initial": "function"}
        for name, kind in {**kinds, "forcing": "optional", "exact": "optional"}.items():
            check(kind, getattr(self, name), f"{what}: {name}")

    def __str__(self) -> str:
        return f"layer '{self.name}'"

    def values(self, what: str, X: Array, t: float = 0.0) -> list[Array]:
        """See ``block_values``; X (n,)."""
        return block_values(self, what, X[None], t)

    def fitting(self, h: float) -> int:
        """Cells of the size h [m] that -fsi_h says; a solid must end at a point. InputError."""
        length, cells = self.X[1] - self.X[0], cells_of(self.X, h, f"-fsi_h {h:g}: {self}")
        if self.kind == "solid" and abs(length / h - cells) > 1e-6 * max(1.0, length / h):
            near = sorted({max(1, floor(length / h)), ceil(length / h)})
            fits = " and ".join(f"{length / n:.10g}" for n in near)
            wrong = f"-fsi_h {h:.10g} misses an interface: the length of {self} is {length:.10g}"
            raise InputError(f"{wrong}; {fits} would fit, or cells=… of its own")
        return cells


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
        cells: number of cells between its ends; None: by -fsi_h.
        mapping: of older case files; it changes nothing.
    """

    mapping: str | None = None
    kind = "fluid"
    material_class = Fluid
    fields = ("rho", "u", "T", "p")


@dataclass(frozen=True)
class SolidLayer(_Layer):
    """A layer of an elastic solid in one dimension, in Lagrangian coordinates X.

    Args:
        name: as of `FluidLayer`.
        material: a `Solid`.
        X: (left, right) [m]; without `cells` the length is a multiple of `-fsi_h`.
        initial: `initial(X)` returns u [m/s], sigma [Pa], T [K], x [m]; x rises with X.
        forcing: `forcing(X, t)` returns the right-hand sides of the same, per second; None: 0.
        exact: as of `FluidLayer`.
        cells: as of `FluidLayer`.
    """

    kind = "solid"
    material_class = Solid
    fields = ("u", "sigma", "T", "x", "p")
    unknowns = fields[:-1]


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
    dimension: ClassVar[int] = 1
    invariants: ClassVar[dict[str, Any]] = {}  # the paper's method keeps none to round-off

    def __post_init__(self) -> None:
        check("units", self.units, "Problem: units")
        check("optional", self.jumps, "Problem: jumps")
        given = self.layers
        if not isinstance(given, (tuple, list)) or not all(isinstance(v, _Layer) for v in given):
            expected = "expected a tuple of FluidLayer and SolidLayer"
            raise InputError(f"Problem: layers is {described(given)}: {expected}")
        object.__setattr__(self, "layers", tuple(given))
        kinds, names = [v.kind for v in given], [v.name for v in given]
        if not kinds or any(a == b for a, b in pairwise(kinds)) or len({*names}) < len(names):
            expected = "expected fluid and solid in turn, each with a name of its own"
            raise InputError(f"Problem: layers are {kinds}, {names}: {expected}")
        for layer, end in ((given[0], self.left), (given[-1], self.right)):
            if getattr(end, "of", None) != layer.kind:
                found = f"at the outer end of {layer} stands {described(end)}"
                raise InputError(f"{found}: expected an end of a {layer.kind}")
        for a, b in pairwise(given):
            if abs(a.X[1] - b.X[0]) > 1e-12 * max(abs(a.X[1]), a.X[1] - a.X[0]):
                begins = f"{b} begins at {b.X[0]:.10g}"
                raise InputError(f"{a} ends at X = {a.X[1]:.10g}, {begins}: expected the same")

    def unit(self, name: str) -> str:
        """ " m" after a number in a message, or nothing without dimensions."""
        return f" {name}" if self.units == "SI" else ""

    def ends(self, k: int) -> tuple[Boundary | None, Boundary | None]:
        """What stands at the left and the right end of layer k, None where a layer does."""
        return self.left if k == 0 else None, self.right if k == len(self.layers) - 1 else None

    @property
    def interface_names(self) -> list[str]:
        """As "gas | rod", left to right."""
        return [f"{a.name} | {b.name}" for a, b in pairwise(self.layers)]

    @property
    def steady_data(self) -> bool:
        """No boundary data, jump or forcing that depends on time."""
        forced = self.jumps is not None or any(layer.forcing for layer in self.layers)
        return not forced and self.left.steady and self.right.steady


def check_place(layer: Any, end: Any, x: float, nearest: float) -> None:
    """InputError if an end of a gas is not this near to x [m]: its grid would have another mass."""
    if abs(end.x - x) > nearest:
        what = f"{layer}: its {type(end).__name__} stands at x = {end.x:g}"
        raise InputError(f"{what}: expected the end of its grid, {x:g}")


def blocks_of_line(problem: Problem, h: float, order: int) -> BlockProblem:
    """A problem of layers as blocks. h: spacing [m] of layers without cells of their own; order: of
    the operators. InputError where h does not fit, or for what only the paper's method has.
    """
    blocks, least = [], OPERATORS[order].min_points - 1
    if problem.jumps is not None:
        raise InputError(
            "Problem: jumps of layers are for -fsi_coupling projection, energy, traditional"
        )
    for k, layer in enumerate(problem.layers):
        cells = layer.cells or layer.fitting(h)
        if layer.kind == "solid":
            blocks.append(_solid(layer, cells))
            continue
        for x, end in zip(layer.X, problem.ends(k), strict=True):
            if end is not None and not (isinstance(end, Wall) and end.moves):
                check_place(layer, end, x, 1e-9 * (layer.X[1] - layer.X[0]))
        of = layer.material, rectangle(*layer.X), (layer.cells or max(cells, least),)
        blocks.append(Block(layer.name, *of, layer.initial, layer.forcing, layer.exact))
    ends = zip((0, 1), (problem.left, problem.right), (blocks[0], blocks[-1]), strict=True)
    faces = {(of.name, 0, side): end.condition(of.material) for side, end, of in ends}
    return BlockProblem(blocks, faces, notes=problem.notes, units=problem.units)


def _solid(layer: Any, cells: int) -> Block:
    """A layer of a solid; the stress of its material is K ln x_X - p_ref less its pressure."""
    (low, high), exact, of = layer.X, layer.exact, layer.material
    x = layer.values("initial", X := np.linspace(low, high, cells + 1))[3]
    if not np.all(rises := np.diff(x) > 0):
        raise InputError(f"{layer}: its x does not rise after X = {X[np.argmin(rises)]:.6g}")
    stress = _prestress(layer, cells)
    (found,) = stress(X)
    uniform = np.ptp(found) == 0.0
    numbers = 0.0, of.K, of.kappa_e, of.m0, of.alpha, -float(found[0]) if uniform else 0.0
    return Block(
        layer.name,
        ElasticSolid(*numbers, force=of.force, pressing=of.pressure_law),
        rectangle(low, high),
        (cells,),
        _picked(layer.initial, 0, 2, 3),
        forcing=layer.forcing and _forces_alone(layer),
        exact=exact and _picked(exact, 0, 2, 3),
        exact_stress=exact and _picked(exact, 1),
        prestress=None if uniform else stress,
    )


def _picked(function: Function, *numbers: int) -> Function:
    return wraps(function)(lambda *where: [function(*where)[n] for n in numbers])


def _forces_alone(layer: Any) -> Function:
    """The forcing of a solid without that of its stress, which must be 0. InputError."""

    @wraps(layer.forcing)
    def called(X: Any, t: Any) -> Any:
        u, sigma, T, x = layer.forcing(X, t)
        wrong = np.abs(sigma) > 1e-9 * layer.material.K  # but for round-off
        if not isinstance(wrong, Symbol) and np.any(wrong):
            what = f"forcing of {layer} at t = {t:.6g}: sigma has a right-hand side, but follows"
            expected = "from x here: expected 0, or -fsi_coupling projection"
            raise InputError(f"{what} {expected}", collective=False)
        return u, T + np.where(wrong, np.nan, 0.0), x  # where it is recorded, the step fails

    return called


def _prestress(layer: Any, cells: int) -> Function:
    """What the initial stress of a solid is beside K ln x_X [Pa]: a function of X.

    x_X is that of polynomials of sixth degree through x, in steps of half a cell at most.
    """
    (low, high), initial, K = layer.X, layer.initial, layer.material.K
    step, points = min(1e-3, 0.5 / cells) * (high - low), np.arange(-3.0, 4.0)
    powers = np.linalg.inv(np.vander(points, increasing=True))

    def found(X: Array) -> tuple[Array]:
        middle = np.clip(X, low + 3 * step, high - 3 * step)
        around, z = [middle + j * step for j in points], (X - middle) / step
        moved = [initial(place)[3] - place for place in around]
        # sums of their own: those of a library's product of matrices depend on how many X there are
        c = [sum(map(np.multiply, row, moved)) for row in powers]
        stretch = 1.0 + sum(k * c[k] * z ** (k - 1) for k in range(1, len(c))) / step
        return (initial(X)[1] - K * np.log(stretch),)

    return found
