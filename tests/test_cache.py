"""Compiled kernels are kept between runs, and never survive a change of the sources that they were compiled from."""

from __future__ import annotations

import importlib
import os
import shutil
from pathlib import Path

import pytest
from helpers import REPOSITORY, run

numba = pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from fsipetsc.operators import cache

PROGRAM = """
import sys, time
sys.path.insert(0, sys.argv[1])
import numpy as np
from fsipetsc.operators import packed
from fsipetsc.operators.kernels import derivative
rows = np.ones(100)
derivative(packed(2), rows, 10, 0, 60, 0, 0, 20, 0, 19, 1.0)
print(rows[65], sum(derivative.stats.cache_hits.values()))
"""


def compiled_functions():
    """Every compiled function of the package that is cached."""
    for folder in cache.COMPILED:
        for path in (REPOSITORY / "fsipetsc" / folder).glob("*.py"):
            module = importlib.import_module(f"fsipetsc.{folder}.{path.stem}")
            for value in vars(module).values():
                if hasattr(value, "py_func") and value.__module__ == module.__name__ and value.stats.cache_path:
                    yield value


def test_all_kernels_are_kept_in_the_folder_of_this_state_of_the_sources():
    functions = list(compiled_functions())
    assert {"advance", "derivative"} <= {function.__name__ for function in functions}
    for function in functions:
        assert Path(function.stats.cache_path).is_relative_to(numba.config.CACHE_DIR), function


def test_every_file_with_kernels_counts():
    """A folder that is not listed could change without a new compilation.

    Except analysis and cases: no kernel calls what is compiled there, and a change in its own file numba notices.
    """
    with_kernels = {
        path.relative_to(REPOSITORY / "fsipetsc").parts[0]
        for path in (REPOSITORY / "fsipetsc").rglob("*.py")
        if "@njit" in path.read_text()
    }
    assert with_kernels <= {*cache.COMPILED, "analysis", "cases"}


def test_a_change_in_a_source_file_is_noticed(tmp_path):
    shutil.copytree(REPOSITORY / "fsipetsc", tmp_path / "fsipetsc", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "program.py").write_text(PROGRAM)
    env = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "PYTHONPATH": str(tmp_path)}

    def answer():
        done = run(tmp_path / "program.py", tmp_path, env=env, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    assert answer() == ["0.0", "0"]
    assert answer() == ["0.0", "1"], "the second time it is not compiled"
    source = tmp_path / "fsipetsc" / "operators" / "kernels.py"
    text = source.read_text()
    head, tail = text.split("def slope", 1)  # which the compiled function calls
    source.write_text(head + "def slope" + tail.replace("    return d\n", "    return d + 1.0\n", 1))
    assert answer() == ["1.0", "0"]
    # in a file that the compiled function's own file imports
    other = tmp_path / "fsipetsc" / "operators" / "sbp.py"
    os.utime(other, ns=(1, 1))
    assert answer() == ["1.0", "0"]
