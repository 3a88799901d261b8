"""The HDF5 library that PETSc uses, which may be another one than h5py's."""

from __future__ import annotations

import ctypes
from contextlib import suppress

from petsc4py import PETSc


def be_silent() -> None:
    """Keep it from printing its stack of errors to stderr: what fails is raised, with a message of ours."""
    with suppress(OSError, AttributeError):  # a PETSc that brings HDF5 in another way prints it still
        silence = ctypes.CDLL(PETSc.__file__).H5Eset_auto2
        silence.argtypes = [ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p]
        silence(0, None, None)
