"""Conditions of gases and of solids."""

from dataclasses import dataclass
from typing import Any

from fsipetsc.blocks.conditions.condition import Condition, Function


@dataclass(frozen=True)
class Given(Condition):
    """A face of a gas or a solid at which all unknowns are given.

    Args:
        values: `values(*X, t)` returns rho [kg/m3], d velocities [m/s], T [K] of a gas; d
            velocities [m/s], T [K], d positions [m] of a solid.
        x: `x(*X, t)` returns d positions [m] of a face of a gas that moves; None: it is at rest.
        velocity: `velocity(*X, t)` returns d velocities [m/s], the derivative of x; None: it
            follows from x.
    """

    values: Function
    x: Function | None = None
    velocity: Function | None = None
    holds = all_given = True
    passes = "gas"


@dataclass(frozen=True)
class Centre(Condition):
    """An axis or a centre, r = 0. It stands at side 0 of the last axis, where `symmetry` is 1 or 2.

    The first node is half a spacing from it. Beyond it is the block's mirror image.
    """


@dataclass(frozen=True)
class Periodic(Condition):
    """A face that goes on at another one, which is `Periodic`, too.

    A block that is periodic in itself has no faces there: `Block(…, periodic=(True, False))`.

    Args:
        shift: d numbers [m]: the other face is this one moved by them.
    """

    shift: Any
