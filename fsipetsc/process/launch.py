"""Start of MPI and PETSc, with options that have been checked before PETSc sees them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from fsipetsc.errors import InputError
from fsipetsc.options import check_petsc
from fsipetsc.options.sources import Given, given_options
from fsipetsc.options.tables import AT_START
from fsipetsc.process.host import begin_options, petsc_runs
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
        begin_options(start)
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
