"""A closed box of gas, solid and gas that is shaken, in one, two and three dimensions."""

from typing import Any

import numpy as np

from fsipetsc.blocks.conditions import NoSlip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.cases.common import at_rest, constant
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.studies.verdicts import Array, Expected, Measured, Solve, round_off
from fsipetsc.studies.verify.data import largest

PERIOD = 0.5
NAMES = ("mass", "momentum", "energy", "entropy")


def box(d: int, h: float, order: int, kappa_e: float = 0.02) -> Any:
    """The problem in d dimensions; kappa_e: conductivity of the solid."""

    def lower(*X: Array) -> list[Any]:
        swirl = 0.1 * np.sin(4.0 * np.pi * X[0]) * np.sin(np.pi * X[-1]) ** 2
        return [2.2 / 5.0, swirl if d > 1 else 0.0, *[0.0] * (d - 1), 5.0]

    def shaken(along: float) -> NoSlip:
        sizes = [along, 0.0, 0.1] if d == 3 else [along, 0.1][2 - d :]
        return NoSlip(
            x=lambda *at: [x + size * np.sin(3.0 * at[-1]) ** 2 for x, size in zip(at, sizes)]
        )

    gases = Fluid(0.01, 0.03, 1.4, 1.0), Fluid(0.01, 0.03, 5.0 / 3.0, 0.5)
    upper = constant(2.0 / (0.5 * 4.0), *[0.0] * d, 4.0)
    solid = ElasticSolid(5.0, 10.0, kappa_e, 2.0, 1.0, p_ref=2.0)
    return layers(
        Layer("lower", gases[0], (0.0, 1.0), lower),
        Layer("solid", solid, (1.0, 2.0), at_rest(4.5)),
        Layer("upper", gases[1], (2.0, 3.0), upper),
        along=((0.0, PERIOD),) * (d - 1),
        lower=shaken(0.0),
        upper=shaken(0.05),
        **{"h": h, "order": order, "units": "none"},
    )


def measure(solve: Solve, order: int, h: float) -> Measured:
    """Changes of all dimensions. Entropy is that of the gases, beside a solid that takes no heat
    from them: then it cannot fall.
    """
    errors: dict[str, float] = {}
    for d in (1, 2, 3):
        series = solve(box(d, h, order), order, h, ts_max_time=1.0).series

        def change(name: str, gain: str, series: Any = series) -> Array:
            kept = series[name] - np.cumsum(series[gain], axis=0)
            return kept - kept[0]

        alone = solve(box(d, h, order, 0.0), order, h, ts_max_time=1.0).series
        size, grown = abs(series["energy"][0]), np.diff(alone["entropy"])
        changes = [change("mass", "mass_in") / series["mass"][0]]
        momenta = [change(f"momentum_{x}", f"impulse_{x}") for x in "xyz"[:d]]
        changes += [np.array(momenta) / size, change("energy", "energy_in") / size]
        changes.append(np.maximum(-grown, 0.0) / grown.sum())
        errors |= {f"{what}, {d}-D": largest(v) for what, v in zip(NAMES, changes)}
    return Measured(errors)


SOURCE = "conservation laws and the second law"
QUICK = {4: (1 / 16,)}
FULL = {k: (1 / 16, 1 / 24) for k in (2, 4, 6)}
WHY = "round-off of 1000 steps"


def expected(quantity: str, order: int, h: float) -> Expected:
    return Expected(error=round_off(1000))
