"""A block: a logical cube of nodes with a map, a material and initial data.

Nodes of axis k are xi_k = i/cells_k, i = 0 … cells_k, or 0 … cells_k - 1 where the axis is
periodic. Axis 0 is the fastest in memory: node number n = i_0 + N_0 (i_1 + N_1 i_2).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from fsipetsc.blocks.maps import Map, Nodes
from fsipetsc.checks import Array, check, checked, described, place_text, whole
from fsipetsc.equations import tensors
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid

#: index ranges, one (begin, end) for each axis
Range = Sequence[tuple[int, int]]
#: functions that a block need not have
_OPTIONAL = "forcing", "exact", "prestress", "exact_stress"


@dataclass(frozen=True)
class Block:
    """A block of gas or of a solid: a logical line, square or cube of nodes.

    Functions get d arrays of coordinates of one shape [m], and t [s] where they depend on time;
    each number that they return is an array of that shape or a float.

    Args:
        name: name of the block, without |.
        material: a `Fluid` or an `ElasticSolid`.
        map: a smooth, right-handed function of [0, 1]^d, as `fsipetsc.blocks.maps` has them. Of a
            solid it gives material coordinates X [m], of a gas the grid before anything moves.
        cells: number of cells along each axis.
        initial: `initial(*X)` returns rho [kg/m3], d velocities [m/s], T [K] of a gas; d velocities
            [m/s], T [K], d positions [m] of a solid.
        forcing: `forcing(*X, t)` returns the right-hand sides of density, momenta and energy of a
            gas, per volume and second; of the unknowns of `initial` of a solid, per second;
            None: 0.
        exact: `exact(*X, t)` returns what `initial` does, where an exact solution is known.
        periodic: of each axis, whether it closes in itself and so has no faces; (): none.
        prestress: `prestress(*X)` returns d*d numbers, row by row: a stress S [Pa] per area at rest
            beside that of the law; it keeps its direction and gives no stiffness: for tension
            stretch the solid. With heat "elastic" it stores S : (F - 1), else its work is heat.
        exact_stress: `exact_stress(*X, t)` returns the stresses of a solid [Pa] as results have
            them, to be compared as well.
    """

    name: str
    material: Fluid | ElasticSolid
    map: Map
    cells: tuple[int, ...]
    initial: Callable[..., Any]
    forcing: Callable[..., Any] | None = None
    exact: Callable[..., Any] | None = None
    periodic: tuple[bool, ...] = ()
    prestress: Callable[..., Any] | None = None
    exact_stress: Callable[..., Any] | None = None

    def __post_init__(self) -> None:
        check("name", self.name, "Block: name")
        if not isinstance(self.material, Fluid | ElasticSolid):
            found = f"material is {described(self.material)}"
            raise InputError(f"{self}: {found}: expected a Fluid or an ElasticSolid")
        self._check_axes()
        for name in ("map", "initial", *_OPTIONAL):
            kind = "optional" if name in _OPTIONAL else "function"
            check(kind, getattr(self, name), f"{self}: {name}")
        if self.prestress is not None and self.kind == "fluid":
            raise InputError(f"{self}: prestress is given: expected none, as it is a gas")
        if not isinstance(self.map, Nodes):
            self._check_smooth()
        elif self.map.cells != self.cells:
            raise InputError(f"{self}: its map has {self.map.cells} cells, the block {self.cells}")
        volumes, middles = self.pieces()
        if not volumes.min() > 0.0:
            place = place_text(middles.reshape(self.dimension, -1)[:, volumes.argmin()])
            wrong = f"its map has J = {volumes.min():.3g} per piece at {place}"
            raise InputError(f"{self}: {wrong}: expected J > 0, right-handed axes")

    def __str__(self) -> str:
        return f"block '{self.name}'"

    @property
    def kind(self) -> str:
        """ "fluid" or "solid"."""
        return self.material.kind

    @property
    def dimension(self) -> int:
        return len(self.cells)

    @property
    def faces(self) -> list[tuple[int, int]]:
        """(axis, side) of its faces; there are none along a periodic axis."""
        return [*product((k for k, closed in enumerate(self.periodic) if not closed), (0, 1))]

    @property
    def shape(self) -> tuple[int, ...]:
        """Nodes along each axis, axis 0 first."""
        return tuple(c + (not closed) for c, closed in zip(self.cells, self.periodic))

    def places(self, index: Sequence[Array], known: tuple[Array, Array] | None = None) -> Array:
        """Places X (d, …) of the nodes of these indices, d arrays of one shape; beyond the ends of
        a periodic axis they go on. InputError.

        known: numbers of nodes, ascending, and X (d, M) of these instead of what the map gives.
        """
        turns = [i // n if closed else 0 for i, n, closed in zip(index, self.shape, self.periodic)]
        within = [i - turn * n for i, turn, n in zip(index, turns, self.shape)]
        X = self._mapped(tuple(i / c for i, c in zip(within, self.cells)))
        if known is not None and known[0].size:
            number = np.ravel_multi_index(within, self.shape, order="F")
            at = np.searchsorted(known[0], number).clip(max=known[0].size - 1)
            X = np.where(known[0][at] == number, known[1][:, at], X)
        turned = [axis for axis, turn in enumerate(turns) if np.any(turn)]
        return X + sum(np.multiply.outer(self.periods[axis], turns[axis]) for axis in turned)

    @cached_property
    def periods(self) -> Array:
        """X(xi_k = 1) - X(xi_k = 0) of each periodic axis k, 0 of the others, (d, d). InputError
        where the ends of a periodic axis are not one vector apart.
        """
        found = np.zeros((self.dimension, self.dimension))
        for axis in np.flatnonzero(self.periodic):
            xi = [np.arange(n) / c for n, c in zip(self.shape, self.cells)]
            ends = (mesh([*xi[:axis], np.array([s]), *xi[axis + 1 :]]) for s in (0.0, 1.0))
            low, high = (self._mapped(end).reshape(self.dimension, -1) for end in ends)
            apart, size = high - low, np.abs(low).max() + np.abs(high).max()
            period = apart.mean(axis=1)
            if np.abs(apart - period[:, None]).max() > 1e-9 * size:
                wrong = f"axis {axis} is periodic, and its map is not"
                raise InputError(f"{self}: {wrong}: expected ends that are one vector apart")
            found[axis] = np.where(np.abs(period) < 1e-12 * size, 0.0, period)
        return found

    def face_nodes(self, axis: int, side: int) -> Array:
        """Numbers of the nodes of a face, lower axis fastest."""
        index = [np.arange(n) for n in self.shape]
        index[axis] = index[axis][-1:] if side else index[axis][:1]
        return np.ravel_multi_index(mesh(index), self.shape, order="F").ravel()

    def face_positions(self, axis: int, side: int) -> Array:
        """Places X of these nodes, (d, N)."""
        return self.places(np.unravel_index(self.face_nodes(axis, side), self.shape, order="F"))

    def _mapped(self, xi: Sequence[Array]) -> Array:
        """X (d, …) at logical coordinates. InputError."""
        flat = np.array([np.ravel(s) for s in xi])
        names = "XYZ"[: self.dimension]
        X = checked(self.map, (tuple(flat),), flat, names, f"map of {self}", letters="ξηζ")
        return np.reshape(X, (self.dimension, *np.shape(xi[0])))

    def _check_axes(self) -> None:
        """InputError for wrong cells or periodic; both become tuples."""
        given = (np.atleast_1d(np.array(of, object)) for of in (self.cells, self.periodic))
        cells, periodic = map(tuple, given)
        d = len(cells)
        if not (1 <= d <= 3 and all(map(whole, cells))):
            wanted = "expected 1, 2 or 3 whole numbers above 0"
            raise InputError(f"{self}: cells is {described(self.cells)}: {wanted}")
        periodic = periodic or (False,) * d
        if len(periodic) != d or not all(isinstance(p, bool) for p in periodic):
            wanted = "expected True or False for each axis"
            raise InputError(f"{self}: periodic is {described(self.periodic)}: {wanted}")
        object.__setattr__(self, "cells", tuple(map(int, cells)))
        object.__setattr__(self, "periodic", periodic)

    def _check_smooth(self) -> None:
        """InputError where second differences along an axis do not fall as the square of the
        spacing. Of a smooth map they fall by 64 from 256 to 2048 intervals, at a kink by 4 to 16.
        """
        for axis in range(self.dimension):
            lines = [np.array([0.0, 0.31, 1.0])] * self.dimension
            lines[axis] = np.arange(2049) / 2048
            X = np.moveaxis(self._mapped(mesh(lines)), self.dimension - axis, -1)
            fine, coarse = (np.linalg.norm(np.diff(X[..., ::m], 2), axis=0) for m in (1, 8))
            length, largest = np.linalg.norm(np.diff(X), axis=0).max(axis=-1), fine.max(axis=-1)
            rough = (largest > coarse.max(axis=-1) / 32) & (largest > 1e-3 * length)
            if rough.any():
                line = np.unravel_index(int(np.argmax(rough)), rough.shape)
                place = place_text(X[(slice(None), *line, int(np.argmax(fine[line])) + 1)])
                raise InputError(f"{self}: its map is not smooth along axis {axis}, at {place}")

    def pieces(self) -> tuple[Array, Array]:
        """Volumes (…), below 0 if left-handed, and middles (d, …) of pieces, at most 32 an axis."""
        index = [np.unique(np.linspace(0, c, min(c, 32) + 1).astype(int)) for c in self.cells]
        X, axes = self.places(mesh(index)), range(self.dimension, 0, -1)
        edges = [_means(np.diff(X, axis=axis), {*axes} - {axis}) for axis in axes]
        return determinant(np.array(edges)), _means(X, axes)


def determinant(edges: Array) -> Array:
    """det of d vectors: (d, d, …) -> (…)."""
    return tensors.determinant(tuple(edges.reshape(-1, *edges.shape[2:])))


def mesh(axes: Sequence[Array]) -> tuple[Array, ...]:
    """Coordinates of a grid, arrays of shape (…, n_1, n_0), in the order of the axes."""
    return tuple(np.meshgrid(*axes[::-1], indexing="ij")[::-1])


def size_of(block: Block, symmetry: int = 0) -> float:
    """About the volume of a block, or of a sector of unit angle, where r is the last coordinate."""
    volumes, middles = block.pieces()
    return float(np.abs(volumes * middles[-1] ** symmetry).sum())


def _means(values: Array, axes: Iterable[int]) -> Array:
    """The means of neighbours along axes."""
    for axis in axes:
        values = 0.5 * (np.delete(values, -1, axis=axis) + np.delete(values, 0, axis=axis))
    return values
