"""A program that uses the public API, for mypy: what a user's own strict checks see.
It is never run.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import fsipetsc
from fsipetsc import (
    BlockProblem,
    Fluid,
    FluidLayer,
    InputError,
    Option,
    Problem,
    Solid,
    SolidLayer,
    Wall,
    free,
)
from fsipetsc.blocks.conditions import Condition, NoSlip, Outflow
from fsipetsc.blocks.layers import Layer, layers

Array = NDArray[np.float64]
OPTIONS = (Option("speed", float, 10.0, "m/s", "of the plate", check="positive"),)


def build(opt: dict[str, float]) -> Problem:
    air = Fluid(mu=0.0, kappa=0.0, gamma=1.4, R=287.0)
    plate = Solid(K=1e7, kappa_e=0.2, m0=100.0, alpha=1000.0)

    def gas(X: Array) -> tuple[Array, Array, Array]:
        return 1.0 + 0.0 * X, opt["speed"] * X, 300.0 + 0.0 * X

    def solid(X: Array) -> tuple[Array, Array, Array, Array]:
        return opt["speed"] + 0.0 * X, -1e5 + 0.0 * X, 300.0 + 0.0 * X, X

    layers = (
        FluidLayer("gas", air, (0.0, 1.0), gas),
        SolidLayer("plate", plate, (1.0, 2.0), solid),
    )
    return Problem(layers, left=Wall(0.0, T=lambda t: 300.0 + t), right=free(-1e5))


def plane() -> BlockProblem:
    def still(X: Array, Y: Array) -> tuple[Array, ...]:
        return 1.0 + 0.0 * X, 0.0 * X, 0.0 * Y, 300.0 + 0.0 * Y

    sides: dict[tuple[int, int], Condition] = {(0, 0): NoSlip(), (0, 1): Outflow(1e5)}
    air = Layer("air", Fluid(0.0, 0.0, 1.4, 287.0), (0.0, 1.0), still, sides=sides)
    return layers(air, along=((0.0, 1.0),), h=0.1, lower=NoSlip(), upper=NoSlip())


def study() -> dict[int, float]:
    drifts = {}
    for order in (2, 4):
        try:
            problem, output = build({"speed": 1.0}), f"{order}.h5"
            with fsipetsc.run(problem, order=order, h=0.1, output=output) as run:
                drifts[order] = float(np.ptp(run.series["energy"]))
                hottest: float = run.layers[0]["T"].max()
                equal = fsipetsc.compare("2.h5", run.path).equal
                print(run.case, hottest, run.summary["steps"], equal)
        except InputError as error:
            print(error.status, error)
    return drifts
