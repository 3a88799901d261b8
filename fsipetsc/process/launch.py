"""Start of MPI and PETSc; what a run gives back, so that several can be made in one process."""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from fsipetsc.options import AT_END, given_options, present, put
from fsipetsc.process.together import Comm, launcher_rank, together


def start_mpi(alone: bool = False) -> Comm:
    """Return COMM_WORLD. Collective; ModuleNotFoundError where there is no mpi4py.

    alone: this process is one that the program has to itself, if no launcher started it: Open MPI
    is told so, which saves 0.3 s.
    """
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
    own = {}
    if alone and launcher_rank() is None:  # no other process, and no networks (UCX)
        own = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1"}
        own = {name: text for name, text in own.items() if name not in os.environ}
    os.environ.update(own)
    from mpi4py import MPI

    for name in own:  # programs that this one starts have more ranks
        del os.environ[name]
    return MPI.COMM_WORLD


def start_petsc(arguments: Sequence[str], comm: Comm) -> dict[str, str]:
    """Initialise PETSc, unless it runs already, and have it read all options.

    Returns what was given, as rank 0 finds it (fsipetsc.options.given_options). arguments: what
    comes after the case's name. Collective. InputError; FileError of an options file.
    """
    if not petsc_runs():  # PETSc gets its options later; the program itself answers signals
        import petsc4py

        environment = os.environ.pop("PETSC_OPTIONS", "")
        petsc4py.init(["fsipetsc", "-skip_petscrc", "-no_signal_handler", "-options_left", "false"])
        os.environ |= {"PETSC_OPTIONS": environment} if environment else {}
    from petsc4py import PETSc

    put({})  # an error leaves none, on any rank
    given = comm.bcast(together(comm, lambda: given_options(arguments) if comm.rank == 0 else None))
    if "log_view" in given:
        PETSc.Log.begin()
    # newer releases (3.22) print what nobody asked for at the end, after every error
    put({"options_left": "false", **{name: given[name] for name in AT_END if name in given}})
    return given


def petsc_runs() -> bool:
    """Tell whether PETSc has been started in this process."""
    module = sys.modules.get("petsc4py.PETSc")
    return module is not None and module.Sys.isInitialized()


@contextmanager
def left_as_found() -> Iterator[None]:
    """Leave no search paths, modules of case files and options behind, but such as -log_view."""
    path, modules, asked = list(sys.path), set(sys.modules), os.environ.get("PETSC_OPTIONS")
    found = present() if petsc_runs() else {}
    try:
        yield
    finally:
        if petsc_runs():
            put(found | {name: text for name, text in present().items() if name in AT_END})
        folders = tuple(os.path.join(folder, "") for folder in set(sys.path) - set(path))
        for name in set(sys.modules) - modules:  # the next case file has its own of that name
            file = getattr(sys.modules[name], "__file__", None) or ""
            if name.startswith("fsipetsc_case_") or file.startswith(folders):
                del sys.modules[name]
        sys.path[:] = path
        if asked is not None:  # a study has taken them
            os.environ["PETSC_OPTIONS"] = asked
