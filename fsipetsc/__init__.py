"""Layered fluid–structure interaction with summation-by-parts differences on PETSc.

Importing the package is cheap and needs neither PETSc nor MPI; opening a result needs numpy and
h5py.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.blocks.block import Block
    from fsipetsc.blocks.problem import BlockProblem
    from fsipetsc.boundaries import Dirichlet, Open, SolidEnd, Wall, absorbing, clamped, free
    from fsipetsc.errors import ComputationError, FileError, FsiError, InputError
    from fsipetsc.materials.fluid import Fluid
    from fsipetsc.materials.line_solid import Solid
    from fsipetsc.options import REQUIRED, Option
    from fsipetsc.output.differences import compare
    from fsipetsc.output.reader import Run
    from fsipetsc.problem import FluidLayer, Problem, SolidLayer

# else numba, where colorama is installed, has it write to the standard output when the process ends
os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")

__version__ = "0.1.0"
#: what is public, with the modules that docs/commands.md names; all else may change. Written out,
#: so that type checkers see it
__all__ = [
    "REQUIRED", "Block", "BlockProblem", "ComputationError", "Dirichlet", "FileError", "Fluid",
    "FluidLayer", "FsiError", "InputError", "Open", "Option", "Problem", "Run", "Solid",
    "SolidEnd", "SolidLayer", "Wall", "__version__", "absorbing", "clamped", "compare", "free",
    "open_run", "run",
]  # fmt: skip
#: module -> what it has of these; imported when it is asked for
_HOMES = {
    "blocks.block": ("Block",),
    "blocks.problem": ("BlockProblem",),
    "boundaries": ("Dirichlet", "Open", "SolidEnd", "Wall", "absorbing", "clamped", "free"),
    "errors": ("ComputationError", "FileError", "FsiError", "InputError"),
    "options": ("REQUIRED", "Option"),
    "output.differences": ("compare",),
    "output.reader": ("Run",),
    "materials.fluid": ("Fluid",),
    "materials.line_solid": ("Solid",),
    "problem": ("FluidLayer", "Problem", "SolidLayer"),
}


def __getattr__(name: str) -> Any:
    home = next((module for module, names in _HOMES.items() if name in names), None)
    if home is None:
        raise AttributeError(f"module 'fsipetsc' has no attribute {name!r}")
    return getattr(importlib.import_module(f"fsipetsc.{home}"), name)


def __dir__() -> list[str]:
    return __all__


def open_run(path: str | os.PathLike[str]) -> Run:
    """Open the result file of a run; see :class:`fsipetsc.output.reader.Run`.

    Raises :class:`fsipetsc.errors.FileError` if it does not exist, is not a result or cannot be
    read.
    """
    from fsipetsc.output.reader import open_run as open_result

    return open_result(path)


def run(case: Any, *, comm: MPI.Comm | None = None, **options: Any) -> Run:
    """Solve a case and return its result, opened. Collective on ``comm``; needs PETSc and MPI.

    case      name of a built-in case, path of a case file, a :class:`fsipetsc.problem.Problem` or
              :class:`fsipetsc.blocks.problem.BlockProblem`, or anything with what a case file
              defines (``build(opt)``, ``OPTIONS`` …)
    comm      mpi4py communicator; None: COMM_WORLD
    options   those of the command line, ``fsi_`` and ``ts_`` may be left out: ``order=6,
              h=0.025``; lists where it has commas; None for the default. ``quiet=False`` prints
              what a run prints.
              The result is ``output``, by default CASE.h5 in the working directory

    Raises the exceptions of :mod:`fsipetsc.errors`: InputError for what is not valid,
    ComputationError where the computation fails, FileError; after a SIGINT, SIGTERM or SIGHUP
    KeyboardInterrupt, which no ``except FsiError`` takes, with the result written. Options,
    modules and settings of PETSc are left as they were found, so that several runs in one process
    do not know of each other.
    """
    from fsipetsc.api import run as solve

    return solve(case, comm, options)
