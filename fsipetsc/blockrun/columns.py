"""What is saved and recorded of blocks in d dimensions: names of fields and of series."""

from typing import Any

import numpy as np

from fsipetsc.scheme.part import Gain

#: letters of axes, of positions and of velocities
PLACES, VELOCITIES = "xyz", "uvw"


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


def loses(problem: Any, k: int) -> bool:
    """Whether it is known what a step in time loses of the kinetic and elastic energy of block k.

    A solid with heat 'elastic' whose motion no data replace and no pressure of its heat drives.
    """
    block, conditions = problem.blocks[k], problem.faces_of(k).values()
    stores = block.kind == "solid" and block.material.heat == "elastic"
    driven = stores and (block.forcing is not None or block.material.pressing is not None)
    return stores and not driven and not any(getattr(c, "all_given", False) for c in conditions)


def lossy(problem: Any) -> bool:
    """Whether it is known of any block: see ``loses``."""
    return any(loses(problem, k) for k in range(len(problem.blocks)))


def gained(problem: Any) -> np.dtype:
    """What came in from outside in a step, column by column: the mass of each block of gas; what
    the step lost of the kinetic and elastic energy of solids, where that is known; the work of
    constant forces, where there are any; the impulse; the energy through each face of
    ``face_names``; what of it was heat; all of the energy.
    """
    gases, faces = _gases(problem), len(problem.outer_faces) + 1
    masses = [("mass_in", "f8", (gases,))] if gases else []
    lost = [("lost_energy", "f8")] * lossy(problem) + [("force_work", "f8")] * problem.pulled
    impulses = [(f"impulse_{x}", "f8") for x in PLACES[: problem.dimension]]
    through = [(name, "f8", (faces,)) for name in ("energy_face", "heat_face")]
    return np.dtype([*masses, *lost, *impulses, *through, ("energy_in", "f8")])


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
    names = *PLACES[:d], *VELOCITIES[:d], "T", "p", *(f"t_{x}" for x in PLACES[:d])
    return tuple(f"{name}_point" for name in names)


def spins(d: int) -> tuple[str, ...]:
    """Names of angular momentum about the origin: none in one dimension, that about z in two."""
    axes = ("_x", "_y", "_z") if d == 3 else ("",) * (d - 1)
    return tuple(f"angular_momentum{axis}" for axis in axes)


def step_record(problem: Any, interfaces: int = 0, points: int = 0) -> np.dtype:
    """Recorded of a step.

    Time after it, its length; of each block the least J, and the largest |J - det D x| / J of a
    gas; then shares of the ranks, to be added up: integrals, where its losses are known the kinetic
    and elastic energy of solids, the potential energy of constant forces, in one dimension
    OF_INTERFACES, ``point_names`` of so many nodes, and what came in.
    """
    blocks, gases, d = len(problem.blocks), _gases(problem), problem.dimension
    masses = [("mass", "f8", (gases,))] if gases else []
    momenta = [(f"momentum_{x}", "f8") for x in PLACES[:d]]
    energies = ["solid_energy"] * lossy(problem) + ["potential_energy"] * problem.pulled
    more = [(name, "f8") for name in (*spins(d), *energies)]
    integrals = [*masses, ("energy", "f8"), *momenta, ("entropy", "f8"), *more]
    came = gained(problem)
    rest = [(name, came[name].base, came[name].shape) for name in came.names]
    lines = [(name, "f8", (interfaces,)) for name in OF_INTERFACES] if d == 1 and interfaces else []
    lines += [(name, "f8", (points,)) for name in point_names(d)] if points else []
    extremes = [(name, "f8", (blocks,)) for name in ("least_J", "J_error")]
    return np.dtype([("t", "f8"), ("dt", "f8"), *extremes, *integrals, *lines, *rest])
