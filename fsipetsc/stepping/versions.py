"""Versions of the program and of what it runs on."""

from __future__ import annotations

import platform

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

import fsipetsc


def versions() -> dict[str, str]:
    """Versions of the program and of what it runs on."""
    import mpi4py
    import numba
    import petsc4py

    return {
        "fsipetsc": fsipetsc.__version__,
        "python": platform.python_version(),
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "petsc4py": petsc4py.__version__,
        "mpi4py": mpi4py.__version__,
        "mpi": MPI.Get_library_version().split(",")[0].split("\n")[0],
        "numba": numba.__version__,
        "numpy": np.__version__,
    }
