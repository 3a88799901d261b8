"""What a run takes from its process and gives back to it, so that several can be made in one process.

PETSc has one database of options for the whole process. It reads the command line, PETSC_OPTIONS and options files into
it only when it starts; so each run puts its own options there itself, and finds no others.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from fsipetsc.errors import InputError
from fsipetsc.options.petsc_names import is_start_name


def petsc_runs() -> bool:
    """PETSc has been started in this process, by whomever. InputError if it has been ended, too."""
    if "petsc4py.PETSc" not in sys.modules:
        return False
    from petsc4py import PETSc

    if PETSc.Sys.isFinalized():
        raise InputError("PETSc has been ended in this process (finalized), and cannot be started again")
    return PETSc.Sys.isInitialized()


def begin_options(start: Mapping[str, str]) -> None:
    """Make room in PETSc's database for the options of the run that begins; PETSc runs already.

    start: those that PETSc follows only when it starts or ends, name -> text; InputError unless they are in force already.
    """
    found = _present()
    for name, text in start.items():
        if found.get(name) != text:
            raise InputError(
                f"-{name} works from the start of PETSc, and PETSc runs already in this process: "
                "give it to the first run, or make this run in a process of its own"
            )
    _put(start)
    if threading.current_thread() is threading.main_thread():
        # that of PETSc, if it was started without -no_signal_handler, calls MPI_Abort, which hangs where MPI was printing
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)


@contextmanager
def left_as_found() -> Iterator[None]:
    """What is done within leaves no options, search paths, modules of a case file's or environment behind.

    Options that PETSc looks at when it ends, such as -log_view, stay if PETSc was started within.
    """
    path, modules, environment = list(sys.path), set(sys.modules), os.environ.get("PETSC_OPTIONS")
    found = _present() if petsc_runs() else None
    try:
        yield
    finally:
        if "petsc4py.PETSc" in sys.modules and petsc_runs():
            _put(_at_the_end() if found is None else found)
        _forget_modules(set(sys.path) - set(path), modules)
        sys.path[:] = path
        if environment is None:
            os.environ.pop("PETSC_OPTIONS", None)
        else:
            os.environ["PETSC_OPTIONS"] = environment


def _present() -> dict[str, str]:
    """Name -> text of all options in PETSc's database; "" if there is no value."""
    from petsc4py import PETSc

    database = PETSc.Options()
    listed = database.getAll()  # may cut a text at a blank, as getString does after 1023 characters
    return {name: max(listed[name] or "", database.getString(name, ""), key=len) for name in listed}


def _at_the_end() -> dict[str, str]:
    return {name: value for name, value in _present().items() if is_start_name(name.lower())}


def _put(options: Mapping[str, str]) -> None:
    """Make PETSc's database hold these options alone."""
    from petsc4py import PETSc

    database = PETSc.Options()
    for name in database.getAll():
        database.delValue(name)
    for name, value in options.items():
        database.setValue(name, value)


def _forget_modules(folders: set[str], before: set[str]) -> None:
    """Forget the modules that case files imported from their own folders: the next one has its own of that name."""
    new = [name for name in sys.modules if name not in before]
    own = {name for name in new if name.startswith("fsipetsc_case_")}
    for name in new:
        file = getattr(sys.modules[name], "__file__", None)
        if "." in name or name == "fsipetsc" or not file:
            continue
        place = os.path.dirname(os.path.abspath(file))
        if place in folders or (os.path.basename(file) == "__init__.py" and os.path.dirname(place) in folders):
            own.add(name)
    for name in new:
        if name.split(".")[0] in own:
            del sys.modules[name]
