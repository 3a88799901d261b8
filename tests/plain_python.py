"""Imported first, this lets the engine run in plain Python: nothing is compiled, so that small
problems take fractions of a second. For tests that a process of its own runs."""

import os
from types import SimpleNamespace

os.environ["NUMBA_DISABLE_JIT"] = "1"

from fsipetsc.operators import boxed


def box(record):
    """A record as compiled code has it, which is no tuple."""
    return SimpleNamespace(**record._asdict())


def with_calls(kind, record, calls):
    """Such a record beside functions of it."""
    return kind(record, *(function for function, _ in calls))


boxed.Box, boxed.with_calls = box, with_calls
