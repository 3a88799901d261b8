"""SBP first derivatives as exact fractions, with their norms.

    from fsipetsc.operators import operator
    D = operator(4).matrix(101, h=0.01)  # the 4/2 operator on [0, 1]

Nothing below this package: arrays in, arrays out, no PETSc and no MPI.
"""

from fsipetsc.operators.sbp import OPERATORS, SBPOperator, operator

__all__ = ["OPERATORS", "SBPOperator", "operator"]
