"""What is saved and recorded of blocks in d dimensions: names of fields and of series."""

from __future__ import annotations

from typing import Any

import numpy as np

from fsipetsc.blocks.conditions import Given

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
    return stores and not driven and not any(isinstance(c, Given) for c in conditions)


def gained(gases: int, d: int, lossy: bool = False) -> np.dtype:
    """What came in from outside in a step: mass of each block of gas, impulse, energy; lossy: and
    before the impulse what the step lost of the kinetic and elastic energy of solids.
    """
    lost = [("lost_energy", "f8")] * lossy
    impulses = [(f"impulse_{x}", "f8") for x in PLACES[:d]]
    masses = [("mass_in", "f8", (gases,))] if gases else []
    return np.dtype([*masses, *lost, *impulses, ("energy_in", "f8")])


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


def step_record(
    blocks: int, gases: int, d: int, interfaces: int, points: int = 0, lossy: bool = False
) -> np.dtype:
    """Recorded of a step.

    Time after it, its length; of each block the least J, and the largest |J - det D x| / J of a
    gas; then shares of the ranks, to be added up: integrals (lossy: and the kinetic and elastic
    energy of solids that ``loses`` names), in one dimension OF_INTERFACES, ``point_names`` of so
    many nodes, and what came in.
    """
    masses = [("mass", "f8", (gases,))] if gases else []
    momenta = [(f"momentum_{x}", "f8") for x in PLACES[:d]]
    more = [(name, "f8") for name in (*spins(d), *["solid_energy"] * lossy)]
    integrals = [*masses, ("energy", "f8"), *momenta, ("entropy", "f8"), *more]
    came = gained(gases, d, lossy)
    rest = [(name, came[name].base, came[name].shape) for name in came.names]
    lines = [(name, "f8", (interfaces,)) for name in OF_INTERFACES] if d == 1 and interfaces else []
    lines += [(name, "f8", (points,)) for name in point_names(d)] if points else []
    extremes = [(name, "f8", (blocks,)) for name in ("least_J", "J_error")]
    return np.dtype([("t", "f8"), ("dt", "f8"), *extremes, *integrals, *lines, *rest])
