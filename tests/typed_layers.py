"""A case of layers with types, as `new` writes it: mypy --strict must accept it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

import fsipetsc as fsi
from fsipetsc import Fluid, FluidLayer, Option, Problem, Solid, SolidLayer, Wall

Array = NDArray[Any]
SUMMARY = "a plate oscillates between two gases in a closed tube"
OPTIONS = (
    Option("plate_speed", float, 10.0, "m/s", "speed of the plate at the start"),
    Option("plate_density", float, 100.0, "kg/m3", "density of the plate", check="positive"),
)
DEFAULTS = {"fsi_h": 0.02, "fsi_order": 4, "ts_max_time": 0.04, "fsi_output_dt": 0.001}
P0, T0 = 1e5, 300.0
LEFT, RIGHT, END = 0.4, 0.6, 1.0


def build(opt: Mapping[str, Any]) -> Problem:
    air = Fluid(mu=2e-5, kappa=0.026, gamma=1.4, R=287.0)
    plate = Solid(K=1e7, kappa_e=0.2, m0=opt["plate_density"], alpha=1000.0)
    speed: float = opt["plate_speed"]

    def left_gas(X: Array) -> tuple[float, Array, float]:
        return P0 / (air.R * T0), speed * X / LEFT, T0

    def right_gas(X: Array) -> list[Array]:
        one = np.ones_like(X)
        return [P0 / (air.R * T0) * one, speed * (END - X) / (END - RIGHT), T0 * one]

    def solid(X: Array) -> tuple[float, float, float, Array]:
        return speed, -P0, T0, X

    layers = (
        FluidLayer("left", air, (0.0, LEFT), left_gas),
        SolidLayer("plate", plate, (LEFT, RIGHT), solid),
        FluidLayer("right", air, (RIGHT, END), right_gas),
    )
    return Problem(layers, left=Wall(0.0), right=Wall(END))


def driven() -> list[Problem]:
    """Data that depend on time, and lists for tuples."""
    air, plate = Fluid(0.0, 0.1, 1.4, 287.0, force=9.81), Solid(1e7, 0.2, 100.0, 1000.0)

    def still(X: Array) -> tuple[float, float, float]:
        return 1.0, 0.0, T0

    def heat(X: Array, t: float) -> tuple[float, float, Array]:
        return 0.0, 0.0, t * X

    def at_rest(X: Array) -> tuple[float, float, float, Array]:
        return 0.0, 0.0, T0, X

    gas = FluidLayer("gas", air, (0.0, 1.0), still, forcing=heat)
    solid = SolidLayer("plate", plate, (1.0, 2.0), at_rest)
    piston = Wall(lambda t: 0.1 * np.sin(t), T=lambda t: T0 + t, velocity=lambda t: 0.1 * np.cos(t))
    stopped = Wall(lambda t: np.where(t < 1.0, t, 1.0))
    filled = fsi.Dirichlet(0.0, lambda t: (1.0, t, T0))
    starts = piston, stopped, filled, fsi.Open(0.0, P0, T0)
    driven, pressed = fsi.clamped(lambda t: np.sin(t)), fsi.free(-P0, T=T0)
    ends = driven, pressed, fsi.absorbing(heat_flux=1.0), fsi.clamped()
    return [Problem([gas, solid], start, end, notes=["driven"]) for start, end in zip(starts, ends)]


def drift(case: Problem) -> float:
    """Of the energy in a run: the functions for runs and results."""
    try:
        with fsi.run(case, order=4, h=0.1, output="a.h5") as run:
            hottest: float = run.layers[0]["T"].max()
            print(run.case, hottest, run.summary["steps"], fsi.compare("b.h5", run.path).equal)
            return float(np.ptp(run.series["energy"]))
    except fsi.InputError as error:
        return error.status


def wrong() -> None:
    """What the checker must refuse: an ignored line without an error is an error."""
    air = Fluid("thick", 0.0, 1.4, 287.0)  # type: ignore[arg-type]
    FluidLayer("gas", air, (0.0, 1.0), 1.0)  # type: ignore[arg-type]
    FluidLayer("gas", air, (0.0, 1.0), lambda: (1.0, 0.0, T0))  # type: ignore[arg-type,misc]
    Problem((), left=0.0, right=Wall(END))  # type: ignore[arg-type]
    Wall(0.0, temperature=T0)  # type: ignore[call-arg]
