"""What can stand at a face of a block.

A condition is a class with its data, its checks, and what it adds to rates.
"""

from fsipetsc.blocks.conditions.condition import (
    Condition,
    Effect,
    conserves_energy,
    moves,
    slides,
    steady,
    warms,
)
from fsipetsc.blocks.conditions.either import Centre, Given, Periodic
from fsipetsc.blocks.conditions.open import Open
from fsipetsc.blocks.conditions.outflow import Outflow
from fsipetsc.blocks.conditions.solids import Absorbing, Clamped, Free, Hinge, Roller
from fsipetsc.blocks.conditions.walls import NoSlip, Slip

__all__ = [
    "Absorbing", "Centre", "Clamped", "Condition", "Effect", "Free", "Given", "Hinge", "NoSlip",
    "Open", "Outflow", "Periodic", "Roller", "Slip", "conserves_energy", "moves", "slides",
    "steady", "warms",
]  # fmt: skip
