"""A block: a logical cube of nodes with a map, a material and initial data.

Nodes of axis k are xi_k = i/cells_k, i = 0 … cells_k, or 0 … cells_k - 1 where the axis is periodic. Axis 0 is the fastest in
memory: node number n = i_0 + N_0 (i_1 + N_1 i_2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from fsipetsc.blocks.maps import Map, Nodes, place_text
from fsipetsc.checks import Array, described, function
from fsipetsc.errors import InputError
from fsipetsc.operators.bands import Band, band

#: index ranges, one (begin, end) for each axis
Range = Sequence[tuple[int, int]]
#: cells along an axis that are looked at for the sign of the Jacobian when a block is made
_LOOKED_AT = 32


@dataclass(frozen=True)
class Block:
    """A block of gas or of a solid. InputError for what is wrong with it.

    material: a Fluid or an ElasticSolid. map: fsipetsc.blocks.maps; of a solid it gives material coordinates X, of a gas the
    grid before anything moves. cells: of each axis. initial(*X) -> (rho, u_1..u_d, T) of a gas, (v_1..v_d, T, x_1..x_d) of
    a solid. exact(*X, t) -> the same. forcing(*X, t) -> right-hand sides of (rho, rho u_1..u_d, e) of a gas, per volume, and
    of the unknowns of initial of a solid. periodic: which axes close in themselves and have no faces.
    """

    name: str
    material: Any
    map: Map
    cells: tuple[int, ...]
    initial: Callable[..., Any]
    forcing: Callable[..., Any] | None = None
    exact: Callable[..., Any] | None = None
    periodic: tuple[bool, ...] = ()

    def __post_init__(self) -> None:
        name = self.name
        if not isinstance(name, str) or not name.isprintable() or not name.strip() or "|" in name:
            raise InputError(f"Block: name is {described(name)}: expected a text of one line without |")
        if not (hasattr(self.material, "m0") or hasattr(self.material, "mu")):
            raise InputError(f"{self}: material is {described(self.material)}: expected a Fluid or an ElasticSolid")
        self._check_axes()
        function(self.map, f"{self}: map", "X(xi) -> d arrays")
        self._check_map()
        function(self.initial, f"{self}: initial", "initial(*X) -> the unknowns")
        function(self.exact, f"{self}: exact", "exact(*X, t) -> the unknowns", optional=True)
        function(self.forcing, f"{self}: forcing", "forcing(*X, t) -> the right-hand sides", optional=True)
        self._check_jacobian()

    def __str__(self) -> str:
        return f"block '{self.name}'"

    @property
    def kind(self) -> str:
        """"fluid" or "solid"."""
        return "solid" if hasattr(self.material, "m0") else "fluid"

    @property
    def dimension(self) -> int:
        """1, 2 or 3."""
        return len(self.cells)

    @property
    def shape(self) -> tuple[int, ...]:
        """Nodes along each axis, axis 0 first."""
        return tuple(c + (not closed) for c, closed in zip(self.cells, self.periodic))

    def band(self, order: int, axis: int) -> Band:
        """Pair weights of an axis. InputError if it has too few nodes."""
        try:
            return band(order, self.cells[axis], self.periodic[axis])
        except ValueError as error:
            raise InputError(f"{self}, axis {axis}: {error}") from None

    def positions(self, where: Range) -> Array:
        """Places X of a range of nodes, (d, N), axis 0 fastest. Beyond the ends of a periodic axis
        they go on. InputError."""
        return self.places(mesh([np.arange(*ends) for ends in where])).reshape(self.dimension, -1)

    def places(self, index: Sequence[Array]) -> Array:
        """Places X of the nodes of these indices, d arrays of one shape: (d, …). InputError."""
        turns = [i // n if closed else 0 for i, n, closed in zip(index, self.shape, self.periodic)]
        within = (i - turn * n for i, turn, n in zip(index, turns, self.shape))
        X = self._mapped(tuple(i / c for i, c in zip(within, self.cells)))
        for axis, turn in enumerate(turns):
            if np.any(turn):
                X = X + np.multiply.outer(self.periods[axis], turn)
        return X

    @cached_property
    def periods(self) -> tuple[Array, ...]:
        """X(xi_k = 1) - X(xi_k = 0) of each axis k, (d,) each; of use where the axis is periodic."""
        return tuple(self._period(axis) for axis in range(self.dimension))

    def face_positions(self, axis: int, side: int) -> Array:
        """Places X of the nodes of a face, (d, N), lower axis fastest."""
        return self.positions(_ends(self.shape, axis, side))

    def _period(self, axis: int) -> Array:
        """The mean over the nodes at both ends; InputError where they are not one vector apart on a periodic axis."""
        others = [np.arange(n) / c for n, c in zip(self.shape, self.cells)]
        low, high = (self._mapped(mesh([*others[:axis], np.array([s]), *others[axis + 1 :]])) for s in (0.0, 1.0))
        apart = (high - low).reshape(self.dimension, -1)
        period, size = apart.mean(axis=1), np.abs(low).max() + np.abs(apart).max()
        if self.periodic[axis] and np.abs(apart - period[:, None]).max() > 1e-9 * size:
            raise InputError(f"{self}: axis {axis} is periodic, and its map is not: expected ends that are one vector apart")
        return np.where(np.abs(period) < 1e-12 * size, 0.0, period)

    def _mapped(self, xi: tuple[Array, ...]) -> Array:
        """X at logical coordinates, (d, …). InputError for what a map raises, and for values that are no places."""
        d = self.dimension
        try:
            values = self.map(xi)
            X = np.array([np.broadcast_to(np.asarray(x, float), xi[0].shape) for x in values])
        except InputError:
            raise
        except Exception as error:
            raise InputError(f"{self}: its map fails: {type(error).__name__}: {error}") from error
        if len(X) != d:
            raise InputError(f"{self}: its map gives {len(X)} coordinates: expected {d}, as cells has {d} numbers")
        wrong = ~np.isfinite(X).all(axis=0)
        if wrong.any():
            at = np.unravel_index(int(np.argmax(wrong)), wrong.shape)
            where = ", ".join(f"{s[at]:.6g}" for s in xi)
            found = place_text(X[(slice(None), *at)])
            raise InputError(f"{self}: its map gives {found} at xi = ({where}): expected numbers")
        return X

    def _check_axes(self) -> None:
        """InputError for wrong cells or periodic; both become tuples."""
        cells = (self.cells,) if isinstance(self.cells, (int, np.integer)) else self.cells
        good = isinstance(cells, (tuple, list)) and 1 <= len(cells) <= 3
        if not good or not all(isinstance(c, (int, np.integer)) and not isinstance(c, bool) and c > 0 for c in cells):
            raise InputError(f"{self}: cells is {described(self.cells)}: expected 1, 2 or 3 whole numbers above 0")
        periodic = tuple(self.periodic) or (False,) * len(cells)
        if len(periodic) != len(cells) or not all(isinstance(p, (bool, np.bool_)) for p in periodic):
            raise InputError(f"{self}: periodic is {described(self.periodic)}: expected True or False for each axis")
        object.__setattr__(self, "cells", tuple(int(c) for c in cells))
        object.__setattr__(self, "periodic", tuple(bool(p) for p in periodic))

    def _check_map(self) -> None:
        """InputError where the map has another dimension, another grid, or kinks."""
        d = getattr(self.map, "dimension", self.dimension)
        if d != self.dimension:
            raise InputError(f"{self}: its map has {d} dimensions, cells {self.dimension}: expected the same")
        if isinstance(self.map, Nodes):
            if self.map.cells != self.cells:
                raise InputError(f"{self}: its map has {self.map.cells} cells, the block {self.cells}: expected the same")
        else:
            self._check_smooth()
        for axis in range(self.dimension):
            if self.periodic[axis]:
                self._period(axis)

    def _check_smooth(self) -> None:
        """InputError at a kink or a jump: where second differences along an axis do not fall as the square of the spacing.

        Of a smooth map they fall by 64 from 256 to 2048 intervals, at a kink by 4 to 16, at a jump not at all.
        """
        for axis in range(self.dimension):
            lines = [np.array([0.0, 0.31, 1.0])] * self.dimension
            lines[axis] = np.arange(2049) / 2048
            X = np.moveaxis(self._mapped(mesh(lines)), self.dimension - axis, -1)
            coarse, fine = (np.linalg.norm(X[..., 2 * m :: m] - 2 * X[..., m:-m:m] + X[..., : -2 * m : m], axis=0) for m in (8, 1))
            length = np.linalg.norm(np.diff(X), axis=0).max(axis=-1)
            largest = fine.max(axis=-1)
            rough = (largest > coarse.max(axis=-1) / 32) & (largest > 1e-3 * length)
            if rough.any():
                line = np.unravel_index(int(np.argmax(rough)), rough.shape)
                i = int(np.argmax(fine[line])) + 1
                place = place_text(X[(slice(None), *line, i)])
                raise InputError(f"{self}: its map is not smooth along axis {axis}, at {place}: expected one without kinks")

    def _check_jacobian(self) -> None:
        """InputError where the edges of a cell at one of its ends are left-handed or have no volume; a sample of cells."""
        d = self.dimension
        at = [np.unique(np.linspace(0, c - 1, min(c, _LOOKED_AT)).astype(int)) for c in self.cells]

        def places(shifts: Sequence[int]) -> Array:
            return self._mapped(mesh([(i + s) / c for i, s, c in zip(at, shifts, self.cells)]))

        for corner in product((0, 1), repeat=d):
            X = places(corner)
            edges = []
            for k in range(d):
                ahead = places([1 - s if j == k else s for j, s in enumerate(corner)])
                edges.append((X - ahead) if corner[k] else (ahead - X))
            J = determinant(np.array(edges).reshape(d, d, -1))
            if not J.min() > 0.0:
                i = int(np.argmin(J))
                place = place_text(X.reshape(d, -1)[:, i])
                raise InputError(f"{self}: its map has J = {J[i]:.3g} per cell at {place}: expected J > 0, axes in right-handed order")


def determinant(edges: Array) -> Array:
    """det of d vectors at N points: (d, d, N) -> (N,)."""
    if len(edges) == 1:
        return edges[0, 0]
    if len(edges) == 2:
        return edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0]
    a, b, c = edges
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])


def mesh(axes: Sequence[Array]) -> tuple[Array, ...]:
    """Coordinates of a grid, arrays of shape (…, n_1, n_0), in the order of the axes."""
    return tuple(np.meshgrid(*axes[::-1], indexing="ij")[::-1])


def _ends(shape: Sequence[int], axis: int, side: int) -> list[tuple[int, int]]:
    """The range of nodes of a face."""
    last = shape[axis] - 1 if side else 0
    return [(last, last + 1) if k == axis else (0, n) for k, n in enumerate(shape)]
