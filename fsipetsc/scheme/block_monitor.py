"""After each step the monitor looks at all nodes of a block: it bounds the next step, finds states
that are not physical, and adds up integrals.

    convection   gas: sum_k (|a^k . (u - v)| + c |a^k|) / (J h_k)
                 solid: sqrt(sum_k (c |A^k| / (J0 h_k))^2),  c^2 the largest wave modulus over m0
    diffusion    z nu sum_k |a^k|^2 / (J h_k)^2,  nu = max(4/3 mu/rho, kappa/(rho cv)),
                 z the stiffness of D twice

Extremes and sums are found in columns (fsipetsc.scheme.columns). The last bits of an integral
depend on which rank owns which nodes; no other number is computed from integrals.
"""

import numpy as np

from fsipetsc.equations.vectors import dot, sub
from fsipetsc.kernels.arrays import Array, aligned, column, column_of, node
from fsipetsc.kernels.loops import each
from fsipetsc.operators.sbp import STIFFNESS_OF_WIDE
from fsipetsc.scheme.columns import COLUMNS, clear, collected, count, tiled
from fsipetsc.scheme.observables import PLACES
from fsipetsc.scheme.part import rows_of

#: extremes of a block: 1 if a state is unphysical, largest rates of convection and of diffusion
#: [1/s], minus the least J, largest |J - det D x| / J
UNPHYSICAL, CONVECTION, DIFFUSION, LEAST_J, J_ERROR = range(5)
MONITORED = 5


def room_of(d: int) -> Array:
    """Return memory for the columns in which `gas_monitor` collects."""
    return aligned((MONITORED + len(gas_integrals(d))) * COLUMNS).reshape(-1, COLUMNS)


def gas_monitor(part, q, metrics):
    """Fill part.seen (MONITORED,) and part.sums from the owned nodes; q: (M, d + 3).

    part: a fsipetsc.scheme.gas_record.GasRecord. metrics: those that bound the step.
    """
    room, sums = part.room, len(gas_integrals(len(part.like)))
    clear(room, MONITORED, sums, COLUMNS)
    for row, own, n in rows_of(part):
        for x, i in tiled(0, n):
            count(room, i, *measured(part, q, metrics, own + x, row + x))
    collect(part, room, sums, COLUMNS)


def measured(part, q, metrics, own, n):
    """Return the extremes at an owned node, and what it adds to the sums.

    own: its number among the owned nodes. n: its number in the ghosted array.
    """
    gas, d, mass = part.laws, len(part.like), part.masses[own]
    here = node((0.0,) * (d + 3), q, own)
    w, of_map = gas.primitive(here), part.reference[own]
    convection, diffusion = bounds(gas, w, 1.0 / here[0], metrics, part.per_h, n)
    J = part.grid.jacobian(part.metrics, n)
    positive = np.minimum(np.minimum(w[0], w[2]), here[0]) > 0.0
    apart = abs(here[0] - J) / abs(J)
    known = (convection < np.inf) & (diffusion < np.inf) & (apart < np.inf)  # so are the places
    bad = np.where(known & positive, 0.0, 1.0)
    found = gas_densities(gas, here, w, column(part.like, part.places, n))
    extremes = bad, convection, diffusion, -here[0] / of_map, apart
    return extremes, [mass * found[name] for name in gas_integrals(d)]


def gas_integrals(d):
    """Return the names of the integrals of a gas, in the order of its sums."""
    return "mass", *along_axes("momentum", d), "energy", "entropy", *turning(d)


def gas_densities(gas, here, w, x):
    """Return a dict: name of an integral -> its integrand at a node, per volume of the reference
    coordinates.
    """
    d, (J, rho, *momentum, energy) = len(x), here
    return {
        "mass": rho,
        **dict(zip(along_axes("momentum", d), momentum, strict=True)),
        "energy": energy,
        "entropy": J * gas.entropy_density(w),
        **dict(zip(turning(d), moment(x, momentum), strict=True)),
    }


def along_axes(name, d):
    """Return the names of a vector's d components: name_x, name_y, …."""
    return [f"{name}_{x}" for x in PLACES[:d]]


def turning(d):
    """Return the names of the components of angular momentum about the origin: none in one
    dimension, one in two, three in three.
    """
    return along_axes("angular_momentum", 3) if d == 3 else ["angular_momentum"] * (d - 1)


def moment(x, p):
    """Return the components of the cross product of x and p: none, one or three numbers."""
    pairs = {1: (), 2: ((0, 1),), 3: ((1, 2), (2, 0), (0, 1))}[len(x)]
    return tuple(x[a] * p[b] - x[b] * p[a] for a, b in pairs)


def bounds(gas, w, per_J, metrics, per_h, n):
    """Return the rates of convection and diffusion [1/s] at a node of gas: see the head of this
    file.
    """
    d, convection, squares = len(gas.force), 0.0, 0.0
    like, c = (0.0,) * d, gas.speed_of_sound(w)
    relative = sub(gas.velocity(w), column_of(like, metrics, d * d, n))
    for k in range(d):
        a = column_of(like, metrics, k * d, n)
        size = dot(a, a) * per_h[k] * per_h[k]
        convection = convection + (abs(dot(a, relative)) * per_h[k] + c * np.sqrt(size))
        squares = squares + size
    spread = squares * per_J * per_J
    return convection * per_J, STIFFNESS_OF_WIDE * gas.diffusivity(w) * spread


def collect(part, room, sums, columns):
    """Combine the columns of the room into part.seen and the first ``sums`` of part.sums."""
    least = tuple(-np.inf if c == LEAST_J else 0.0 for c in range(MONITORED))
    for of, found in zip((part.seen, part.sums), collected(room, least, sums, columns)):
        for c, number in enumerate(found):
            of[c] = number.value


def note(part, found):
    """Put what the monitor found in a part into the extremes of its block and the record of the
    step.

    found: a fsipetsc.scheme.runge_kutta.Found.
    """
    begin, seen, sums, columns = 1 + MONITORED * part.block, part.seen, part.sums, part.columns
    extremes, latest = found.extremes, found.latest
    for c in range(MONITORED):
        extremes[begin + c] = (found.pace if c == CONVECTION else 1.0) * seen[c]
    for c in each(columns.size):
        latest[columns[c]] += sums[c]
