"""Conditions of gases and of solids."""

from dataclasses import dataclass
from typing import Any

from fsipetsc.blocks.conditions.condition import Condition, Function


@dataclass(frozen=True)
class Given(Condition):
    """All unknowns are given: values(*X, t) -> (rho, u_1..u_d, T) of a gas, (v_1..v_d, T, x_1..x_d)
    of a solid. The face of a gas is at rest, or moved as a NoSlip.
    """

    values: Function
    x: Function | None = None
    velocity: Function | None = None
    holds = all_given = True
    passes = "gas"


@dataclass(frozen=True)
class Centre(Condition):
    """No face: beyond the first node, half a spacing from r = 0, is the block's mirror image. At
    side 0 of the last axis, in a problem with an axis or a centre.
    """


@dataclass(frozen=True)
class Periodic(Condition):
    """The face goes on at another one, also Periodic: this one moved by shift (d numbers) [m].

    A block that is periodic in itself has no faces there: Block(…, periodic=(True, False)).
    """

    shift: Any
