"""Start of MPI and PETSc, with options that have been checked before PETSc sees them; and what a
run gives back, so that several can be made in one process.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from fsipetsc.errors import InputError
from fsipetsc.options import check_petsc
from fsipetsc.options.sources import Given, given_options
from fsipetsc.options.tables import AT_START
from fsipetsc.process.together import together

if TYPE_CHECKING:
    from mpi4py import MPI

#: where launchers tell a process its rank
_RANKS = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "MV2_COMM_WORLD_RANK", "SLURM_PROCID")


def launcher_rank() -> int:
    """This process's rank as mpiexec tells it, for what needs no MPI; 0 without mpiexec."""
    found = (os.environ.get(name, "") for name in _RANKS)
    return next((int(text) for text in found if text.isdigit()), 0)


def start_mpi() -> MPI.Comm:
    """COMM_WORLD. Collective; ModuleNotFoundError where there is no mpi4py."""
    import mpi4py

    mpi4py.rc.thread_level = "funneled"  # as PETSc asks for; locks for more threads cost time
    # Of Open MPI's two drivers of parallel files, its own (ompio) opens more beside each file: a
    # semaphore named after the file alone, so that one left by another user stops or hangs a run,
    # or NAME.h5-….lock, which a killed run leaves. The other one, ROMIO, does not.
    os.environ.setdefault("OMPI_MCA_io_ompio_priority", "0")
    # Open MPI 5.0.7 of Debian 13 warns of network interfaces between which it finds no way
    # (open-mpi/ompi issue 14079). Where all ranks are on this node, they need no network.
    size, interfaces = os.environ.get("OMPI_COMM_WORLD_SIZE"), "OMPI_MCA_btl_tcp_if_"
    chosen = any(name.startswith(interfaces) for name in os.environ)
    if size and size == os.environ.get("OMPI_COMM_WORLD_LOCAL_SIZE") and not chosen:
        os.environ[f"{interfaces}include"] = "lo"
    from mpi4py import MPI

    return MPI.COMM_WORLD


def start_petsc(arguments: Sequence[str], comm: MPI.Comm) -> dict[str, Given]:
    """Initialise PETSc, unless it runs already, with the options that it follows at its start.

    Returns all options given, as rank 0 finds them: name in lower case -> option, which
    fsipetsc.options reads. arguments: what stands behind the case's name. Collective. InputError
    for what is not an option, FileError or InputError for an options file.
    """
    given = comm.bcast(together(comm, lambda: _found(arguments) if comm.rank == 0 else None))
    start = {option.name: given[option.name].text for option in AT_START if option.name in given}
    if petsc_runs():
        found = _present()
        for name, text in start.items():
            if found.get(name) != text:
                what = f"-{name} works from the start of PETSc, which runs already in this process"
                raise InputError(f"{what}: make this run in a process of its own")
        _put(start)
    else:
        _initialise(start)
    if "options_left" not in start:
        from petsc4py import PETSc

        # newer releases (3.22) print what nobody asked for at the end, after every error
        PETSc.Options().setValue("options_left", "false")
    return given


def _found(arguments: Sequence[str]) -> dict[str, Given]:
    found = given_options(arguments)
    check_petsc(found)
    return found


def _initialise(start: Mapping[str, str]) -> None:
    """Start PETSc with options of it, name -> text; it reads no others."""
    words = [word for name, text in start.items() for word in (f"-{name}", text) if word]
    always = ["-skip_petscrc", "-no_signal_handler"]  # a SIGTERM is the program's business
    import petsc4py

    environment = os.environ.pop("PETSC_OPTIONS", None)
    try:
        petsc4py.init(["fsipetsc", *words, *always])
    except RuntimeError:
        raise InputError(f"PETSc could not start with {' '.join(words)}") from None
    finally:
        if environment is not None:
            os.environ["PETSC_OPTIONS"] = environment


# several runs in one process: PETSc has one database of options for all of it


def petsc_runs() -> bool:
    """PETSc has been started in this process. InputError if it has been ended, too."""
    if "petsc4py.PETSc" not in sys.modules:
        return False
    from petsc4py import PETSc

    if PETSc.Sys.isFinalized():
        raise InputError("PETSc has been ended in this process, and cannot be started again")
    return PETSc.Sys.isInitialized()


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
