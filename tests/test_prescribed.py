"""What walls prescribe: when data of time are asked for, and what is made of them."""

import numpy as np
import pytest

from fsipetsc import Fluid, FluidLayer, InputError, Problem, Wall
from fsipetsc.particles.members import particles_of
from fsipetsc.particles.prescribed import Prescribed
from fsipetsc.problem import blocks_of_line

STEP = 1 / 64


def prescribed(x, velocity=None):
    gas = Fluid(0.0, 0.0, 1.4, 1.0)
    layer = FluidLayer("gas", gas, (0.0, 1.0), lambda X: (1.0 + 0.0 * X, 0.0 * X, 1.0 + 0.0 * X))
    made = blocks_of_line(Problem((layer,), Wall(x, velocity=velocity), Wall(1.0)), 0.1, 4)
    particles = particles_of(made)
    return Prescribed(made, particles, range(len(particles)), lambda: STEP)


#: place and velocity of walls that are as they should be
RIGHT = {
    "swings": (lambda t: 0.1 * np.sin(7 * t), lambda t: 0.7 * np.cos(7 * t)),
    "kink": (lambda t: np.maximum(0.0, t - 0.3), lambda t: np.where(t > 0.3, 1.0, 0.0)),
    "far": (lambda t: 1e3 + 1e-3 * t, lambda t: 1e-3),
    "rest": (lambda t: 0.2, lambda t: 0.0),
    "unrecorded": (lambda t: max(0.0, t - 0.3), lambda t: float(t > 0.3)),
}


@pytest.mark.parametrize("t_end", [1e-4, 1.0, 1e9])
@pytest.mark.parametrize("name", RIGHT)
def test_the_velocity_of_a_wall_is_the_derivative_of_its_place(name, t_end):
    """Else it is refused, where it is off by a hundredth, or from some time on."""
    x, v = RIGHT[name]
    prescribed(x, v).check_motion(t_end)
    if name not in ("rest", "unrecorded") and (name, t_end) != ("kink", 1e-4):
        for wrong in (lambda t: 1.01 * v(t), lambda t: v(t) * (1.0 if t < 0.5 * t_end else 2.0)):
            with pytest.raises(InputError, match=r"line \d+: velocity of NoSlip at t = .*x alone"):
                prescribed(x, wrong).check_motion(t_end)
