"""What test_sanitize.py watches: gas and solid in a plane, the paper's method; or, with the word
beyond, a number that is stored behind an array.
"""

import sys

import numpy as np
from recorded import recorded
from test_block_oracle import DAMPED, FACES, STICKING, check
from test_paper_rates import RUNS, measured, state_of

from fsipetsc.kernels.loops import each


def beyond() -> None:
    def store(y, f):
        for i in each(y.shape[0]):
            y[i + 1] = 0.0

    recorded(store)(np.ones(5), np.ones(5))


if sys.argv[1:] == ["beyond"]:
    beyond()
else:
    kinds = FACES["rolling"]
    check("walls", STICKING, 4, lambda of: kinds.get(of, kinds.get(of[0])), 0.3, 1e-8, **DAMPED)
    measured(state_of(**RUNS["open"]))
