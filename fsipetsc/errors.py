"""What can go wrong, each kind with the exit status that the command line ends with."""

import traceback
from contextlib import suppress


class FsiError(Exception):
    """An error that is explained to the user in one message, without a traceback.

    Args:
        message: what is wrong, and what would be valid.
        collective: True if every rank raises it at the same place (then the program ends in order),
            False if one rank may be alone with it (then the other ranks are stopped).
    """

    status = 1

    def __init__(self, message: str, *, collective: bool = True) -> None:
        super().__init__(message)
        self.collective = collective


class InputError(FsiError):
    """Bad input: an option, a case file, the number of ranks. Exit status 2."""

    status = 2


class RanksError(InputError):
    """There are more ranks than the problem can feed."""


class ComputationError(FsiError):
    """The computation failed; the message names field, layer, x, t and step. Exit status 3."""

    status = 3


class FileError(FsiError):
    """A file could not be read or written. Exit status 4."""

    status = 4


class Interrupted(KeyboardInterrupt):
    """A signal has ended a run, after its checkpoint. All ranks raise it together.

    It is no FsiError: what a program does about a run that fails must not go on after a SIGTERM.
    """

    collective = True

    def __init__(self, number: int, message: str) -> None:
        super().__init__(message)
        self.status = 128 + number


def petsc_words(error: BaseException) -> str:
    """Return PETSc's words without its list of routines, "[0] TSSolve() at file:line" and so on."""
    lines = [line.split("] ", 1)[-1] for line in str(error).splitlines()[1:]]
    reason = "; ".join(line for line in lines if "() at " not in line)
    return f"PETSc error {getattr(error, 'ierr', '')}" + (f": {reason}" if reason else "")


def clear_frames(error: BaseException | None) -> None:
    """Empty the frames of an error, of its cause and of their callers.

    They hold PETSc's objects, a TS or the array of a Vec, which must not outlive the run: PETSc
    waits at its end for all ranks to have the same ones.
    """
    while error is not None:
        traceback.clear_frames(error.__traceback__)
        frame = error.__traceback__.tb_frame if error.__traceback__ else None
        while frame is not None:
            with suppress(RuntimeError):  # it is still at work
                frame.clear()
            frame = frame.f_back
        error = error.__cause__ or error.__context__
