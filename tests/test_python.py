"""The oldest Python that is said to do is the oldest that does, as far as the sources show."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from helpers import REPOSITORY

SOURCES = sorted((REPOSITORY / "fsipetsc").rglob("*.py"))
#: minor version of Python 3 -> what came with it, of modules and of names within modules
NEW_NAMES = {
    10: {"pairwise", "TypeAlias", "ParamSpec", "TypeGuard", "zoneinfo"},
    11: {"tomllib", "ExceptionGroup", "BaseExceptionGroup", "StrEnum", "Self", "add_note", "TaskGroup", "Never", "UTC"},
    12: {"batched", "override", "Buffer"},
    13: {"ReadOnly", "PythonFinalizationError"},
}


def features(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """(minor version of Python 3, what needs it) of names, arguments and types that are evaluated when a module runs."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "zip" and node.keywords:
            yield 10, "zip(strict=)"
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr) and is_type(node.left) and is_type(node.right):
            yield 10, "X | Y of types"
        found = {getattr(node, "attr", None), getattr(node, "id", None)}
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            found |= {getattr(node, "module", None), *(alias.name for alias in node.names)}
        for version, new in NEW_NAMES.items():
            for name in found & new:
                yield version, name


def is_type(node: ast.AST) -> bool:
    """It looks like the name of a type."""
    return isinstance(node, ast.Name) and re.match(r"[A-Z][a-z]|(str|int|float|bytes|tuple|list|dict)$", node.id) is not None


def evaluated(path) -> ast.AST:
    """The source without annotations, which are texts."""
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        for name in ("annotation", "returns"):
            if hasattr(node, name):
                setattr(node, name, None)
    return tree


def declared() -> int:
    """Minor version of Python 3 that pyproject.toml asks for."""
    return int(re.search(r'^requires-python = ">=3\.(\d+)"', (REPOSITORY / "pyproject.toml").read_text(), re.M)[1])


def test_what_is_declared_is_what_the_sources_need():
    needed = {path.name: set(features(evaluated(path))) for path in SOURCES}
    assert max(version for found in needed.values() for version, _ in found) == declared(), needed
    for path in SOURCES:
        ast.parse(path.read_text(), feature_version=(3, declared()))


def test_set_up_asks_for_the_same():
    setup = (REPOSITORY / "scripts" / "setup").read_text()
    said, asked = re.findall(r"Python>=3\.(\d+)", setup), re.findall(r"version_info < \(3, (\d+)\)", setup)
    assert said == asked == [str(declared())]
