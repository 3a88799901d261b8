"""What is saved and recorded of blocks in d dimensions: names of fields and of series."""

from collections.abc import Collection
from typing import Any

import numpy as np

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


def gained(problem: Any) -> np.dtype:
    """What came in from outside in a step, column by column."""
    return _record(problem, (GAIN,))


def _record(problem: Any, kinds: Collection[str], interfaces: int = 0, points: int = 0) -> np.dtype:
    """The columns of these kinds that the problem has."""
    d, faces = problem.dimension, len(problem.outer_faces) + 1
    has = {"lossy": lossy(problem), "pulled": problem.pulled}
    has |= {name: d == k for k, name in enumerate(("line", "plane", "space"), 1)}
    names = of_blocks([name for name, there in has.items() if there], d, kinds)
    counts = {"layer": len(problem.blocks), "gas": _gases(problem), "interface": interfaces}
    return np.dtype(record(list(names), {**counts, "point": points, "face": faces}))


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


def _gases(problem: Any) -> int:
    return sum(block.kind == "fluid" for block in problem.blocks)


#: recorded of interfaces in one dimension: position [m], velocity [m/s], sigma [Pa] and
#: temperature [K] of the solid's end
OF_INTERFACES = "x_interface", "u_interface", "sigma_interface", "T_interface"


def point_names(d: int) -> tuple[str, ...]:
    """Recorded of chosen nodes: place [m], velocity [m/s], T [K], pressure, traction [Pa]."""
    return tuple(name for one in TABLE if one.of == "point" for name in one.names(d))


def step_record(problem: Any, interfaces: int = 0, points: int = 0) -> np.dtype:
    """Recorded of a step with so many interfaces in one dimension and nodes that are recorded; from
    the integrals on these are shares of the ranks, to be added up.
    """
    kinds = STEP, EXTREME, INTEGRAL, PLACE, GAIN
    return _record(problem, kinds, interfaces, points)
