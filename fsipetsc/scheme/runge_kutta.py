"""The classical Runge-Kutta method of fourth order, each stage written where the next one is read.

With the rates k of a stage

    stage = y + a k,   total = base + b k   a = dt/2, dt/2, dt;  b = dt/6, dt/3, dt/3
    stage = total + dt/6 k                  after the last one: the solution

in one pass over memory.
"""

from numba import njit

from fsipetsc.operators.loops import LOOP

STAGES = 4


@njit(**LOOP)
def advance(y, k, stage, total, number, dt):
    """What follows from the rates k of stage ``number``, 0 to 3: the next stage, and the sum that
    becomes the solution.

    The paper's method has its own, which rounds each operation by itself. It cannot compile this
    one otherwise: on the disk numba takes two compilations of one function for each other.
    """
    a = dt if number == 2 else 0.5 * dt
    b = dt / 3.0 if 0 < number < 3 else dt / 6.0
    for i in range(y.size):
        found = (y[i] if number == 0 else total[i]) + b * k[i]
        if number < 3:
            total[i] = found
            found = y[i] + a * k[i]
        stage[i] = found
