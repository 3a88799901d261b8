"""Layered one-dimensional fluid–structure interaction with summation-by-parts differences on PETSc.

Importing the package is cheap and needs neither PETSc nor MPI; opening a result needs numpy and h5py.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fsipetsc.output.reader import Run

__version__ = "0.1.0"
__all__ = ["__version__", "open_run"]


def open_run(path: str | os.PathLike[str]) -> Run:
    """Open the result file of a run; see :class:`fsipetsc.output.reader.Run`.

    Raises :class:`fsipetsc.errors.FileError` if it does not exist, is not a result or cannot be read.
    """
    from fsipetsc.output.reader import open_run as open_result

    return open_result(path)
