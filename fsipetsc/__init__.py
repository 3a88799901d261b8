"""Layered fluid–structure interaction with summation-by-parts differences on PETSc.

Importing the package is cheap and needs neither PETSc nor MPI; results need numpy and h5py.
"""

import ast
import importlib
from pathlib import Path
from typing import Any

__version__ = "1.0.0"
#: what is public -> its module, imported when it is asked for: all that __init__.pyi, which type
#: checkers read, imports. Public, too, are the modules that docs/commands.md names
_HOMES = {
    one.name: str(node.module)
    for node in ast.parse(Path(__file__).with_suffix(".pyi").read_text()).body
    if isinstance(node, ast.ImportFrom)
    for one in node.names
}
__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'fsipetsc' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
