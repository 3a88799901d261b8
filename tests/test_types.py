"""The types of what a case file uses, as a type checker of its author sees them."""

import importlib.util

import pytest
from helpers import REPOSITORY, run

from fsipetsc.cases import load_case
from fsipetsc.options import InForce, defaults

TYPED = [REPOSITORY / "tests" / f"typed_{name}.py" for name in ("layers", "blocks", "program")]
TEMPLATES = sorted((REPOSITORY / "fsipetsc" / "cases").glob("template*.py"))
#: their functions have no types, and are checked all the same
UNTYPED = "--allow-untyped-defs", "--allow-untyped-calls"


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="no mypy")
@pytest.mark.parametrize(("files", "more"), [(TYPED, ()), (TEMPLATES, UNTYPED)])
def test_cases_pass_mypy_strict(files, more, tmp_path):
    """Without this project's settings: those that the author of a case does not have."""
    words = "--strict", *more, "--follow-imports=silent", "--config-file="
    words = *words, f"--cache-dir={tmp_path}"
    done = run("-m", "mypy", *words, *files, cwd=tmp_path, env={"MYPYPATH": str(REPOSITORY)})
    assert len(files) > 2 and done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("name", ["layers", "blocks"])
def test_they_are_cases(name):
    case = load_case(str(REPOSITORY / "tests" / f"typed_{name}.py"))
    problem = case.build(InForce(defaults(case)))
    assert [layer.kind for layer in problem.layers].count("solid") == 1
