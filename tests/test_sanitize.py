"""gcc's sanitizers watch the kernels while other tests run: no access beyond what was allocated or
after it was freed, nothing that C leaves undefined. `scripts/soak sanitize` runs all of them.

Python and numpy are not watched. But numpy takes the memory of its arrays from malloc, which is
watched: an access beyond an array is found, but for the up to 64 bytes beside it that
``fsipetsc.kernels.loops.zeros`` leaves. New memory is full of nan, so a kernel that reads before
anything is stored there fails. A finding does not end a test; all are reported at the end."""

import subprocess
from functools import cache
from pathlib import Path

import pytest
from helpers import REPOSITORY, run

#: of what computes. Not test_kernels, which has compilers of its own and damages a library
COMPUTING = (
    *("block_conditions", "block_layers", "block_ledgers", "block_monitor", "block_oracle"),
    *("elementary", "gravity", "paper_rates", "radial", "recorded_data"),
    *("solid_laws", "where_faces_meet"),
)
SHORT = (
    "block_oracle.py::test_dissipation[panel-shocks]",
    "kernels.py::test_exact_sums_are_not_fused",
)
SHORT += ("paper_rates.py::test_rates_and_steps_do_not_depend_on_what_memory_had[open]",)
#: without optimization all checks are made
FLAGS = "-O0 -g -fsanitize=address,undefined -fsanitize-recover=address,undefined"
NAN_IN_NEW_MEMORY = "max_malloc_fill_size=1000000000:malloc_fill_byte=255"
BEYOND = """
import numpy as np
from helpers import recorded
from fsipetsc.kernels.loops import each

def store(y):
    for i in each(y.shape[0]):
        y[i + 1] = 0.0

recorded(store, np.ones(5))()
"""


@cache
def libraries() -> str:
    """The sanitizers' libraries, as LD_PRELOAD has them; empty where the compiler has none."""
    found = []
    for name in ("libasan.so", "libubsan.so"):
        asked = "gcc", f"-print-file-name={name}"
        try:
            found.append(subprocess.run(asked, capture_output=True, text=True).stdout.strip())
        except OSError:
            return ""
    return " ".join(found) if all(path.startswith("/") for path in found) else ""


pytestmark = pytest.mark.skipif(not libraries(), reason="gcc has no libasan and libubsan")


def watched(folder: Path, *words: object) -> list[str]:
    """What the sanitizers find while python does this, which must end well."""
    told = f"log_path={folder / 'found'}:print_stacktrace=1:halt_on_error=0"
    environment = {
        "CC": "env -u LD_PRELOAD gcc",
        "CFLAGS": FLAGS,
        "LD_PRELOAD": libraries(),
        "PYTHONMALLOC": "malloc",  # else Python's own small blocks lie side by side
        "ASAN_OPTIONS": f"{told}:detect_leaks=0:{NAN_IN_NEW_MEMORY}",
        "UBSAN_OPTIONS": told,
    }
    done = run(*words, cwd=REPOSITORY / "tests", env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return [path.read_text() for path in folder.glob("found.*")]


@pytest.mark.parametrize(
    "tests", [SHORT, pytest.param([f"{name}.py" for name in COMPUTING], marks=pytest.mark.long)]
)
def test_kernels(tests, tmp_path):
    words = "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not long"
    assert watched(tmp_path, *words, *(f"test_{name}" for name in tests)) == []


def test_a_number_behind_an_array_is_found(tmp_path):
    (found,) = watched(tmp_path, "-c", BEYOND)
    assert "heap-buffer-overflow" in found and "in procedure" in found
