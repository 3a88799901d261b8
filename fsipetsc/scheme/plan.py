"""What is noted of a completed step: flags, limits, and the record of series."""

import numpy as np

from fsipetsc.scheme.observables import SERIES, record

# where what stands among the results of a completed step
#: flags: 1 + number of a layer that has run off its grid, or that is too short
EXHAUSTED, TOO_SHORT = 0, 1
#: limits, after the flags; SAID_STOP is what this rank has to say of STOP
RATE, BAD, STOP, SAID_STOP = 2, 3, 4, 5
#: doubles of the flags and of the limits among the results
FLAGS, LIMITS = 2, 4
#: numbers of the plan of a batch of steps, see fsipetsc.scheme.batch
BATCH = 10
#: steps that the journal holds; they must be written then. Whole chunks of the file, see
#: output.tables
CAPACITY = 40 << 10


def shares(record: np.dtype) -> tuple[str, ...]:
    """Return which columns of a record are shares of the ranks, to be added up: the last ones."""
    names = record.names
    return names[names.index("mass" if "mass" in names else "energy") :]


def step_record(interfaces: int, fluids: int) -> np.dtype:
    """What is noted of a step in the paper's method: doubles, as they are written to the file.

    What a problem without interfaces or without a fluid has none of is not there.
    """
    at_interfaces = [name for name, one in SERIES.items() if one.of == "interface"]
    names = "t", "dt", *at_interfaces, "mass", "energy", "momentum"
    return np.dtype(record(names, {"interface": interfaces, "gas": fluids}))
