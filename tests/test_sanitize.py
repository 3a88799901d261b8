"""gcc's sanitizers watch kernels; all that computes: `scripts/soak sanitize`."""

from pathlib import Path

import pytest
from helpers import REPOSITORY, run
from sanitizers import findings, libraries, watched

PROGRAM = REPOSITORY / "tests" / "sanitized_program.py"
pytestmark = pytest.mark.skipif(not libraries(), reason="gcc has no libasan and libubsan")


def test_gas_and_solid_and_the_papers_method(tmp_path: Path):
    done = run(PROGRAM, env=watched(tmp_path))
    assert (done.returncode, findings(tmp_path)) == (0, []), done.stderr


def test_a_number_behind_an_array_is_found(tmp_path: Path):
    done = run(PROGRAM, "beyond", env=watched(tmp_path))
    (found,) = findings(tmp_path)
    assert done.returncode == 0, done.stderr
    assert "heap-buffer-overflow" in found and "in procedure" in found and "texts/" in found
