"""What a run takes from its process and gives back, so that several can be made in one process.

PETSc has one database of options for the whole process: each run puts its own options there, and
finds no others.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from fsipetsc.errors import InputError
from fsipetsc.options import present, put
from fsipetsc.options.tables import AT_START


def petsc_runs() -> bool:
    """PETSc has been started in this process. InputError if it has been ended, too."""
    if "petsc4py.PETSc" not in sys.modules:
        return False
    from petsc4py import PETSc

    if PETSc.Sys.isFinalized():
        raise InputError("PETSc has been ended in this process, and cannot be started again")
    return PETSc.Sys.isInitialized()


def begin_options(start: Mapping[str, str], before: Mapping[str, str]) -> None:
    """Make PETSc's database hold only those options of a run that PETSc follows by itself.

    start: those that it follows when it starts or ends, name -> text. before: what the database
    held before the run's options were read; InputError unless they were in force already.
    """
    for name, text in start.items():
        if before.get(name) != text:
            raise InputError(
                f"-{name} works from the start of PETSc: give it on the command line, or in "
                "PETSC_OPTIONS, of the first run in a process"
            )
    # newer releases (3.22) print what nobody asked for at the end, after every error
    put({"options_left": "false", **start})


@contextmanager
def left_as_found() -> Iterator[None]:
    """What is done within leaves no options, search paths and modules of case files behind.

    Options that PETSc looks at when it ends, such as -log_view, stay if it was started within.
    """
    path, modules = list(sys.path), set(sys.modules)
    found = present() if petsc_runs() else None
    try:
        yield
    finally:
        if "petsc4py.PETSc" in sys.modules and petsc_runs():
            at_end = {name: text for name, text in present().items() if name in AT_START}
            put(at_end if found is None else found)
        folders = tuple(os.path.join(folder, "") for folder in set(sys.path) - set(path))
        for name in set(sys.modules) - modules:  # the next case file has its own of that name
            file = getattr(sys.modules[name], "__file__", None) or ""
            if name.startswith("fsipetsc_case_") or (folders and file.startswith(folders)):
                del sys.modules[name]
        sys.path[:] = path
