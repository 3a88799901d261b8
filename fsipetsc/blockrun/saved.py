"""What a result file holds of blocks, and what messages say of them: names of fields and of series,
grids, values at nodes, errors against exact solutions; nodes that are recorded at each step
(-fsi_probes).
"""

from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import block_values, checked, names_of
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
from fsipetsc.scheme.part import Gain
from fsipetsc.state import Seen, State

Array = np.ndarray


def fields_of(kind: str, d: int, symmetry: int = 0) -> tuple[str, ...]:
    """Saved of each node.

    gas: density, velocity, temperature, pressure, J, position. solid: velocity, temperature, Cauchy
    stress, position; in one dimension the stress is sigma - p, p the pressure of ``pressing``, and
    around an axis or a centre there is that of the hoops, sigma_theta (- p in one dimension).
    """
    u, x = tuple(VELOCITIES[:d]), tuple(PLACES[:d])
    if kind == "fluid":
        return ("rho", *u, "T", "p", "J", *x)
    stresses = [f"s_{PLACES[i]}{PLACES[j]}" for i in range(d) for j in range(i, d)]
    hoops = ("sigma_theta",) if symmetry else ()
    return (*u, "T", *stresses, *x, *hoops) if d > 1 else ("u", "T", "sigma", "x", "p", *hoops)


def lossy(problem: Any) -> bool:
    """Whether it is known of any block what a step loses."""
    return any(problem.loses(k) for k in range(len(problem.blocks)))


def gain_of(problem: Any) -> Gain:
    """What comes in, as procedures have it."""
    kind = gained(problem)
    numbers, at = np.zeros(kind.itemsize // 8), slices(kind)
    some = "mass_in", "lost_energy", "force_work"
    mass, lost, work = (numbers[at.get(name, slice(0))] for name in some)
    first = at["impulse_x"].start
    impulse = numbers[first : first + problem.dimension]
    rest = (numbers[at[name]] for name in ("energy_face", "heat_face", "energy_in"))
    return Gain(numbers, mass, lost, work, impulse, *rest)


def slices(kind: np.dtype) -> dict[str, slice]:
    """Where the columns of a record of doubles are among these."""
    fields = ((name, kind.fields[name][1] // 8, kind[name].itemsize // 8) for name in kind.names)
    return {name: slice(first, first + size) for name, first, size in fields}


#: recorded of interfaces in one dimension: position [m], velocity [m/s], sigma [Pa] and
#: temperature [K] of the solid's end
OF_INTERFACES = "x_interface", "u_interface", "sigma_interface", "T_interface"


def step_record(
    problem: Any,
    interfaces: int = 0,
    points: int = 0,
    kinds: Collection[str] = (STEP, EXTREME, INTEGRAL, PLACE, GAIN),
) -> np.dtype:
    """The columns of these kinds that a record of a step has, with so many interfaces in one
    dimension and nodes that are recorded; from the integrals on these are shares of the ranks.
    """
    d, faces = problem.dimension, len(problem.outer_faces) + 1
    has = {"lossy": lossy(problem), "pulled": problem.pulled}
    has |= {name: d == k for k, name in enumerate(("line", "plane", "space"), 1)}
    names = of_blocks([name for name, there in has.items() if there], d, kinds)
    gases = sum(block.kind == "fluid" for block in problem.blocks)
    counts = {"layer": len(problem.blocks), "gas": gases, "interface": interfaces}
    return np.dtype(record(list(names), {**counts, "point": points, "face": faces}))


def gained(problem: Any) -> np.dtype:
    """What came in from outside in a step, column by column."""
    return step_record(problem, kinds=(GAIN,))


# of a state


def header(state: Any) -> dict[str, Any]:
    """What a result file says of blocks, interfaces, and nodes recorded at each step."""
    found, problem = State.header(state), state.problem
    for layer, block in zip(found["layers"], problem.blocks, strict=True):
        layer["periodic"] = list(block.periodic)[::-1]
    return {
        **found,
        "interface_faces": [problem.interface_faces(n)[0] for n in range(len(problem.interfaces))],
        "faces": problem.face_names,
        "symmetry": problem.symmetry,
        "points": [[node.name, list(node.X)] for node in state.recorded],
    }


def grids(state: Any) -> list[dict[str, Any]]:
    """What the writer must know: see RunWriter."""
    found = []
    for k, shape in enumerate(state.shapes):
        X = state.problem.places(k, state.layout.natural(k))
        found.append({"n": int(np.prod(shape)), "X": X})
    return found


def seen(state: Any) -> Iterator[Seen]:
    """Values at this rank's nodes, block by block."""
    problem, d = state.problem, state.problem.dimension
    for k, part in state.parts.items():
        columns = dict(zip(part.names, state.saved(k).T, strict=True))
        names = "J", "rho", *VELOCITIES[:d], "T"
        if part.block.kind == "solid":  # T of a law of J < 0 is no number: J says more
            columns["J"] = part.volume_ratio()
            names = "J", *PLACES[:d], *VELOCITIES[:d], "T"
        values, numbers = {name: columns[name] for name in names}, part.part.numbers
        x = np.stack([columns[name] for name in PLACES[:d]], axis=1)
        yield Seen(k, numbers, values, x, problem.places(k, numbers))


def powers(state: Any, k: int, names: Sequence[str], t: float, power: int) -> Array:
    """Of this rank's nodes of block k sum w |difference|^power at time t [s], with w = H times J of
    the reference map. InputError.
    """
    part = state.parts[k]
    block, X = part.block, part.X[:, part.owned]
    exact = block_values(block, "exact", X, t)
    if len(names) > len(exact):
        where = f"exact of block '{block.name}' at t = {t:.6g}"
        exact += checked(block.exact_stress, (*X, t), X, names[len(exact) :], where)
    saved = dict(zip(part.names, state.saved(k).T, strict=True))
    w = part.weights * part.reference / (X[-1] ** state.problem.symmetry)
    pairs = zip(names, exact, strict=True)
    return np.array([np.sum(w * np.abs(saved[name] - value) ** power) for name, value in pairs])


def compared(state: Any, kind: str) -> tuple[str, ...]:
    """What is compared of the blocks of a kind: stresses where all solids have an exact_stress."""
    blocks, d = state.problem.blocks, state.problem.dimension
    unknowns = names_of(kind, "exact", d)
    if kind == "fluid" or any(b.exact_stress is None for b in blocks if b.kind == kind):
        return unknowns
    return (*unknowns, *(n for n in fields_of(kind, d) if n.startswith(("s_", "sigma"))))


# nodes that are recorded


class Probe(NamedTuple):
    """A node of a block. name: of the block; X: its place in the reference map [m].

    face: (axis, side) of the solid's face at an interface; None where there is none.
    """

    name: str
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
    near = [of_block for of_block in found if of_block[0] <= least + problem.tolerance]
    if not any(apart <= size for apart, *_, size in near):
        text = ",".join(f"{x:g}" for x in place)
        nearest = f"the nearest node is {least:g} away"
        raise InputError(f"-fsi_probes {text}: no block is there; {nearest}")
    _, _, k, node, X, _ = min(near, key=lambda of_block: of_block[1:3])
    faces = problem.faces_of(k) if problem.layers[k].kind == "solid" else ()
    there = (face for face in sorted(faces) if problem.is_interface(k, *face))
    face = next((face for face in there if node in problem.blocks[k].face_nodes(*face)), None)
    return Probe(problem.layers[k].name, k, node, tuple(X), face)


def here_of(state: Any) -> list[tuple[int, Probe, int]]:
    """(number, node, its place among those that this rank owns) of the recorded nodes here."""
    found = []
    for i, node in enumerate(state.recorded):
        part = state.layout.parts.get(node.block)
        if part is not None and node.node in part.numbers:
            found.append((i, node, int(part.rows(np.array([node.node]))[0])))
    return found


def note_nodes(state: Any, here: Sequence[tuple[int, Probe, int]]) -> None:
    """Write into the record of a step what is known of nodes here, of the completed state, whose
    halos are filled: place, velocity, temperature; pressure, of solids minus the mean of the normal
    stresses in the plane and of hoops; traction on the solid at an interface, else 0.
    """
    d = state.problem.dimension
    names = [name for one in TABLE if one.of == "point" for name in one.names(d)]
    for number, node, row in here:
        part, q = state.parts[node.block], state.y.ghosted(node.block)
        saved = part.fields(q, slice(row, row + 1))[0]
        known = dict(zip(part.names, saved.tolist(), strict=True))
        traction = [0.0] * d
        if part.block.kind == "solid":
            (stress,) = part.stresses(q, [row])
            of_hoops = known.get("sigma_theta", 0.0) - (known["p"] if d == 1 else 0.0)
            normal = [*np.diag(stress), *[of_hoops] * state.problem.symmetry]
            known["p"] = -float(np.sum(normal)) / len(normal)
            if node.face is not None:
                traction = (stress @ part.normals([row], *node.face)[0]).tolist()
        fields = (known[name.removesuffix("_point")] for name in names[: 2 * d + 2])
        for name, value in zip(names, [*fields, *traction], strict=True):
            state.latest[name][number] = value
