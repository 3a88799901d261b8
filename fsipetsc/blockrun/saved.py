"""What a result file holds of blocks: names of fields, columns of the record of a step; nodes that
are recorded at each step (-fsi_probes).
"""

from collections.abc import Collection, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.errors import InputError
from fsipetsc.options import Option
from fsipetsc.scheme.observables import (
    EXTREME,
    GAIN,
    INTEGRAL,
    PLACE,
    PLACES,
    STEP,
    TABLE,
    VELOCITIES,
    of_blocks,
    record,
)

Array = np.ndarray


def fields_of(kind: str, d: int, symmetry: int = 0) -> tuple[str, ...]:
    """What is saved of each node. In one dimension the stress of a solid is sigma - p, p the
    pressure of ``pressing``; around an axis or a centre that of the hoops is saved, too.
    """
    u, x = tuple(VELOCITIES[:d]), tuple(PLACES[:d])
    if kind == "fluid":
        return ("rho", *u, "T", "p", "J", *x)
    stresses = [f"s_{PLACES[i]}{PLACES[j]}" for i in range(d) for j in range(i, d)]
    hoops = ("sigma_theta",) if symmetry else ()
    return (*u, "T", *stresses, *x, *hoops) if d > 1 else ("u", "T", "sigma", "x", "p", *hoops)


def gain_of(problem: Any) -> SimpleNamespace:
    """What comes in, as procedures have it."""
    kind = gained(problem)
    numbers, at = np.zeros(kind.itemsize // 8), slices(kind)
    columns = {"mass": "mass_in", "lost": "lost_energy", "work": "force_work"}
    columns |= {"energy": "energy_face", "heat": "heat_face", "total": "energy_in"}
    found = {name: numbers[at.get(column, slice(0))] for name, column in columns.items()}
    first = at["impulse_x"].start
    impulse = numbers[first : first + problem.dimension]
    return SimpleNamespace(numbers=numbers, impulse=impulse, **found)


def slices(kind: np.dtype) -> dict[str, slice]:
    """Where the columns of a record of doubles are among these."""
    fields = ((name, kind.fields[name][1] // 8, kind[name].itemsize // 8) for name in kind.names)
    return {name: slice(first, first + size) for name, first, size in fields}


#: recorded of interfaces in one dimension: position [m], velocity [m/s], sigma [Pa] and
#: temperature [K] of the solid's end
OF_INTERFACES = "x_interface", "u_interface", "sigma_interface", "T_interface"


def step_record(
    problem: Any,
    points: int = 0,
    kinds: Collection[str] = (STEP, EXTREME, INTEGRAL, PLACE, GAIN),
) -> np.dtype:
    """The columns of these kinds that a record of a step has, with so many nodes that are recorded;
    from the integrals on these are shares of the ranks.
    """
    d, blocks = problem.dimension, problem.blocks
    has = {"lossy": any(map(problem.loses, range(len(blocks)))), "pulled": problem.pulled}
    has |= {name: d == k for k, name in enumerate(("line", "plane", "space"), 1)}
    names = of_blocks([name for name, there in has.items() if there], d, kinds)
    counts = {"layer": len(blocks), "gas": sum(block.kind == "fluid" for block in blocks)}
    counts |= {"interface": len(problem.interfaces), "point": points}
    return np.dtype(record(list(names), {**counts, "face": len(problem.outer_faces) + 1}))


def gained(problem: Any) -> np.dtype:
    """What came in from outside in a step, column by column."""
    return step_record(problem, kinds=(GAIN,))


class Probe(NamedTuple):
    """A node of a block, its place X in the reference map [m], and (axis, side) of the solid's face
    if it is at an interface.
    """

    block: int
    node: int
    X: tuple[float, ...]
    face: tuple[int, int] | None = None


def chosen(problem: BlockProblem, probes: str | None) -> list[Probe]:
    """The nodes nearest to the places that "X,Y;X,Y" names. InputError for places outside."""
    d, pieces = problem.dimension, probes.split(";") if probes else ()
    probe = Option("fsi_probes", "floats", None, "m", "")
    places = [np.array(probe.parse(piece)) for piece in pieces]
    if any(place.size != d for place in places):
        wanted = ",".join("XYZ"[:d])
        raise InputError(f"-fsi_probes {probes}: expected {wanted}, and ; between several")
    return [_nearest(problem, place) for place in places]


def _nearest(problem: BlockProblem, place: Array) -> Probe:
    """The node next to a place; on an interface that of the solid. InputError for a place that is
    further from it than its neighbours are: it is outside.
    """
    found = []  # of each block: distance, whether it is a gas, its number, node, X, size of cells
    for k, block in enumerate(problem.layers):
        X = problem.places(k, np.arange(np.prod(block.shape)))
        apart = np.linalg.norm(X - place, axis=1)
        node = int(apart.argmin())
        at = np.unravel_index(node, block.shape, order="F")
        beside = tuple(slice(max(i - 1, 0), i + 2) for i in at)
        around = X.reshape(*block.shape, -1, order="F")[beside] - X[node]
        size = np.linalg.norm(around, axis=-1).max()
        found.append((float(apart[node]), block.kind == "fluid", k, node, X[node].tolist(), size))
    least = min(found)[0]
    near = [one for one in found if one[0] <= least + problem.tolerance]
    if not any(apart <= size for apart, *_, size in near):
        text = ",".join(f"{x:g}" for x in place)
        where = f"no block is there; the nearest node is {least:g} away"
        raise InputError(f"-fsi_probes {text}: {where}")
    _, gas, k, node, X, _ = min(near, key=lambda one: one[1:3])
    faces = () if gas else sorted(problem.faces_of(k))
    there = (face for face in faces if problem.is_interface(k, *face))
    face = next((face for face in there if node in problem.blocks[k].face_nodes(*face)), None)
    return Probe(k, node, tuple(X), face)


def note_nodes(state: Any, noted: Sequence[tuple[int, Probe, int]]) -> None:
    """Write into the record of a step what is known of nodes (number, node, its row here) of the
    completed state, whose halos are filled: place, velocity, temperature; pressure, of solids minus
    the mean of the normal stresses in the plane and of hoops; traction on the solid at an
    interface, else 0.
    """
    d = state.problem.dimension
    names = [name for one in TABLE if one.of == "point" for name in one.names(d)]
    for number, node, row in noted:
        part, q = state.parts[node.block], state.y.ghosted(node.block)
        saved = part.fields(q, slice(row, row + 1))[0]
        known = dict(zip(part.names, saved.tolist(), strict=True))
        traction = [0.0] * d
        if part.block.kind == "solid":
            stress = part.stressed(q, [row])[2][..., 0]
            of_hoops = known.get("sigma_theta", 0.0) - (known["p"] if d == 1 else 0.0)
            normal = [*np.diag(stress), *[of_hoops] * state.problem.symmetry]
            known["p"] = -float(np.sum(normal)) / len(normal)
            if node.face is not None:
                traction = (stress @ part.normals([row], *node.face)[0]).tolist()
        fields = (known[name.removesuffix("_point")] for name in names[: 2 * d + 2])
        for name, value in zip(names, [*fields, *traction], strict=True):
            state.latest[name][number] = value
