"""The layout of the code: imports go one way, and only who has to knows PETSc and MPI."""

import ast

from helpers import REPOSITORY

PACKAGE = REPOSITORY / "fsipetsc"
#: folders and files of the package: each imports from those to its right alone
ORDER = """__main__ → cli api → studies → stepping blockrun paper → output → process
→ cases → usage → options → mesh_files → scheme → parallel → problem → boundaries → blocks
→ materials → operators → equations → kernels → blame checks → errors → __init__"""
RANK = {name: rank for rank, names in enumerate(ORDER.split("→")) for name in names.split()}
#: these three make a run, and know each other
RUN = {"stepping", "blockrun", "paper"}
#: who knows MPI, PETSc: who starts them, computes or writes with them, reads PETSc's options
MPI = RUN | {"cli", "api", "studies", "output", "process", "parallel"}
PETSC = RUN | {"studies", "output", "process", "options"}
PETSC |= {"parallel/block_layout.py"}  # has the DMDAs


def imports(path):
    """Modules of all imports, those within functions too, but not those for type checkers alone."""
    waiting = [ast.parse(path.read_text())]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
            continue
        waiting += ast.iter_child_nodes(node)
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: absolute imports only"
            whole = node.module == "fsipetsc"
            yield from (f"{node.module}.{x.name}" if whole else node.module for x in node.names)


def place(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


FILES = sorted(PACKAGE.rglob("*.py"))


def test_everything_has_its_place_as_the_documentation_says():
    assert {place(path) for path in FILES} == set(RANK)
    text = (REPOSITORY / "docs" / "code.md").read_text()
    told = text[text.index("`cli` →") : text.index("\n\n| folder")].replace("`", "").split("→")
    ranks = [{RANK[name.strip()] for name in names.split(",")} for names in told]
    assert len(told) > 15 and all(len(same) == 1 for same in ranks)
    assert ranks == sorted(ranks, key=min)


def test_imports_go_one_way():
    for path in FILES:
        here, known_as = place(path), {place(path), str(path.relative_to(PACKAGE))}
        for name in imports(path) if here != "__init__" else ():
            package, first = (*name.split("."), "")[:2]
            if package == "fsipetsc":
                there = first if first in RANK else "__init__"  # what the package itself offers
                beside = here == there or {here, there} <= RUN
                assert beside or RANK[there] > RANK[here], f"{path} imports {name}"
            allowed = {"mpi4py": MPI, "petsc4py": PETSC}.get(package, known_as)
            assert known_as & allowed, f"{path} imports {name}"
