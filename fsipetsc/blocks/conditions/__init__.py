"""What can stand at a face of a block.

A condition is a class with its data, its checks, and what it adds to rates.
"""

from fsipetsc.blocks.conditions.condition import (
    Centre,
    Condition,
    Effect,
    Given,
    Periodic,
    conserves_energy,
    moves,
    slides,
    steady,
    warms,
)
from fsipetsc.blocks.conditions.gas import NoSlip, Open, Outflow, Slip
from fsipetsc.blocks.conditions.solids import Absorbing, Clamped, Free, Hinge, Roller

__all__ = [
    "Absorbing", "Centre", "Clamped", "Condition", "Effect", "Free", "Given", "Hinge", "NoSlip",
    "Open", "Outflow", "Periodic", "Roller", "Slip", "conserves_energy", "moves", "slides",
    "steady", "warms",
]  # fmt: skip
