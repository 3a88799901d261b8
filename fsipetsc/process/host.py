"""What a run takes from its process and gives back, so that several can be made in one process.

PETSc has one database of options for the whole process. It reads the command line, PETSC_OPTIONS
and options files into it only when it starts; so each run puts its own options there itself, and
finds no others.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from fsipetsc.errors import InputError
from fsipetsc.options.tables import AT_START


def petsc_runs() -> bool:
    """PETSc has been started in this process. InputError if it has been ended, too."""
    if "petsc4py.PETSc" not in sys.modules:
        return False
    from petsc4py import PETSc

    if PETSc.Sys.isFinalized():
        raise InputError("PETSc has been ended in this process, and cannot be started again")
    return PETSc.Sys.isInitialized()


def begin_options(start: Mapping[str, str]) -> None:
    """Make room in PETSc's database for the options of the run that begins; PETSc runs already.

    start: those that PETSc follows only when it starts or ends, name -> text; InputError unless
    they are in force already.
    """
    found = _present()
    for name, text in start.items():
        if found.get(name) != text:
            raise InputError(
                f"-{name} works from the start of PETSc, which runs already in this process: "
                "give it to the first run, or make this run in a process of its own"
            )
    _put(start)


@contextmanager
def left_as_found() -> Iterator[None]:
    """What is done within leaves no options, search paths and modules of case files behind.

    Options that PETSc looks at when it ends, such as -log_view, stay if it was started within.
    """
    path, modules = list(sys.path), set(sys.modules)
    found = _present() if petsc_runs() else None
    try:
        yield
    finally:
        if "petsc4py.PETSc" in sys.modules and petsc_runs():
            names = {"options_left", *(option.name for option in AT_START)}
            at_end = {name: text for name, text in _present().items() if name in names}
            _put(at_end if found is None else found)
        folders = tuple(os.path.join(folder, "") for folder in set(sys.path) - set(path))
        for name in set(sys.modules) - modules:  # the next case file has its own of that name
            file = getattr(sys.modules[name], "__file__", None) or ""
            if name.startswith("fsipetsc_case_") or (folders and file.startswith(folders)):
                del sys.modules[name]
        sys.path[:] = path


def _present() -> dict[str, str]:
    """Name -> text of all options in PETSc's database; "" if there is no value."""
    from petsc4py import PETSc

    database = PETSc.Options()
    listed = database.getAll()  # may cut a text at a blank, as getString does after 1023 letters
    return {k: max(listed[k] or "", database.getString(k, ""), key=len) for k in listed}


def _put(options: Mapping[str, str]) -> None:
    """Make PETSc's database hold these options alone."""
    from petsc4py import PETSc

    database = PETSc.Options()
    for name in database.getAll():
        database.delValue(name)
    for name, value in options.items():
        database.setValue(name, value)
