"""The SBP first derivative on rows of values.

Rows hold the points of a rank with their halos. The closures stand at the first and the last active
point, A and B. The same formula is evaluated in the same order for a point whoever owns it, so
results do not depend on the number of ranks: that is why no loop here may reorder or contract
(``LOOP``).
"""

import numpy as np
from numpy.typing import NDArray

from fsipetsc.operators.loops import njit
from fsipetsc.operators import loops
from fsipetsc.operators.narrow import STIFFNESS, STIFFNESS_OF_WIDE, difference, end_term, levels
from fsipetsc.operators.sbp import operator, row_length

Array = NDArray[np.float64]
#: IEEE arithmetic as it is written
LOOP = {**loops.LOOP, "fastmath": False}
CALL = {**loops.CALL, "fastmath": False}
#: of what only compiled code calls: nothing is made to call it from Python, and it is not kept for
#: itself
INNER = {**LOOP, "cache": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
#: index arithmetic is of signed numbers; an index made unsigned spares the question whether it
#: counts from the end
U = np.uint64
#: no literals: of a function that is given a literal numba compiles a version for just this one
OLD, NEW = np.bool_(False), np.bool_(True)

_I, _F = np.int64, np.float64
#: D for h = 1: sum_k interior[k-1] (v[i+k] - v[i-k]), k = 1 .. p; closure[:rows, :columns] at the
#: left end; norm[:rows]; reach; n: points that its first row reaches; diffusion: its bound on the
#: step. narrow: 1 for narrow second derivatives (see fsipetsc.operators.narrow), and for these
#: differences, the weights of Delta_q in row q-1; means, those of Delta_{p+1+k} in row k;
#: end[:ends, :ends]. A record, because compiled code keeps count of who refers to an array, not of
#: who to a record.
OPERATOR = np.dtype(
    [
        *[(name, _I) for name in ("p", "n", "reach", "rows", "columns", "narrow", "ends")],
        ("diffusion", _F),
        *[("interior", _F, (4,)), ("closure", _F, (8, 12)), ("norm", _F, (8,))],
        *[("differences", _F, (8, 9)), ("means", _F, (4, 4)), ("end", _F, (4, 4))],
    ],
    align=True,
)


def packed(order: int, narrow: bool = False) -> Array:
    """That of an interior order, shape (1,). ValueError if there is none."""
    op, records = operator(order), np.zeros(1, OPERATOR)
    record = records[0]
    rows, columns = np.shape(op.closure)
    record["p"], record["n"], record["reach"] = op.p, row_length(op), op.reach
    record["rows"], record["columns"], record["narrow"] = rows, columns, narrow
    record["diffusion"] = STIFFNESS[order] if narrow else STIFFNESS_OF_WIDE
    floats = np.vectorize(float, otypes=[float])
    record["interior"][: op.p], record["norm"][:rows] = floats(op.interior), floats(op.norm)
    record["closure"][:rows, :columns] = floats(op.closure)
    for q in range(1, 9):
        record["differences"][q - 1, : q + 1] = difference(q)
    for k, level in enumerate(levels(op.interior)):
        record["means"][k, : len(level.weights)] = floats(level.weights)
    end = end_term(op.interior)
    record["ends"], record["end"][: len(end), : len(end)] = len(end), floats(end)
    return records


@njit(**INNER)
def derivative(op, f, out, a, b, A, B, scale):
    """out = scale h D f at the points a .. b-1; f is known where that reaches, or to A, B."""
    rows, columns = op.rows, op.columns
    first, end = max(a, A + rows), min(b, B + 1 - rows)
    c = scale * op.interior[0]
    for i in range(first, end):
        out[U(i)] = c * (f[U(i + 1)] - f[U(i - 1)])
    for k in range(2, op.p + 1):
        c = scale * op.interior[k - 1]
        for i in range(first, end):
            out[U(i)] += c * (f[U(i + k)] - f[U(i - k)])
    for r in range(rows):
        left, right = 0.0, 0.0
        if a <= A + r < b:
            for k in range(columns):
                left += op.closure[r, k] * f[U(A + k)]
            out[U(A + r)] = scale * left
        if a <= B - r < b:
            for k in range(columns):
                right += op.closure[r, k] * f[U(B - k)]
            out[U(B - r)] = -scale * right


@njit(**INNER)
def weight(op, r):
    """Norm weight of the point number r from an end."""
    return op.norm[r] if r < op.rows else 1.0
