"""What is known after a step: extremes of nodes, which bound the next one, sums, what came in.

Each node counts in one column of a room, which has a row for each extreme, then one for each sum.
In the end the columns are combined in their order, so the bits do not depend on the vector length.
The last bits of a sum depend on which rank owns which nodes; no other number is computed from sums.
"""

import numpy as np

from fsipetsc.equations.vectors import cross
from fsipetsc.kernels.loops import each, variable
from fsipetsc.scheme.observables import PLACES, VELOCITIES
from fsipetsc.scheme.part import rows_of
from fsipetsc.scheme.plan import BAD, RATE, SAID_STOP, STOP

#: columns of a room
ROOM_COLUMNS = 64
#: how many extremes a block has: 1 if a state is unphysical, largest rates of convection and of
#: diffusion [1/s], minus the least J, largest |J - det D x| / J; the places of two of them
MONITORED, CONVECTION, LEAST_J = 5, 1, 3


def survey(room, least, rows, see, columns=ROOM_COLUMNS):
    """Return variables with the extremes of all nodes, each at least ``least``, and a dict: name ->
    variable with a sum. rows: one loop, which yields begin, end and more of nodes begin … end - 1:
    [(a, b, None)] of a layer; of a block 0, n and where a row begins, of each row. see(i, more):
    the extremes of a node, of which NaN is none, and a dict: name -> what is summed.
    """
    room[: len(least), :columns], room[len(least) :, :columns] = -np.inf, 0.0
    for begin, end, more in rows:
        for tile in each((end - begin + (columns - 1)) // columns):
            first = begin + tile * columns
            for c in each(np.minimum(columns, end - first), vector=True):
                extremes, summed = see(first + c, more)
                for row, number in enumerate(extremes):
                    room[row, c] = np.where(number > room[row, c], number, room[row, c])
                for row, number in enumerate(summed.values(), len(least)):
                    room[row, c] += number
    largest, totals = [variable(x) for x in least], {name: variable() for name in summed}
    for c in each(columns):
        for row, found in enumerate(largest):
            found.value = np.where(room[row, c] > found.value, room[row, c], found.value)
        for row, total in enumerate(totals.values(), len(least)):
            total.value += room[row, c]
    return largest, totals


def observe(part, found, see):
    """Put extremes of a part into those of its block, and its integrals into the record of the
    step. see: returns, for an owned node's numbers among the owned ones and in the ghosted array,
    its extremes, its place, its momentum and energy and other integrands by name, per mass.
    found: see fsipetsc.scheme.plan.
    """
    columns, names = part.columns, vars(part.columns)

    def weighed(c, at):
        own, mass = at[1] + c, part.masses[at[1] + c]
        extremes, x, p, more = see(own, at[0] + c)
        densities = {**along_axes("momentum", p), **moment(x, p), **more}
        return extremes, {name: mass * densities[name] for name in densities if name in names}

    rows = ((0, n, (node, own)) for node, own, n in rows_of(part))
    least = [-np.inf if c == LEAST_J else 0.0 for c in range(MONITORED)]
    extremes, sums = survey(part.room, least, rows, weighed, part.room.shape[1])
    for c, one in enumerate(extremes):
        pace = found.pace if c == CONVECTION else 1.0
        found.extremes[1 + MONITORED * part.k + c] = pace * one.value
    for name, total in sums.items():
        found.latest[getattr(columns, name)] += total.value


def along_axes(name, vector):
    """Return the components of a vector by their names name_x, name_y, …."""
    return {f"{name}_{x}": number for x, number in zip(PLACES, vector, strict=False)}


def moment(x, p):
    """Return the cross product of x and p by names of angular momentum about the origin: in one
    dimension none, in two a number, in three its components.
    """
    if len(x) < 3:
        return {"angular_momentum": x[0] * p[1] - x[1] * p[0]} if len(x) == 2 else {}
    return along_axes("angular_momentum", cross(x, p))


def note_points(part, found, known):
    """Put into the record of the step what known(own, node) returns of nodes that are recorded, by
    their numbers among the owned ones and in the ghosted array: place, velocity, T, p.
    """
    points, d = part.points, part.d
    names = *(f"{x}_point" for x in (*PLACES[:d], *VELOCITIES[:d])), "T_point", "p_point"
    for m in each(points.shape[0]):
        own = points[m, 1]
        for name, value in zip(names, known(own, part.patch.ghosted_rows(own)), strict=True):
            found.latest[getattr(part.columns, name) + points[m, 0]] = value


def begin_monitor(found):
    """Clear what the monitor found after the step before."""
    found.latest[:] = 0.0
    for i in each(found.extremes.size):  # a least J is found as the largest -J
        found.extremes[i] = np.where((i - 1) % MONITORED == LEAST_J, -np.inf, 0.0)
    found.extremes[0] = found.results[SAID_STOP]


def note_extremes(found):
    """From the extremes of all ranks find the bound on the next step, and whether a state is bad.

    extremes: (1 + MONITORED blocks,), what a rank says of stopping, and those of each block. rates:
    (blocks, 2). latest: begins with the least J and the departure of J of each block.
    """
    extremes, rates, results, latest = found.extremes, found.rates, found.results, found.latest
    bad, blocks = variable(0.0), rates.shape[0]
    for k in each(blocks):
        of_block = extremes[1 + MONITORED * k :]
        bad.value = np.maximum(bad.value, of_block[0])
        rates[k, 0], rates[k, 1] = of_block[1], of_block[2]
        latest[k], latest[blocks + k] = -of_block[3], of_block[4]
    results[RATE] = rate_of(rates.reshape(-1))
    results[BAD], results[STOP] = bad.value, extremes[0]


def rate_of(rates):
    """Return 1 over the longest step at Courant number 1, the 4-norm of the largest rates of
    convection and diffusion [1/s]: the smaller of the two steps alone is too long. rates: of both,
    of one block or layer after the other. What is no number stays so.
    """
    convection, diffusion = variable(), variable()
    for k in each(rates.size // 2):
        convection.value = np.maximum(convection.value, rates[2 * k])
        diffusion.value = np.maximum(diffusion.value, rates[2 * k + 1])
    return np.sqrt(np.sqrt(convection.value**4 + diffusion.value**4))


def note_gained(found, y):
    """Move what came in during a step from auxiliary unknowns to the last columns of ``latest``.

    What a step loses of the energy of solids is W + E - E', with W the work on them, E before and
    E' after it. The auxiliary unknown has E and gets W, and the column has -E' of the monitor:
    their sum is the loss. Less that the unknown has E', for the next step.
    """
    count, latest = found.gain.numbers.size, found.latest
    first, auxiliary = latest.size - count, found.y.size - count
    for c in each(count):
        gained = latest[first + c] + y[auxiliary + c]
        latest[first + c] = gained
        y[auxiliary + c] -= gained
