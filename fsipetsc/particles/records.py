"""Particles of a rank as procedures have them: records of tables, data and sums."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

GAS, SOLID = 0, 1


class Table(NamedTuple):
    """Particles on a rank. Rows are members; those of this rank come first, in any order.

    begin: (p + 1,), rows of particle p are row[begin[p]:begin[p + 1]], in the order that all ranks
    have. kind: (rows,) GAS or SOLID. at: (own,) where the first unknown of a member stands in the
    world's vector, apart: (own,) how far its unknowns are apart there. weight: (rows,) H of a gas
    member, M_s of a solid one; alpha: (rows,) specific heat of solids. inertia: (own,) M_s of
    members whose work is booked, else 0. constraint: (p, K) kinds of constraints. facts: (p,)
    records of FACTS, see fsipetsc.particles.members.
    """

    begin: Array
    row: Array
    kind: Array
    at: Array
    apart: Array
    weight: Array
    alpha: Array
    inertia: Array
    constraint: Array
    facts: Array


#: 1 or 0: this rank adds what comes in; forces move the gas, the solid; a clamp gives the place;
#: gas and solid stick; the gas is at a wall, the solid at a clamp; all is given of the gas, of the
#: solid; the temperature of the gas, of the solid; they have one; so have members of the solid
FLAGS = (
    *("mine", "free_gas", "free_solid", "placed", "sticks", "at_wall", "clamped", "given_gas"),
    *("given_solid", "warm_gas", "warm_solid", "shares_heat", "one_T"),
)
#: through which face what moves gas and solid does work, and what gives them temperatures heats
FACES = "moves_gas", "moves_solid", "heats_gas", "heats_solid"
#: also the number of constraints, where the mass of the gas is in ``gain``, the number of its law
NUMBERS = "count", "column", "law"
FACTS = np.dtype([(name, np.int64) for name in (*FLAGS, *FACES, *NUMBERS)], align=True)


class Data(NamedTuple):
    """What conditions prescribe at an instant, for each particle: velocity and acceleration of
    walls (p, d), displacement, velocity and acceleration of clamps (p, d), temperatures (p,) of gas
    and solid, all unknowns: (p, d + 2) of a gas, (rho, rho u, E), and (p, 2d) of a solid, place
    less X and velocity.
    """

    wall: Array
    wall_rate: Array
    clamp: Array
    clamp_velocity: Array
    clamp_rate: Array
    T: Array
    T_solid: Array
    gas: Array
    solid: Array


class State(NamedTuple):
    """What `end_sums` found, for each particle: mass of gas and solid (p,), V (p,), U of the gas
    (p, d + 2), displacement D and velocity v (p, d) and energy per mass e (p,) of the solid.
    mean_energy: (p,) that of its members before a change. capacity, potential: (p,) mean specific
    heat and mean energy per mass that is neither kinetic nor heat, of the solid. U_t (p, d + 2),
    acceleration (p, d) of the solid: what `end_rates` found.
    """

    mass: Array
    solid_mass: Array
    V: Array
    U: Array
    D: Array
    v: Array
    e: Array
    mean_energy: Array
    capacity: Array
    potential: Array
    U_t: Array
    acceleration: Array


class Particles(NamedTuple):
    """The particles of a rank.

    like: (0, …) of d dimensions. laws: the different ones of gases. stored: (rows, 1)
    energy per mass of members that is neither kinetic nor heat; stores: whether it changes. rows:
    (rows, columns) of the exchange. slips: whether any has constraints; normals, turning: (p, 2 d
    K), G and S of each and how they turn. of_normals: (members of those, 2 d K) area vectors,
    of_particle, row_of: particle and row of each. matrix, pi, pivots: (K, K), (K,), (K,) room for
    the constraints of one particle. moves: (p,) whether a wall there moves, place: (p, d) its
    displacement. auxiliary: number of unknowns, at the end of a vector, of what came in.
    """

    like: Any
    table: Table
    laws: Any
    data: Data
    state: State
    stored: Array
    rows: Array
    stores: bool
    slips: bool
    normals: Array
    turning: Array
    of_normals: Array
    of_particle: Array
    row_of: Array
    matrix: Array
    pi: Array
    pivots: Array
    moves: Array
    place: Array
    auxiliary: int
