"""The layout of the code: imports go one way, and only who has to knows PETSc and MPI."""

import ast
import re
from graphlib import TopologicalSorter

from helpers import REPOSITORY

PACKAGE = REPOSITORY / "fsipetsc"
CODE = (REPOSITORY / "docs" / "code.md").read_text()
#: folders and files of the package, as the page has them: each imports from those to its right
TOLD = re.findall(r"`(\w+)`", CODE[CODE.index("`api` →") : CODE.index("| folder")])
ORDER = ["__main__", *TOLD, "__init__"]
RANK = {name: rank for rank, name in enumerate(ORDER)}
RUN = {"stepping", "paper", "state"}
#: who knows MPI, PETSc: who starts them, computes or writes with them, reads PETSc's options
MPI = RUN | {"cli", "api", "studies", "output", "process", "parallel"}
PETSC = RUN | {"studies", "output", "process", "options"}
PETSC |= {"parallel/block_layout.py"}  # brings results into their order


def imports(path):
    """Modules of all imports, those within functions and for type checkers alone, too."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: absolute imports only"
            yield node.module
            yield from (f"{node.module}.{x.name}" for x in node.names)


def place(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


FILES = sorted(PACKAGE.rglob("*.py"))


def test_everything_has_its_place():
    assert {place(path) for path in FILES} == set(RANK)


def test_imports_go_one_way():
    for path in FILES:
        here, known_as = place(path), {place(path), str(path.relative_to(PACKAGE))}
        for name in imports(path) if here != "__init__" else ():
            package, first = (*name.split("."), "")[:2]
            if package == "fsipetsc":
                there = first if first in RANK else "__init__"  # what the package itself offers
                assert here == there or RANK[there] > RANK[here], f"{path} imports {name}"
            allowed = {"mpi4py": MPI, "petsc4py": PETSC}.get(package, known_as)
            assert known_as & allowed, f"{path} imports {name}"


def test_files_import_one_way():
    """No circle of files, also within a folder; what the package offers from its top is not one."""
    files = {".".join(path.relative_to(REPOSITORY).with_suffix("").parts): path for path in FILES}
    files = {name.removesuffix(".__init__"): path for name, path in files.items()}
    del files["fsipetsc"]
    takes = {name: set(imports(path)) & set(files) - {name} for name, path in files.items()}
    TopologicalSorter(takes).prepare()  # CycleError names the files of a circle
