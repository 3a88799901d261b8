"""Start of MPI and PETSc."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from fsipetsc.errors import InputError
from fsipetsc.options import given_options, is_option, present
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


def start_petsc(arguments: Sequence[str], comm: MPI.Comm) -> dict[str, str]:
    """Initialise PETSc, unless it runs already, and have it read all options.

    Returns what was given, as rank 0 finds it (fsipetsc.options.given_options). arguments: what
    stands behind the case's name. Collective. InputError, FileError for what is not an option and
    for an options file.
    """
    if not petsc_runs():
        _initialise(arguments)
    before = present()
    given = comm.bcast(together(comm, lambda: given_options(arguments) if comm.rank == 0 else None))
    begin_options({name: given[name] for name in AT_START if name in given}, before)
    return given


def _initialise(arguments: Sequence[str]) -> None:
    """Start PETSc with those options that it follows only when it starts."""
    words, start = [*os.environ.get("PETSC_OPTIONS", "").split(), *arguments, "-"], []
    for word, value in zip(words, words[1:]):
        if word.lstrip("-").lower() in AT_START:
            start += [word, *([] if is_option(value) or value == "-" else [value])]
    always = ["-skip_petscrc", "-no_signal_handler"]  # a SIGTERM is the program's business
    import petsc4py

    environment = os.environ.pop("PETSC_OPTIONS", None)
    try:
        petsc4py.init(["fsipetsc", *start, *always])
    except RuntimeError:
        raise InputError(f"PETSc could not start with {' '.join(start)}") from None
    finally:
        if environment is not None:
            os.environ["PETSC_OPTIONS"] = environment
