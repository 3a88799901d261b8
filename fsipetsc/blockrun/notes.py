"""What may not be meant in a run on blocks: notes on the completed initial data, on what the grid
does not resolve at the end, and where a solid is beyond its law. NOTES says when each is asked for;
all are collective.
"""

from collections.abc import Collection
from itertools import product
from math import isqrt
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.blocks.maps import place_text
from fsipetsc.equations.tensors import determinant
from fsipetsc.scheme.gas_forms import CONSERVED
from fsipetsc.state import loose

Array = np.ndarray
#: the part of the larger of two pressures by which they may differ at an interface
JUMP = 0.01
#: part of its volume by which a gas may begin with more or less of it than its map says
STRETCHED = 0.01
#: part of the larger modulus K = rho dp/drho, p of a perfect gas, by which the pressures of
#: neighbouring nodes may differ
STEEP = 0.2
#: a smaller stretch is that of a solid that is crushed
CRUSHED = 0.1
#: entries of F^T F - 1 below which the waves of a law are those at rest
SMALL = 0.02
#: part of the largest entry of the tensor that an eigenvalue below 0 must be more than
ROUND_OFF = 1e-8
#: entries of directions of waves, in as many dimensions, -so many … so many
FINEST = {1: 1, 2: 4, 3: 2}


def heat_that_stays(state: Any) -> list[str]:
    """Faces with a temperature whose gas or solid does not conduct heat."""
    found = set()
    for (k, *_), met in state.problem.outer_faces.items():
        name, material = state.problem.blocks[k].name, state.problem.blocks[k].material
        conducts = material.kappa if material.kind == "fluid" else material.kappa_e
        if met.warms and not met.all_given and not conducts:
            found.add(
                f"{type(met).__name__} gives '{name}' a temperature, and it does not conduct heat: "
                "only its nodes at the face have that temperature, so results depend on the grid"
            )
    return sorted(found)


def asked_data(state: Any) -> list[str]:
    """Why Python is asked for data in each stage of a step."""
    why = [one for some in state.comm.allgather(state.scheme.not_recorded) for one in some]
    words = "Python is asked for data in each stage of a step, which takes longer"
    return [f"{words}: {why[0]}"] if why else []


def pressure_jumps(state: Any) -> list[str]:
    """Interfaces at which the pressures of both sides differ; halos are filled."""
    problem, blocks, Pa = state.problem, state.problem.layers, state.problem.unit("Pa")
    pushes = np.zeros((len(problem.interfaces), 2, 2))  # of gas and solid: the sum, number of nodes
    for k, part in state.parts.items():
        for face, met in problem.faces_of(k).items():
            if problem.is_interface(k, *face):
                pair = (met.block, k) if part.block.kind == "solid" else (k, met.block)
                rows = part.part.rows_among(problem.face_nodes(k, *face))
                found = part.pushes(state.y.ghosted(k), rows, *face)
                pushes[problem.interfaces.index(pair), pair.index(k)] += found.sum(), found.size
    state.comm.Allreduce(MPI.IN_PLACE, pushes)
    means = (pushes[..., 0] / pushes[..., 1]).tolist()
    return [
        f"at t = 0 '{blocks[gas].name}' has a pressure of {p:.4g}{Pa} where it meets "
        f"'{blocks[solid].name}', which pushes with {push:.4g}{Pa} (means of the interface): "
        "waves start there"
        for (gas, solid), (p, push) in zip(problem.interfaces, means, strict=True)
        if abs(p - push) > JUMP * max(abs(p), abs(push))
    ]


def stretched_gases(state: Any) -> list[str]:
    """Gases whose grids follow solids that do not begin where the gases end."""
    blocks, volumes = state.problem.layers, np.zeros((len(state.problem.layers), 2))
    for k, part in state.parts.items():
        if part.block.kind == "fluid" and part.block.exact is None:
            of_grid, of_map = state.y.owned(k)[:, 0], part.reference
            volumes[k] = part.weights @ of_grid, part.weights @ of_map
    state.comm.Allreduce(MPI.IN_PLACE, volumes)
    return [
        f"'{block.name}' begins with {100.0 * abs(volume / of_map - 1.0):.3g} % "
        f"{'more' if volume > of_map else 'less'} volume and mass than its map gives it: the first "
        "state of a solid beside it is not where it ends"
        for block, (volume, of_map) in zip(blocks, volumes.tolist(), strict=True)
        if abs(volume - of_map) > STRETCHED * of_map
    ]


def loose_forces(state: Any) -> list[str]:
    """A note for each gas on which a constant force acts node by node."""
    keeps_rest = "; -fsi_convection entropy keeps rest"
    known = [isinstance(gas.material.gas_law, CONSERVED) for gas in state.loose]
    pairs = zip(state.loose, known, strict=True)
    return [f"{loose(gas.name)}{keeps_rest * known}" for gas, known in pairs]


def steep_waves(state: Any) -> list[str]:
    """Where the pressure of a gas jumps from one node to the next, without -fsi_shock."""
    blocks, m = state.problem.layers, state.problem.unit("m")
    steepest = np.zeros((len(blocks), 1 + state.problem.dimension))  # the change, and where it is
    for k, part in () if state.shocks else state.parts.items():
        if part.block.kind == "fluid":
            at, change = part.owned, np.zeros(part.owned.size)
            with np.errstate(all="ignore"):  # corners of halos hold nothing, and are not used
                w = part.equations.primitive(tuple(state.y.ghosted(k).T))
                p, K = w[1], part.equations.law.bulk_modulus(w[0], w[2])
            sizes, stride = part.part.patch.ghosted, 1
            for size in sizes[: part.block.dimension]:
                beside = np.where(at // stride % size < size - 1, at + stride, at)
                apart = np.abs(p[beside] - p[at]) / np.maximum(K[beside], K[at])
                change, stride = np.maximum(change, apart), stride * size
            steepest[k] = change.max(), *part.X[:, at[change.argmax()]]
    every = np.array(state.comm.allgather(steepest))
    found = every[every[..., 0].argmax(axis=0), np.arange(len(blocks))]
    return [
        f"at the end the pressure in '{block.name}' changes by {100 * value:.0f} % from one node "
        f"to the next, at {place_text(X)}{m}: shocks need -fsi_shock 1 -fsi_dissipation 1"
        for block, (value, *X) in zip(blocks, found.tolist(), strict=True)
        if value > STEEP
    ]


# where a solid is beyond its law


class Found(NamedTuple):
    """A node of a solid; the one with the smallest ``order`` comes first. place: X."""

    order: float
    block: int
    number: int
    place: tuple[float, ...]
    value: float


def imaginary_waves(state: Any, t: float, noted: set[int]) -> list[str]:
    """A line for each solid whose waves have become imaginary somewhere, by the last F.

    t: time of the state [s]. noted: the blocks of which it was said before; more are added.
    """
    every = _first_of_all(state, imaginary, noted)
    noted.update(found.block for found in every)
    when, words = f"t = {t:.6g}{state.problem.unit('s')}", "waves have become imaginary"
    return [
        f"{words} in {_where(state, found)}, {when}, where the stretch along them is "
        f"{found.value:.3g}: the law has no meaning here"
        for found in every
    ]


def most_crushed(state: Any) -> str:
    """Which solid is crushed most, and by how much pressure, by the last F; "" if none is."""
    found = min(_first_of_all(state, crushed), default=None)
    if found is None:
        return ""
    K = state.problem.layers[found.block].material.K
    by = f" under a pressure of {found.value / K:.3g} K, K = 2 mu_e + lambda_e" if K > 0.0 else ""
    return (
        f"the solid is crushed in {_where(state, found)}: its stretch is {found.order:.3g}{by}"
        "; a stiffer solid or less pressure helps, shorter steps do not"
    )


def _where(state: Any, found: Found) -> str:
    block, shape = state.problem.layers[found.block], state.shapes[found.block]
    node = ", ".join(map(str, np.unravel_index(found.number, shape[::-1])[::-1]))
    return f"'{block.name}' at {place_text(found.place)}{state.problem.unit('m')} (node {node})"


def _first_of_all(state: Any, look: Any, but: Collection[int] = ()) -> Collection[Found]:
    """Of each solid block, but for some, the node with the smallest order, to six digits, that
    ``look`` finds on any rank; among equals that of the smallest number.
    """
    mine: list[Found] = []
    for k, part in state.parts.items():
        if part.block.kind == "fluid" or k in but:
            continue
        with np.errstate(all="ignore"):  # a bad state has no stress, and is told otherwise
            rows, order, values = look(part, state.y.ghosted(k))
        if rows.size:
            rounded, numbers = [float(f"{v:.5e}") for v in order], part.part.numbers[rows]
            i = np.lexsort((numbers, rounded))[0]
            place = tuple(part.X[:, part.owned[rows[i]]].tolist())
            mine.append(Found(rounded[i], k, int(numbers[i]), place, float(values[i])))
    first: dict[int, Found] = {}
    for found in sorted(one for some in state.comm.allgather(mine) for one in some):
        first.setdefault(found.block, found)
    return first.values()


def crushed(part: SolidPart, q: Array) -> tuple[Array, Array, Array]:
    """Nodes that are crushed: rows, their least stretch, what pushes them together [Pa]."""
    d, F = part.block.dimension, part.F
    good = np.flatnonzero(np.isfinite(F).all(axis=0))
    least = np.linalg.svd(F[: d * d, good].T.reshape(-1, d, d), compute_uv=False)[:, -1]
    stretch = np.min([least, *F[d * d :, good]], axis=0)
    rows = good[stretch < CRUSHED]
    push = -np.linalg.eigvalsh(part.stresses(q, rows)).min(axis=-1) if rows.size else stretch[:0]
    return rows, stretch[stretch < CRUSHED], push


def imaginary(part: SolidPart, q: Array) -> tuple[Array, Array, Array]:
    """Where waves are imaginary: rows, m0 c^2 below 0, the stretch along these waves.

    Waves along N are real if the acoustic tensor along N at constant entropy
    (fsipetsc.equations.solid) is positive: its leading minors are, and its eigenvalues are m0 c^2.
    Nodes with hardly any strain are left out, so that solids of small strain cost next to nothing.
    """
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
    return rows[bad], modulus[bad], stretch[bad]


def _directions(d: int) -> Array:
    """(m, d) unit vectors of directions of waves, one of each two that are opposite."""
    entries = range(-FINEST[d], FINEST[d] + 1)
    some = {N: np.linalg.norm(N) for N in product(entries, repeat=d) if N > (0,) * d}
    return np.unique([np.divide(N, size).round(15) for N, size in some.items()], axis=0)


#: when -> what may be said then
NOTES = {
    "begin": (heat_that_stays, loose_forces, asked_data, stretched_gases, pressure_jumps),
    "saved": (lambda state: imaginary_waves(state, state.time, state.told),),
    "end": (steep_waves,),
}
