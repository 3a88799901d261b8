"""What can stand at a face of a block.

A condition is a class with its data, its checks, and what it adds to rates.
"""

from fsipetsc.blocks.conditions.condition import (
    Centre,
    Condition,
    Effect,
    Given,
    Moving,
    Periodic,
    Warm,
)
from fsipetsc.blocks.conditions.gas import NoSlip, Open, Outflow, Slip
from fsipetsc.blocks.conditions.solids import Absorbing, Clamped, Free, Hinge, Roller

__all__ = [
    "Absorbing", "Centre", "Clamped", "Condition", "Effect", "Free", "Given", "Hinge", "Moving",
    "NoSlip", "Open", "Outflow", "Periodic", "Roller", "Slip", "Warm",
]  # fmt: skip
