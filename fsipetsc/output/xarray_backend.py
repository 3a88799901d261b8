"""What makes ``xarray.open_dataset("rod.h5", engine="fsipetsc")`` work: an entry point of pyproject.toml names it."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from xarray.backends import BackendEntrypoint

from fsipetsc.errors import FsiError
from fsipetsc.output.as_xarray import to_xarray
from fsipetsc.output.reader import open_run


class FsipetscBackend(BackendEntrypoint):
    """Result files of fsipetsc."""

    description = "Open result files of fsipetsc (.h5)"
    open_dataset_parameters = ("filename_or_obj", "drop_variables")

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> Any:
        """All frames and series, in memory; see fsipetsc.output.as_xarray.to_xarray."""
        with open_run(filename_or_obj) as run:
            dataset = to_xarray(run)
        return dataset.drop_vars(np.atleast_1d(drop_variables) if drop_variables is not None else [], errors="ignore")

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """It is a result of this program."""
        if not isinstance(filename_or_obj, (str, os.PathLike)):
            return False
        try:
            open_run(filename_or_obj).close()
        except (FsiError, OSError):
            return False
        return True
