"""Start of MPI and PETSc, and what must be right about the arguments before PETSc sees them.

PETSc answers a missing or malformed options file with a page of its own and, on several ranks, by waiting for ever;
and it passes silently over arguments that belong to no option.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from fsipetsc.errors import FileError, FsiError, InputError
from fsipetsc.process import begin_options, petsc_runs

if TYPE_CHECKING:
    from mpi4py import MPI

HELP_FLAGS = ("-h", "-help", "--help")
_FILE_OPTIONS = ("-options_file", "-options_file_yaml")
_YAML_SUFFIXES = (".yaml", ".yml", ".json", ":yaml")


def launcher_rank() -> int:
    """This process's rank as mpiexec tells it, for what needs no MPI; 0 without mpiexec."""
    names = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "MV2_COMM_WORLD_RANK", "SLURM_PROCID")
    return next((int(os.environ[name]) for name in names if os.environ.get(name, "").isdigit()), 0)


def start_mpi() -> MPI.Comm:
    """COMM_WORLD. Collective; ModuleNotFoundError where there is no mpi4py."""
    import mpi4py

    mpi4py.rc.thread_level = "funneled"  # as PETSc asks for; locks for more threads would cost time in each message
    from mpi4py import MPI

    return MPI.COMM_WORLD


def start_petsc(arguments: Sequence[str], comm: MPI.Comm) -> None:
    """Initialise PETSc with the arguments behind the case's name; where it runs already, with the options of this run
    in place of all others. Collective.

    Raises InputError for what is not an option, FileError or InputError for an options file.
    """
    _together(comm, lambda: check_arguments(arguments, os.environ.get("PETSC_OPTIONS", "")))
    if petsc_runs():
        begin_options(_sources(arguments), _pairs([word for word in arguments if word not in HELP_FLAGS]))
        return
    os.environ["PETSC_OPTIONS"] = " ".join(
        w for w in _words(os.environ.get("PETSC_OPTIONS", "")) if w not in HELP_FLAGS
    )
    program = ["fsipetsc", *(word for word in arguments if word not in HELP_FLAGS)]
    if "-no_signal_handler" not in program:
        program.append("-no_signal_handler")  # a SIGTERM is the program's business, not a page about debuggers
    import petsc4py

    kept: list[str] = []
    try:
        with _stderr_kept(kept):
            petsc4py.init(program)
    except RuntimeError:
        raise InputError(_petsc_complaint(kept[0])) from None
    sys.stderr.write(kept[0])
    from petsc4py import PETSc

    database = PETSc.Options()
    if not database.hasName("options_left"):
        # Newer releases (3.22) print what nobody asked for at the end, after every error that meets no solve.
        database.setValue("options_left", "false")


def _together(comm: MPI.Comm, check: Callable[[], None]) -> None:
    """Run a check on rank 0, whose files are those that PETSc reads; its error is raised by all ranks."""
    fault = None
    if comm.rank == 0:
        try:
            check()
        except FsiError as error:
            fault = error
    fault = comm.bcast(fault)
    if fault is not None:
        raise fault


def is_option(word: str) -> bool:
    """PETSc's rule: one or two dashes and a letter. -10, -.5 and -inf are values."""
    return re.match(r"--?[A-Za-z]", word) is not None and word.lower() not in ("-inf", "-infinity", "-nan")


def check_arguments(arguments: Sequence[str], environment: str = "") -> None:
    """Raise InputError for a word that belongs to no option, and look into options files.

    environment: the text of PETSC_OPTIONS.
    """
    _check_words(list(arguments), "")
    _check_words(_words(environment), " in PETSC_OPTIONS")
    for name in _own_files(arguments):
        check_options_file(name)


def _own_files(arguments: Sequence[str]) -> list[str]:
    """The options files that PETSc reads unasked."""
    names = (os.path.expanduser("~/.petscrc"), ".petscrc", "petscrc")
    return [] if "-skip_petscrc" in arguments else [name for name in names if os.path.isfile(name)]


def _sources(arguments: Sequence[str]) -> list[str]:
    """What PETSc reads before the command line, as texts of options."""
    environment = [word for word in _words(os.environ.get("PETSC_OPTIONS", "")) if word not in HELP_FLAGS]
    return [f'-options_file "{name}"' for name in _own_files(arguments)] + [" ".join(environment)]


def _pairs(words: Sequence[str]) -> list[tuple[str, str | None]]:
    """(option, its value or None) of words that have been checked."""
    found: list[tuple[str, str | None]] = []
    for word in words:
        if is_option(word):
            found.append((word, None))
        else:
            found[-1] = (found[-1][0], word)
    return found


def _words(text: str) -> list[str]:
    """A text cut at blanks, except within quotes, as PETSc cuts it."""
    return re.findall(r'"[^"]*"|\'[^\']*\'|\S+', text)


def _check_words(words: list[str], where: str) -> None:
    position = 0
    while position < len(words):
        word = words[position]
        value = words[position + 1] if position + 1 < len(words) and not is_option(words[position + 1]) else None
        if not is_option(word):
            raise InputError(f"unexpected argument '{word}'{where}: a value stands right behind its option")
        if word.startswith("--") and word not in HELP_FLAGS:
            raise InputError(f"unknown option {word}{where}: write {word[1:]}, with one dash")
        if word.lower() in _FILE_OPTIONS:
            if not value:
                raise InputError(f"{word} needs the name of a file")
            check_options_file(value, yaml=word.lower().endswith("yaml"))
        position += 1 if value is None else 2


def check_options_file(name: str, yaml: bool = False) -> None:
    """Raise FileError if an options file cannot be read, InputError naming file and line if PETSc would refuse it."""
    path = os.path.expanduser(os.path.expandvars(name.strip("\"'")))
    yaml = yaml or path.endswith(_YAML_SUFFIXES)
    path = path.removesuffix(":yaml")
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
    except OSError as error:
        raise FileError(f"options file {path}: {error.strerror}") from None
    if yaml or text.startswith(("%YAML ", "---")):
        _check_yaml(path, text)
    else:
        for number, line in enumerate(text.splitlines(), 1):
            _check_line(_words(line.split("#", 1)[0]), f"options file {path}, line {number}")


def _check_line(words: list[str], where: str) -> None:
    """One line of an options file in PETSc's own format."""
    if not words or words[0].lower() == "alias":
        return
    if not is_option(words[0]):
        raise InputError(f"{where}: '{words[0]}' is not an option; a line is '-name value'")
    if len(words) > 2 or (len(words) == 2 and is_option(words[1])):
        raise InputError(f"{where}: one option and its value a line, not '{' '.join(words)}'")
    _check_words(words, f" ({where})")


def _check_yaml(path: str, text: str) -> None:
    try:
        import yaml
    except ModuleNotFoundError:  # unread, a faulty file would leave ranks waiting within PETSc
        message = f"options file {path}: YAML needs the Python package PyYAML; or write lines '-name value', in another file"
        raise InputError(message) from None
    try:
        list(yaml.parse(text))
    except yaml.MarkedYAMLError as error:
        line = f", line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise InputError(f"options file {path}{line}: {error.problem}") from None
    except yaml.YAMLError as error:
        raise InputError(f"options file {path}: {error}") from None


@contextlib.contextmanager
def _stderr_kept(kept: list[str]) -> Iterator[None]:
    """Append to `kept`, in one piece, what is written to stderr in the meantime, by C code too."""
    with tempfile.TemporaryFile() as file:
        sys.stderr.flush()
        saved = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)
            file.seek(0)
            kept.append(file.read().decode(errors="replace"))


def _petsc_complaint(text: str) -> str:
    """PETSc's reason out of its error page: the lines between its headline and the pointer to its FAQ."""
    lines = [line.split("PETSC ERROR: ", 1)[1] for line in text.splitlines() if "PETSC ERROR: " in line]
    reason = []
    for line in lines[1:]:
        if line.startswith(("See http", "WARNING", "Petsc Release", "#")):
            break
        reason.append(line.strip())
    return "PETSc could not start: " + ("; ".join(reason) or "no reason given")
