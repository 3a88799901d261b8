"""Maps of the logical cube [0, 1]^d to places X.

A map is a callable X(xi) -> d arrays, xi a tuple of d arrays of one shape. Any function of this
form will do; it must be smooth, and right-handed: det(dX/dxi) > 0.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np

from fsipetsc.checks import POSITIVE, Array, number, place_text
from fsipetsc.errors import InputError

Places = tuple[Array, ...]
#: X(xi)
Map = Callable[[Places], Sequence[Any]]


@dataclass(frozen=True, eq=False)
class Nodes:
    """A map that is defined at the nodes of a grid only. `nodes` is another name of it.

    On a periodic axis the last nodes are the first ones, a period on.

    Args:
        places: (n_0, 1), (n_1, n_0, 2) or (n_2, n_1, n_0, 3) coordinates of nodes [m].
    """

    places: Array

    def __post_init__(self) -> None:
        X = np.array(self.places, float)
        object.__setattr__(self, "places", X)
        if not 2 <= X.ndim <= 4 or X.shape[-1] != X.ndim - 1 or min(X.shape[:-1]) < 2:
            wanted = "expected (n_0, 1), (n_1, n_0, 2) or (n_2, n_1, n_0, 3)"
            raise InputError(f"nodes: places have the shape {X.shape}: {wanted}")

    @property
    def cells(self) -> tuple[int, ...]:
        """Of each axis, axis 0 first."""
        return tuple(n - 1 for n in self.places.shape[-2::-1])

    def __call__(self, xi: Places) -> Places:
        """Places of the nodes next to xi."""
        index = tuple(np.rint(x * c).astype(int) for x, c in zip(xi, self.cells))
        return tuple(np.moveaxis(self.places[index[::-1]], -1, 0))


nodes = Nodes


def rectangle(lower: Any, upper: Any) -> Map:
    """An interval, rectangle or box between two corners.

    Args:
        lower: d coordinates [m], or a number in one dimension.
        upper: the same of the opposite corner, above those of lower.
    """
    low, high = _point(lower, "rectangle: lower"), _point(upper, "rectangle: upper")
    return lambda xi: [(1.0 - s) * a + s * b for s, a, b in zip(xi, low, high, strict=True)]


def off_axis(map: Map, cells: int) -> Map:
    """A map whose first nodes are half a cell from r = 0, of a block with `Centre()`.

    Args:
        map: a map that has r = 0 where its last logical coordinate is 0.
        cells: number of cells of the block along its last axis.
    """
    n = number(cells, "off_axis: cells", POSITIVE)
    return lambda xi: map((*xi[:-1], (0.5 + n * xi[-1]) / (n + 0.5)))


def corners(*points: Any) -> Map:
    """A multilinear map between corners.

    Args:
        points: 2^d corners of d coordinates [m], axis 0 fastest: those at (0, 0), (1, 0), (0, 1),
            (1, 1) in two dimensions.
    """
    found = [_point(point, f"corners: point {k}") for k, point in enumerate(points)]
    if [len(point) for point in found] not in ([d] * 2**d for d in (1, 2, 3)):
        raise InputError("corners: expected 2^d points of d numbers each, d = 1, 2 or 3")

    def places(xi: Places) -> Places:
        values = found
        for s in xi:
            pairs = zip(values[::2], values[1::2])
            values = [tuple((1.0 - s) * a + s * b for a, b in zip(*pair)) for pair in pairs]
        return values[0]

    return places


def annulus(
    inner: float, outer: float, angles: Any = (0.0, 2.0 * np.pi), centre: Any = (0.0, 0.0)
) -> Map:
    """A ring or a part of one: axis 0 along the radius, axis 1 along the angle.

    The whole ring is periodic along axis 1: `Block(…, periodic=(False, True))`.

    Args:
        inner: inner radius [m], above 0.
        outer: outer radius [m].
        angles: angles where it begins and ends [rad]; they rise by no more than 2 pi.
        centre: coordinates of the centre [m].
    """
    a, b = number(inner, "annulus: inner", POSITIVE), number(outer, "annulus: outer", POSITIVE)
    (begin, end), (x, y) = _point(angles, "annulus: angles"), _point(centre, "annulus: centre")
    if not (a < b and 0.0 < end - begin <= 2.0 * np.pi + 1e-12):
        wanted = "expected inner below outer, and an angle that rises by no more than 2 pi"
        raise InputError(f"annulus({a:g}, {b:g}, ({begin:g}, {end:g})): {wanted}")

    def places(xi: Places) -> Places:
        r, angle = (1.0 - xi[0]) * a + xi[0] * b, (1.0 - xi[1]) * begin + xi[1] * end
        return x + r * np.cos(angle), y + r * np.sin(angle)

    return places


def transfinite(*faces: tuple[Callable[..., Any], Callable[..., Any]]) -> Map:
    """A map between 2 d curved faces, of two or three dimensions.

    Source: W. J. Gordon and C. A. Hall, Int. J. Numer. Methods Eng. 7 (1973) 461-477.

    Args:
        faces: for each axis k the pair of faces at xi_k = 0 and 1. Each is a function of the d - 1
            other logical coordinates, arrays of one shape, and returns d arrays of coordinates [m];
            they meet at edges.
            In two dimensions: (left, right), (lower, upper), with left and right functions of xi_1,
            lower and upper of xi_0.
    """
    d = len(faces)
    if d not in (2, 3) or any(not isinstance(pair, tuple) or len(pair) != 2 for pair in faces):
        raise InputError("transfinite: expected (low, high), functions, for each of 2 or 3 axes")

    def on_face(axis: int, side: int, xi: Sequence[Array]) -> Array:
        values = faces[axis][side](*(s for k, s in enumerate(xi) if k != axis))
        return np.array([x + 0.0 * xi[0] for x in values])

    def places(xi: Places) -> Places:
        total = np.zeros((d, *np.shape(xi[0])))
        for count in range(1, d + 1):
            for axes in combinations(range(d), count):
                for sides in product((0, 1), repeat=count):
                    at, weight = list(xi), (-1.0) ** (count + 1)
                    for axis, side in zip(axes, sides):
                        weight = weight * (xi[axis] if side else 1.0 - xi[axis])
                        at[axis] = side + 0.0 * xi[0]
                    total += weight * on_face(axes[0], sides[0], at)
        return tuple(total)

    for axis, side in product(range(d), (0, 1)):  # a map of faces that meet has them
        at = list(np.meshgrid(*[np.linspace(0.0, 1.0, 5)] * d))  # numpy 2 returns a tuple
        at[axis] = side + 0.0 * at[axis]
        given = on_face(axis, side, at).reshape(d, -1)
        apart = np.abs(given - np.reshape(places(tuple(at)), (d, -1))).max(axis=0)
        if not apart.max() <= 1e-9 * (np.abs(given).max() + 1e-300):
            face, where = f"face (axis {axis}, side {side})", place_text(given[:, apart.argmax()])
            raise InputError(f"transfinite: {face} misses others at {where}")
    return places


def _point(value: Any, what: str) -> tuple[float, ...]:
    items = (value,) if np.ndim(value) == 0 else tuple(value)
    return tuple(number(x, f"{what}[{k}]") for k, x in enumerate(items))
