"""The oracle of blocks around an axis or a centre, Radial(problem, kappa)."""

from block_oracle import Oracle as Radial

__all__ = ["Radial"]
