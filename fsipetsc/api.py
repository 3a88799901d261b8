"""Runs from Python: what the command line does, with exceptions instead of exits."""

import os
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.cases import case_of, load_case
from fsipetsc.errors import InputError
from fsipetsc.options import defaults
from fsipetsc.output.reader import Run, open_run
from fsipetsc.problem import Problem
from fsipetsc.process.launch import left_as_found, start_mpi, start_petsc
from fsipetsc.process.together import Comm, end_together, together


def run(case: Any, *, comm: Comm | None = None, **options: Any) -> Run:
    """Solve a case and return its result, opened.

    All ranks of `comm` must call it. It needs PETSc and MPI. Options, modules and settings of PETSc
    are left as they were found, so that several runs in one process do not know of each other.

    Args:
        case: name of a built-in case, path of a case file, a `Problem` or a `BlockProblem`.
        comm: mpi4py communicator; None: COMM_WORLD.
        options: those of the command line, without the dash; `fsi_` and `ts_` may be left out, as
            in `order=6, h=0.025`. A list stands for a value with commas, None for the default.
            `quiet=False` prints what a run prints. The result is the file `output`, by default
            CASE.h5 in the working directory.

    Returns:
        The result.

    Raises:
        InputError: an option, the case or the number of ranks is not valid.
        ComputationError: the computation failed; what was computed is in the result file.
        FileError: a file could not be read or written.
        KeyboardInterrupt: a SIGINT, SIGTERM or SIGHUP came; the result is written. It is no
            `FsiError`.
    """
    comm = start_mpi() if comm is None else comm
    with left_as_found():
        notes = comm.Dup()
        try:
            from fsipetsc.stepping.run import run_given

            loaded = together(comm, lambda: _case(case))
            given = start_petsc(together(comm, lambda: [*_words(loaded, options)]), comm)
            path = os.path.abspath(str(run_given(loaded, given, comm)["fsi_output"]))
        except BaseException as error:
            if comm.size > 1 and not getattr(error, "collective", False):
                end_together(error, notes)  # perhaps of this rank alone: nobody may wait for it
            raise
        finally:
            notes.Free()
    return open_run(path)


def _case(case: Any) -> Any:
    """Return what a case file would define. InputError."""
    if isinstance(case, (str, os.PathLike)):
        return load_case(os.fspath(case))
    if isinstance(case, BlockProblem):
        return case_of(case, fsi_h=1.0)  # its cells are given
    if not isinstance(case, Problem):
        said = f"is a name, a file, a Problem or a BlockProblem, not {type(case).__name__}"
        raise InputError(f"run: a case {said}")
    return case_of(case)


def _words(case: Any, options: Mapping[str, Any]) -> Iterator[str]:
    """Yield the options as on the command line, with the beginning of their names. InputError."""
    known = {name.lower() for name in defaults(case)}
    for name, value in {"quiet": True, **options}.items():
        if name.lower() in ("check", "fsi_check") and value:
            raise InputError("run: 'check' makes no result; the command line has -fsi_check")
        names = name, f"fsi_{name}", f"ts_{name}"
        if value is not None:
            yield f"-{next((full for full in names if full.lower() in known), name)}"
            yield from () if value is True else (_text(value),)


def _text(value: Any) -> str:
    value = getattr(value, "tolist", lambda: value)()  # of numpy's arrays
    if isinstance(value, Iterable) and not isinstance(value, (str, os.PathLike)):
        return ",".join(map(_text, value))
    return str(value)
