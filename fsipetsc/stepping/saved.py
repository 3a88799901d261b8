"""What a result file holds of blocks: fields, columns of the record of a step, recorded nodes."""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.errors import InputError
from fsipetsc.options import Option
from fsipetsc.scheme.observables import GAIN, PLACES, SERIES, TABLE, VELOCITIES, record

Array = np.ndarray


def fields_of(kind: str, d: int, symmetry: int = 0) -> tuple[str, ...]:
    """What is saved of a node. In one dimension the stress of a solid is sigma - p."""
    u, x = tuple(VELOCITIES[:d]), tuple(PLACES[:d])
    if kind == "fluid":
        return ("rho", *u, "T", "p", "J", *x)
    stresses = [f"s_{PLACES[i]}{PLACES[j]}" for i in range(d) for j in range(i, d)]
    hoops = ("sigma_theta",) if symmetry else ()
    return (*u, "T", *stresses, *x, *hoops) if d > 1 else ("u", "T", "sigma", "x", "p", *hoops)


def slices(kind: np.dtype) -> dict[str, slice]:
    """Where the columns of a record of doubles are among these."""
    fields = ((name, kind.fields[name][1] // 8, kind[name].itemsize // 8) for name in kind.names)
    return {name: slice(first, first + size) for name, first, size in fields}


def gained(problem: Any) -> dict[str, slice]:
    """Where what came in from outside is among the last columns of a record, which have it."""
    every = step_record(problem)
    return slices(np.dtype([(n, every[n]) for n in every.names if SERIES[n].kind == GAIN]))


def gain_of(problem: Any) -> SimpleNamespace:
    """What came in from outside in a step, as procedures have it."""
    at, d = gained(problem), problem.dimension
    numbers = np.zeros(max(of.stop for of in at.values()))
    columns = {"mass": "mass_in", "lost": "lost_energy", "work": "force_work"}
    columns |= {"energy": "energy_face", "heat": "heat_face", "total": "energy_in"}
    found = {name: numbers[at.get(column, slice(0))] for name, column in columns.items()}
    impulse = numbers[at["impulse_x"].start :][:d]
    return SimpleNamespace(numbers=numbers, impulse=impulse, **found)


def step_record(problem: Any, points: int = 0) -> np.dtype:
    """The columns of a step's record; from the integrals on these are shares of the ranks."""
    d, blocks = problem.dimension, problem.blocks
    has = {"", ("line", "plane", "space")[d - 1]}
    has.add("pulled" * any(any(block.material.force) for block in blocks))
    has.add("lossy" * any(map(problem.loses, range(len(blocks)))))
    names = [name for one in TABLE if one.needs in has for name in one.names(d)]
    counts = {"layer": len(blocks), "gas": sum(block.kind == "fluid" for block in blocks)}
    counts |= {"interface": len(problem.interfaces), "point": points}
    return np.dtype(record(names, {**counts, "face": len(problem.outer_faces) + 1}))


class Probe(NamedTuple):
    """A node of a block, and its place X in the reference map [m]."""

    block: int
    node: int
    X: tuple[float, ...]


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
    """The node next to a place, on an interface that of the solid. InputError for one outside."""
    found = []  # of each block: distance, whether it is a gas, its number, node
    for k, block in enumerate(problem.layers):
        apart = np.linalg.norm(problem.places(k, np.arange(np.prod(block.shape))) - place, axis=1)
        found.append((float(apart.min()), block.kind == "fluid", k, int(apart.argmin())))
    least = min(found)[0]
    *_, k, node = min(found, key=lambda one: (one[0] > least + problem.tolerance, *one[1:]))
    shape = problem.blocks[k].shape
    at = np.unravel_index(node, shape, order="F")
    cells = np.ix_(*(np.arange(max(i - 1, 0), min(i + 2, n)) for i, n in zip(at, shape)))
    around = problem.places(k, np.ravel_multi_index(cells, shape, order="F").ravel())
    X = problem.places(k, np.array([node]))[0]
    if least > np.linalg.norm(around - X, axis=1).max():
        text = ",".join(f"{x:g}" for x in place)
        where = f"no block is there; the nearest node is {least:g} away"
        raise InputError(f"-fsi_probes {text}: {where}")
    return Probe(k, node, tuple(X.tolist()))
