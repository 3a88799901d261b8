"""Inputs at random: `scripts/soak fuzz 20000` takes more of them."""

from __future__ import annotations

import re

import pytest
from helpers import REPOSITORY, run

pytest.importorskip("petsc4py")
pytest.importorskip("hypothesis")


def test_random_inputs_end_with_one_message(tmp_path):
    done = run(REPOSITORY / "tests" / "fuzz_program.py", 2000, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    inputs, well = re.search(r"^(\d+) inputs; status: 0: (\d+)", done.stdout).groups()
    assert int(inputs) >= 2000 and int(well) > 50
