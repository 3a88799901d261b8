"""The layout of the code: imports go one way, and only who has to knows PETSc and MPI; what
docs/code.md names exists.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers import REPOSITORY

PACKAGE = REPOSITORY / "fsipetsc"
#: files and folders of the package: each imports from those below it, never from one above, nor
#: from one beside it
ORDER = """
    __main__
    cli api
    verify bench
    analysis
    stepping
    output
    process
    cases
    usage
    options
    given mesh_files
    scheme
    parallel
    blocks
    problem
    boundaries
    materials
    equations
    operators
    blame checks
    errors
    __init__
"""
RANK = {name: rank for rank, line in enumerate(ORDER.split("\n")) for name in line.split()}
#: the run of blocks, which stands beside that of layers until all runs are of blocks; the paper's
#: method with its state
SAME = {"blockrun": "stepping", "paper": "stepping"}
#: who knows MPI, PETSc: the folders whose work that is, and what starts them, reads PETSc's options
#: and ends them
KNOW_MPI = {"cli", "api", "verify", "analysis", "bench", "stepping", "output", "process"}
KNOW_MPI |= {"parallel"}
KNOW_PETSC = {"analysis", "bench", "stepping", "output", "process", "options", "parallel"}
#: files of ``parallel`` that know PETSc: those that have the DMDAs
PETSC_IN_PARALLEL = {"parallel/block_layout.py"}


def imports(source: str) -> Iterator[tuple[int, str]]:
    """(line, module) of all imports, those within functions too, but not those for type checkers
    alone.
    """
    waiting: list[ast.AST] = [ast.parse(source)]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
            continue
        waiting += ast.iter_child_nodes(node)
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "absolute imports only"
            whole = node.module == "fsipetsc"
            for alias in node.names:
                yield node.lineno, f"{node.module}.{alias.name}" if whole else node.module


def place(name: str) -> str:
    """Where in ORDER a module of the package stands: its first name after the package's."""
    first = name.split(".")[1] if "." in name else "__init__"
    first = SAME.get(first, first)
    return first if first in RANK else "__init__"  # what the package itself offers


def files() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def wrong_imports(place_of_file: str, source: str) -> list[str]:
    """Imports against the order in a file that belongs to a place."""
    found = []
    for line, name in imports(source):
        if name.split(".")[0] != "fsipetsc" or place(name) == place_of_file:
            continue
        if RANK[place(name)] <= RANK[place_of_file]:
            found.append(f"{line}: {place_of_file} imports {name}")
    return found


def place_of(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    return SAME.get(first, first)


def test_everything_has_its_place():
    assert {place_of(path) for path in files()} == set(RANK)


@pytest.mark.parametrize(
    "path",
    [p for p in files() if place_of(p) != "__init__"],
    ids=lambda p: str(p.relative_to(PACKAGE)),
)
def test_imports_go_one_way(path):
    assert not wrong_imports(place_of(path), path.read_text())


def test_who_knows_mpi_and_petsc():
    know: dict[str, set[Path]] = {"mpi4py": set(), "petsc4py": set()}
    for path in files():
        for _, name in imports(path.read_text()):
            if name.split(".")[0] in know:
                know[name.split(".")[0]].add(path)
    assert {place_of(path) for path in know["mpi4py"]} <= KNOW_MPI
    assert {place_of(path) for path in know["petsc4py"]} <= KNOW_PETSC
    in_parallel = {path for path in know["petsc4py"] if place_of(path) == "parallel"}
    in_parallel = {str(path.relative_to(PACKAGE)) for path in in_parallel}
    assert in_parallel == PETSC_IN_PARALLEL


def test_what_the_description_of_the_code_names_exists():
    text = (REPOSITORY / "docs" / "code.md").read_text()
    named = set(re.findall(r"`((?:fsipetsc|tests|runs|docs)/[\w./-]*\w)`", text))
    assert len(named) > 20
    assert not {name for name in named if not (REPOSITORY / name).exists()}
