"""Where a solid is beyond its law: waves that have become imaginary, and a solid that is crushed.

Waves along N are real if the acoustic tensor along N at constant entropy (fsipetsc.equations.solid)
is positive: its leading minors are, and its eigenvalues are m0 c^2.

Nodes with hardly any strain are left out, so that solids of small strain cost next to nothing.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import product
from math import isqrt
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.blocks.maps import place_text
from fsipetsc.equations.tensors import determinant

Array = np.ndarray
#: a smaller stretch is that of a solid that is crushed
CRUSHED = 0.1
#: entries of F^T F - 1 below which the waves of a law are those at rest
SMALL = 0.02
#: part of the largest entry of the tensor that an eigenvalue below 0 must be more than
ROUND_OFF = 1e-8
#: entries of directions of waves, in as many dimensions, -so many … so many
FINEST = {1: 1, 2: 4, 3: 2}


class Found(NamedTuple):
    """A node of which something is said; the one with the smallest ``order`` comes first. place: X;
    values: the numbers that are said.
    """

    order: float
    block: int
    number: int
    place: tuple[float, ...]
    values: tuple[float, ...]


def imaginary_waves(state: Any, t: float, noted: set[int]) -> list[str]:
    """A line for each solid whose waves have become imaginary somewhere, by the last F. Collective.

    t: time of the state [s]. noted: the blocks of which it was said before; more are added.
    """
    every = _first_of_all(state, imaginary, noted)
    noted.update(found.block for found in every)
    when, words = f"t = {t:.6g}{state.problem.unit('s')}", "waves have become imaginary"
    return [
        f"{words} in {_where(state, found)}, {when}, where the stretch along them is "
        f"{found.values[0]:.3g}: the law has no meaning here"
        for found in every
    ]


def most_crushed(state: Any) -> str:
    """Which solid is crushed most, and by how much pressure, by the last F; "" if none is.
    Collective.
    """
    found = min(_first_of_all(state, _shortest), default=None)
    if found is None:
        return ""
    K, (push,) = state.problem.layers[found.block].material.K, found.values
    pressed = f" under a pressure of {push / K:.3g} K, K = 2 mu_e + lambda_e" if K > 0.0 else ""
    return (
        f"the solid is crushed in {_where(state, found)}: its stretch is {found.order:.3g}{pressed}"
        "; a stiffer solid or less pressure helps, shorter steps do not"
    )


def _where(state: Any, found: Found) -> str:
    """The place of a node, in words."""
    block, shape = state.problem.layers[found.block], state.layout.shapes[found.block]
    node = ", ".join(map(str, np.unravel_index(found.number, shape[::-1])[::-1]))
    return f"'{block.name}' at {place_text(found.place)}{state.problem.unit('m')} (node {node})"


def _first_of_all(
    state: Any,
    look: Callable[[SolidPart, Array], Iterator[Found]],
    but: Collection[int] = (),
) -> Collection[Found]:
    """The first node of each solid block that ``look`` finds on any rank; but: blocks left out.
    Collective.
    """
    mine: list[Found] = []
    for k, part in state.scheme.parts.items():
        if part.block.kind == "solid" and k not in but:
            with np.errstate(all="ignore"):  # a bad state has no stress, and is told otherwise
                mine += look(part, state.y.ghosted(k))
    first: dict[int, Found] = {}
    for found in sorted(one for some in state.comm.allgather(mine) for one in some):
        first.setdefault(found.block, found)
    return first.values()


def _found(part: SolidPart, order: Array, rows: Array, values: Sequence[Array]) -> Iterator[Found]:
    """The row with the smallest order, to six digits; among equals that of the smallest number."""
    if rows.size:
        rounded = [float(f"{value:.5e}") for value in order]
        numbers = part.part.numbers[rows]
        i = np.lexsort((numbers, rounded))[0]
        X = part.X[:, part.owned[rows[i]]]
        at = part.part.k, int(numbers[i]), tuple(X.tolist())
        yield Found(rounded[i], *at, tuple(float(value[i]) for value in values))


def _shortest(part: SolidPart, q: Array) -> Iterator[Found]:
    """The node with the least stretch, if it is crushed, and what pushes it together [Pa]."""
    d, F = part.block.dimension, part.F
    good = np.flatnonzero(np.isfinite(F).all(axis=0))
    least = np.linalg.svd(F[: d * d, good].T.reshape(-1, d, d), compute_uv=False)[:, -1]
    stretch = np.min([least, *F[d * d :, good]], axis=0)
    few = stretch < CRUSHED
    rows, push = good[few], []
    if rows.size:
        push = [-np.linalg.eigvalsh(part.stresses(q, rows)).min(axis=-1)]
    yield from _found(part, stretch[few], rows, push)


def imaginary(part: SolidPart, q: Array) -> Iterator[Found]:
    """The node where m0 c^2 is most below 0, and its stretch along these waves."""
    d = part.block.dimension
    F = part.F[: d * d].T.reshape(-1, d, d)
    strain = np.abs(np.einsum("nki,nkj->nij", F, F) - np.eye(d)).max(axis=(1, 2))
    strain = np.maximum(strain, np.abs(part.F[d * d :].T - 1.0).max(axis=1, initial=0.0))
    rows = np.flatnonzero(strain > SMALL)
    strains, T, F = tuple(part.F[:, rows]), part.stressed(q, rows)[0], F[rows]
    modulus, stretch = np.zeros((2, rows.size))
    for N in _directions(d) if rows.size else ():
        Q = part.equations.acoustic_tensor(strains, T, tuple(N))
        Q = np.reshape(Q, (isqrt(len(Q)), -1, rows.size))[:d, :d]
        allowed = ROUND_OFF * np.abs(Q).max(axis=(0, 1))
        near = Q + allowed * np.eye(d)[..., None]
        minors = [determinant(tuple(near[:k, :k].reshape(k * k, -1))) for k in range(1, d + 1)]
        few = np.flatnonzero(np.min(minors, axis=0) < 0.0)
        least = np.linalg.eigvalsh(np.moveaxis(Q[..., few], -1, 0))[:, 0]
        worse = least < np.minimum(modulus[few], -allowed[few])
        few = few[worse]
        modulus[few], stretch[few] = least[worse], np.linalg.norm(F[few] @ N, axis=1)
    bad = modulus < 0.0
    yield from _found(part, modulus[bad], rows[bad], [stretch[bad]])


def _directions(d: int) -> Array:
    """(m, d) unit vectors of directions of waves, one of each two that are opposite."""
    entries = range(-FINEST[d], FINEST[d] + 1)
    some = {N: np.linalg.norm(N) for N in product(entries, repeat=d) if N > (0,) * d}
    return np.unique([np.divide(N, size).round(15) for N, size in some.items()], axis=0)
