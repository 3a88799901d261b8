"""Where a solid is beyond its law: waves that have become imaginary, and a solid that is crushed.

The tangent at constant entropy, by differences of the stress, is

    C_iajb = dP_ia/dF_jb + dP_ia/dT dT/dF_jb,    m0 alpha dT = (P - dW/dF) : dF,

with heat 'coupled' m0 alpha dT = P : dF. Waves along N are real if all eigenvalues m0 c^2 of the
acoustic tensor A_ij = C_iajb N_a N_b are positive. The coefficients I_k of its characteristic
polynomial, its trace first and its determinant last, are then positive, too. I_k/I_(k-1) is near
the smallest eigenvalue when that is small.

Nodes with hardly any strain are left out, so that solids of small strain cost next to nothing.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blockrun.block_solution import BlockSolution
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.equations.tensors import determinant
from fsipetsc.materials.own import STEP, bumped
from fsipetsc.state import CRUSHED, crushed

Array = np.ndarray
#: entries of F^T F - 1 below which the waves of a law are those at rest
SMALL = 0.02
#: of the largest entry of C: what a negative coefficient must be more than, for the round-off of
#: differences
ROUND_OFF = 1e-8
#: nodes at once
AT_ONCE = 5000
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


def imaginary_waves(state: BlockSolution, t: float, noted: set[int]) -> list[str]:
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


def most_crushed(state: BlockSolution) -> str:
    """Which solid is crushed most, and by how much pressure, by the last F; "" if none is.
    Collective.
    """
    found = min(_first_of_all(state, _shortest), default=None)
    if found is None:
        return ""
    K = state.problem.layers[found.block].material.K
    return crushed(_where(state, found), found.order, *found.values, K)


def _where(state: BlockSolution, found: Found) -> str:
    """The place of a node, in words."""
    block, shape = state.problem.layers[found.block], state.layout.shapes[found.block]
    node = ", ".join(map(str, np.unravel_index(found.number, shape[::-1])[::-1]))
    m = state.problem.unit("m")
    place = ", ".join(f"{x} = {value:.6g}{m}" for x, value in zip("XYZ", found.place))
    return f"'{block.name}' at {place} (node {node})"


def _first_of_all(
    state: BlockSolution,
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
    if not rows.size:
        return
    found = [_softest(part, q, some) for some in np.split(rows, range(AT_ONCE, rows.size, AT_ONCE))]
    modulus, stretch = np.concatenate(found, axis=1)
    bad = modulus < 0.0
    yield from _found(part, modulus[bad], rows[bad], [stretch[bad]])


def _softest(part: SolidPart, q: Array, rows: Array) -> Array:
    """(2, n): the least m0 c^2 [Pa] of waves in the direction with the least I_k/|I_(k-1)|, 0 if
    that is not below 0; |F N| of this direction.
    """
    d, at = part.block.dimension, np.arange(rows.size)
    F, T = tuple(part.F[:, rows]), part.stressed(q, rows)[0]
    C, N = _tangent(part, F, T), _directions(d)
    scale = np.abs(C).max(axis=(0, 1, 2, 3))
    A = np.einsum("iajbn,ma,mb->ijnm", C / scale, N, N, optimize=True)
    coefficients = _coefficients(A)
    sizes = [1.0, *(np.maximum(np.abs(one), 1e-300) for one in coefficients[:-1])]
    least = np.min([one / size for one, size in zip(coefficients, sizes, strict=True)], axis=0)
    direction = least.argmin(axis=1)
    bad, modulus = least[at, direction] < -ROUND_OFF, np.zeros(rows.size)
    chosen = np.moveaxis(A[:, :, at[bad], direction[bad]], -1, 0)
    modulus[bad] = np.linalg.eigvals(chosen).real.min(axis=1) * scale[bad]
    along = np.einsum("ian,na->in", np.reshape(F[: d * d], (d, d, -1)), N[direction])
    return np.array([modulus, np.linalg.norm(along, axis=0)])


def _tangent(part: SolidPart, F: Any, T: Array) -> Array:
    """C [Pa], (d, d, d, d, n)."""
    d, solid, columns = part.block.dimension, part.equations, []
    P = solid.stress_at(F, T)
    for c in range(d * d):
        more, less = bumped(F, c, STEP), bumped(F, c, -STEP)
        stored = (1.0 - solid.coupled) * (solid.energy(more) - solid.energy(less)) / (2.0 * STEP)
        warmer = STEP * (P[c] - stored) / (solid.m0 * solid.alpha)
        apart = zip(solid.stress_at(more, T + warmer), solid.stress_at(less, T - warmer))
        columns.append([(a - b) / (2.0 * STEP) + 0.0 * T for a, b in apart])
    return np.reshape(columns, (d, d, d, d, -1)).transpose(2, 3, 0, 1, 4)


def _directions(d: int) -> Array:
    """(m, d) unit vectors of directions of waves, one of each two that are opposite."""
    entries = range(-FINEST[d], FINEST[d] + 1)
    some = {N: np.linalg.norm(N) for N in product(entries, repeat=d) if N > (0,) * d}
    return np.unique([np.divide(N, size).round(15) for N, size in some.items()], axis=0)


def _coefficients(A: Array) -> list[Array]:
    """The coefficients I_1, … of the characteristic polynomial of A, (d, d, …)."""
    d = len(A)
    found = [np.trace(A)]
    if d == 3:
        found.append(0.5 * (found[0] ** 2 - np.einsum("ij...,ji...->...", A, A)))
    return found if d == 1 else [*found, determinant(tuple(A.reshape(d * d, *A.shape[2:])))]
