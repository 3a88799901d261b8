"""The energy of a solid in two dimensions, kept by a Runge-Kutta step to round-off. Compiled.

The rates keep the sum of m0 alpha T and of the mechanical energy

    M = m0 |v|^2/2,  with the heat ELASTIC  m0 |v|^2/2 + W(F),        M_t = m0 v . v_t,  m0 v . v_t + P : F_t

which is not linear in the unknowns, so that a Runge-Kutta method does not keep it: its error is of the fifth order in the step
where the grid resolves the motion, and at a shock it is not. As in one dimension (fsipetsc.scheme.kinetic) the power M_t of a
point is integrated by the same method, from the M of the completed step before, and what the M of the new one is short of
that, its T gets:

    kept = M_0 + dt sum_k b_k (M_t)_k,        m0 alpha T += kept - M

F takes neighbours, so this is done where strains are known anyway, in the look at the new solution. T acts on nothing but heat.
At interfaces the coupling integrates the kinetic energy itself (fsipetsc.coupling.plane); there M is W alone. Where gas and
solid both conduct and the heat is ELASTIC, their temperatures there differ by what T gets in a step until they meet again.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import FORMULA, U64
from fsipetsc.operators.lanes import half
from fsipetsc.operators.memory import load_twice, load_wide, store
from fsipetsc.operators.rows import STRIDE, at
from fsipetsc.operators.vectors import TWICE, WIDE, fma
from fsipetsc.physics.plane.layer import DOF, ELASTIC
from fsipetsc.scheme.plane.targets import at_interface

#: number of the temperature among the unknowns
_T = 4


def kept_size(rows: int, columns: int) -> int:
    """Doubles for what is kept of so many points: rows of whole vectors."""
    return rows * _stride(columns) + TWICE


def _stride(columns: int) -> int:
    return (columns + TWICE - 1) // TWICE * TWICE


_stride_of = njit(**FORMULA)(_stride)


@njit(**FORMULA)
def row_kept(layer, j):
    """Where column 0 of those held would stand in what is kept of row j."""
    return (j - layer.own_y[0]) * _stride_of(layer.own_x[1] - layer.own_x[0]) - layer.own_x[0]


@njit(**FORMULA)
def leave_power(layer, s, place, target, j):
    """Of laws with which the time step has the errors that it has."""


@njit(**FORMULA)
def keep_power(layer, s, place, target, j):
    """Add the power of row j of a block, whose rates are all there, in a stage of a Runge-Kutta method."""
    if target.kept.size == 0:
        return
    dt, row, work = (target.b if target.total.size > 0 else target.a), row_kept(layer, j), at(place.e, 0, j)
    u_row, v_row, u_rates = at(place.v, 2, j), at(place.v, 3, j), place.rates + 2 * STRIDE
    m0, elastic = (0.0 if at_interface(layer, j) else layer.m0), (1.0 if layer.heat == ELASTIC else 0.0)
    for i in range(place.first, place.end, WIDE):
        power = load_wide(s, u_row + i) * load_wide(s, u_rates + i)
        power = m0 * fma(load_wide(s, v_row + i), load_wide(s, u_rates + STRIDE + i), power)
        power = fma(elastic, load_wide(s, work + i), power)
        store(target.kept, row + i, fma(dt, power, load_wide(target.kept, row + i)))


@njit(**FORMULA)
def mended(layer, s, room, y, kept, mend, j, i, count, energy, T):
    """T of a vector of points i .. of row j, of which the first ``count`` are meant, whose M is ``energy``; this is kept.

    mend: whether it is to be what makes up for ``energy``, or as it is. room: where in s there is some for a vector.
    """
    at = row_kept(layer, j) + i
    if mend:
        T = fma(1.0 / (layer.m0 * layer.alpha), load_twice(kept, at) - energy, T)
        to = (j * layer.width + i) * DOF + _T
        store(s, room, T)
        for n in range(min(count, TWICE)):
            y[U64(to + n * DOF)] = s[U64(room + n)]
    if count > WIDE:
        store(kept, at, energy)
    else:  # a block is of whole wide vectors, and what follows is the next one's
        store(kept, at, half(energy, 0))
    return T
