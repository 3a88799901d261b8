"""The types of what a case file uses, as a type checker of its author sees them."""

import importlib.util

import pytest
from helpers import REPOSITORY, run

#: those of an author of cases; functions of templates have no types, and are checked all the same
SETTINGS = """[mypy]
strict = True
follow_imports = silent
[mypy-fsipetsc.cases.*]
disallow_untyped_defs = False
disallow_untyped_calls = False
"""


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="no mypy")
def test_cases_pass_mypy_strict(tmp_path):
    (tmp_path / "mypy.ini").write_text(SETTINGS)
    templates = sorted((REPOSITORY / "fsipetsc" / "cases").glob("template*.py"))
    files = *templates, REPOSITORY / "tests" / "typed_cases.py"
    done = run("-m", "mypy", *files, cwd=tmp_path, env={"MYPYPATH": str(REPOSITORY)})
    assert len(templates) > 2 and done.returncode == 0, done.stdout + done.stderr
