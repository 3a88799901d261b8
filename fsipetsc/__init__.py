"""Layered fluid–structure interaction with summation-by-parts differences on PETSc.

Importing the package is cheap and needs neither PETSc nor MPI; opening a result needs numpy and
h5py.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fsipetsc.api import run
    from fsipetsc.blocks.block import Block
    from fsipetsc.blocks.block_problem import BlockProblem
    from fsipetsc.boundaries import Dirichlet, Open, SolidEnd, Wall, absorbing, clamped, free
    from fsipetsc.equations.piecewise import Piecewise
    from fsipetsc.errors import ComputationError, FileError, FsiError, InputError
    from fsipetsc.materials.fluid import Fluid
    from fsipetsc.materials.solid import Solid
    from fsipetsc.options import REQUIRED, Option
    from fsipetsc.output.differences import compare
    from fsipetsc.output.reader import Run, open_run
    from fsipetsc.problem import FluidLayer, Problem, SolidLayer

__version__ = "1.0.0"
#: what is public, with the modules that docs/commands.md names; all else may change. Written out,
#: so that type checkers see it
__all__ = [
    "REQUIRED", "Block", "BlockProblem", "ComputationError", "Dirichlet", "FileError", "Fluid",
    "FluidLayer", "FsiError", "InputError", "Open", "Option", "Piecewise", "Problem", "Run",
    "Solid", "SolidEnd", "SolidLayer", "Wall", "__version__", "absorbing", "clamped", "compare",
    "free", "open_run", "run",
]  # fmt: skip
#: module -> what it has of these; imported when it is asked for
_HOMES = {
    "api": ("run",),
    "blocks.block": ("Block",),
    "blocks.block_problem": ("BlockProblem",),
    "boundaries": ("Dirichlet", "Open", "SolidEnd", "Wall", "absorbing", "clamped", "free"),
    "equations.piecewise": ("Piecewise",),
    "errors": ("ComputationError", "FileError", "FsiError", "InputError"),
    "options": ("REQUIRED", "Option"),
    "output.differences": ("compare",),
    "output.reader": ("Run", "open_run"),
    "materials.fluid": ("Fluid",),
    "materials.solid": ("Solid",),
    "problem": ("FluidLayer", "Problem", "SolidLayer"),
}


def __getattr__(name: str) -> Any:
    home = next((module for module, names in _HOMES.items() if name in names), None)
    if home is None:
        raise AttributeError(f"module 'fsipetsc' has no attribute {name!r}")
    return getattr(importlib.import_module(f"fsipetsc.{home}"), name)


def __dir__() -> list[str]:
    return __all__
