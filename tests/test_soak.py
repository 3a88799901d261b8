"""What scripts/soak runs for long, once and short."""

from __future__ import annotations

import os

import pytest

pytest.importorskip("petsc4py")

import ratios
from long_runs import seen


def test_what_is_stable_and_what_is_not():
    """A light solid: the linear theory has a growing mode with the traditional coupling, and so has the run."""
    assert ratios.run(0.1, 1.0, "conservative", 4) == (True, "")
    stable, how = ratios.run(1e-3, 1.0, "traditional", 4)
    assert not stable and how.startswith("ends at 0.0") and ratios.theory(1e-3, 1.0, "traditional", 4) == "mode"


def test_memory_and_files_are_seen():
    memory, files = seen(os.getpid())
    with open(os.devnull):
        assert memory > 1 << 20 and seen(os.getpid())[1] == files + 1
    assert seen(2**22 + 1) is None
