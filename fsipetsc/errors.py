"""What can go wrong, each kind with the exit status that the command line ends with."""

from __future__ import annotations


class FsiError(Exception):
    """An error that is explained to the user in one message, without a traceback.

    collective: True if every rank raises it at the same place (then the program ends in order), False if one rank may
    be alone with it (then the other ranks are stopped).
    """

    status = 1

    def __init__(self, message: str, *, collective: bool = True) -> None:
        super().__init__(message)
        self.collective = collective


class InputError(FsiError):
    """Bad input: an option, a case file, a restart file, the number of ranks. Says what would be valid."""

    status = 2


class ComputationError(FsiError):
    """The computation failed: names field, layer, x, t and step."""

    status = 3


class FileError(FsiError):
    """A file could not be read or written."""

    status = 4
