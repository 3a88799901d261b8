"""What stands at the outer ends of layers in the paper's method: formulas, an end a file.

Only what a condition gives is overwritten in a ghost point: outgoing characteristics keep their
values, with Z = rho c. (A ghost point with extrapolated density, or with all variables prescribed,
makes the scheme unstable.)
"""

from fsipetsc.boundaries import Dirichlet, Open, Wall, absorbing, clamped, free
from fsipetsc.paper.ends.given_end import GivenEnd
from fsipetsc.paper.ends.open_end import OpenEnd
from fsipetsc.paper.ends.solid_ends import AtEnd, absorbing_end, clamped_end, free_end
from fsipetsc.paper.ends.wall_end import WallEnd

#: what a case says of an end -> its formulas
OF_GAS = {Wall: WallEnd, Open: OpenEnd, Dirichlet: GivenEnd}
OF_SOLID = {clamped: clamped_end, free: free_end, absorbing: absorbing_end}

__all__ = ["OF_GAS", "OF_SOLID", "AtEnd"]
