"""A plate oscillates between two gases in a closed tube: gas | solid | gas.

    mpiexec -n 2 python -m fsipetsc FILE.py -plate_speed 5    # on two ranks, with an option
    python -m fsipetsc FILE.py -help                          # all options
    python -m fsipetsc plot NAME.h5 -o pictures               # draw the result

What to expect: each gas is a spring, and the plate oscillates as (plate_speed/omega) sin(omega t),
omega^2 = 2 GAMMA P0 / (length of a gas * mass of the plate per area): at 10 m/s
it goes 0.054 m to the right and comes back; the period is 0.034 s. docs/cases.md has all that a
case can say.
"""

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

# Conditions at the ends: Wall, Open, Dirichlet for a gas; clamped, free, absorbing for a solid.
from fsipetsc import Fluid, FluidLayer, Option, Problem, Solid, SolidLayer, Wall

# Options of this case: name, type, default, unit, meaning, and perhaps what is allowed.
OPTIONS = (
    Option("plate_speed", float, 10.0, "m/s", "speed of the plate at the start"),
    Option("plate_density", float, 100.0, "kg/m3", "density of the plate", check="positive"),
)
# Defaults of the program's own options: grid spacing [m], end [s], interval of saved profiles [s].
DEFAULTS = {"fsi_h": 0.02, "ts_max_time": 0.04, "fsi_output_dt": 0.001}
GAMMA, P0, T0 = 1.4, 1e5, 300.0  # of the gas: ratio of specific heats, pressure [Pa], T [K]
LEFT, RIGHT, END = 0.4, 0.6, 1.0  # the plate is between the first two, the tube ends at 0 and END


def build(opt: Mapping[str, Any]) -> Problem:
    """The problem, for the options in force: opt["plate_speed"], opt["fsi_h"] and so on."""
    # A gas: viscosity [Pa s], heat conductivity [W/(m K)], gamma, gas constant R/M [J/(kg K)].
    # A solid: modulus 2 mu + lambda [Pa], heat conductivity, density [kg/m3], specific heat.
    air = Fluid(mu=2e-5, kappa=0.026, gamma=GAMMA, R=287.0)
    plate = Solid(K=1e7, kappa_e=0.2, m0=opt["plate_density"], alpha=1000.0)
    speed, density = opt["plate_speed"], P0 / (air.R * T0)

    # Initial data: functions of an array X of coordinates [m]. They return, for each unknown, an
    # array of the same shape or one number. Types are for mypy --strict; they may be left out.
    def left_gas(X: NDArray[Any]) -> tuple[Any, ...]:
        return density, speed * X / LEFT, T0  # density, velocity, temperature

    def right_gas(X: NDArray[Any]) -> tuple[Any, ...]:
        return density, speed * (END - X) / (END - RIGHT), T0

    def solid(X: NDArray[Any]) -> tuple[Any, ...]:
        return speed, -P0, T0, X  # velocity, stress (as the gas presses), temperature, place

    # Layers from left to right: name, material, begin and end [m], initial data. A thin layer
    # takes cells of its own, such as cells=16.
    layers = (
        FluidLayer("left", air, (0.0, LEFT), left_gas),
        SolidLayer("plate", plate, (LEFT, RIGHT), solid),
        FluidLayer("right", air, (RIGHT, END), right_gas),
    )
    # The ends: walls that let no heat through. Open(END, P0, T0) instead would let the gas out.
    return Problem(layers, left=Wall(0.0), right=Wall(END))
