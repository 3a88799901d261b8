"""Uses the public API, for mypy: what a user's own strict checks see. It is never run."""

import numpy as np
from numpy.typing import NDArray

import fsipetsc as fsi
from fsipetsc.blocks.conditions import Condition, NoSlip, Outflow
from fsipetsc.blocks.layers import Layer, layers

Array = NDArray[np.float64]
OPTIONS = (fsi.Option("speed", float, 10.0, "m/s", "of the plate", check="positive"),)


def build(opt: dict[str, float]) -> fsi.Problem:
    air = fsi.Fluid(mu=0.0, kappa=0.0, gamma=1.4, R=287.0)
    plate = fsi.Solid(K=1e7, kappa_e=0.2, m0=100.0, alpha=1000.0)

    def gas(X: Array) -> tuple[Array, Array, Array]:
        return 1.0 + 0.0 * X, opt["speed"] * X, 300.0 + 0.0 * X

    solid = lambda X: (opt["speed"] + 0.0 * X, -1e5 + 0.0 * X, 300.0 + 0.0 * X, X)  # noqa: E731
    below = fsi.FluidLayer("gas", air, (0.0, 1.0), gas)
    above = fsi.SolidLayer("plate", plate, (1.0, 2.0), solid)
    hot = fsi.Wall(0.0, T=lambda t: 300.0 + t)
    return fsi.Problem((below, above), left=hot, right=fsi.free(-1e5))


def plane() -> fsi.BlockProblem:
    def still(X: Array, Y: Array) -> tuple[Array, ...]:
        return 1.0 + 0.0 * X, 0.0 * X, 0.0 * Y, 300.0 + 0.0 * Y

    sides: dict[tuple[int, int], Condition] = {(0, 0): NoSlip(), (0, 1): Outflow(1e5)}
    air = Layer("air", fsi.Fluid(0.0, 0.0, 1.4, 287.0), (0.0, 1.0), still, sides=sides)
    return layers(air, along=((0.0, 1.0),), h=0.1, lower=NoSlip(), upper=NoSlip())


def drift(order: int) -> float:
    try:
        with fsi.run(build({"speed": 1.0}), order=order, h=0.1, output="a.h5") as run:
            hottest: float = run.layers[0]["T"].max()
            print(run.case, hottest, run.summary["steps"], fsi.compare("b.h5", run.path).equal)
            return float(np.ptp(run.series["energy"]))
    except fsi.InputError as error:
        return error.status
