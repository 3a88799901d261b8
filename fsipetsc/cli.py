"""The command line: runs a case, or one of the commands; and ends with a status that scripts can rely on."""

from __future__ import annotations

import contextlib
import importlib
import os
import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import dropwhile
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from fsipetsc.blame import missing
from fsipetsc.cases import BUILT_IN, load_case, summaries
from fsipetsc.errors import FileError, FsiError, InputError
from fsipetsc.options import RUN, Option, table
from fsipetsc.options.sources import HELP_FLAGS, given_options, is_option
from fsipetsc.process.failure import end_together
from fsipetsc.process.host import left_as_found
from fsipetsc.process.launch import launcher_rank, start_mpi, start_petsc
from fsipetsc.process.streams import abandon_stdout, complete_streams, heedless
from fsipetsc.process.together import together
from fsipetsc.usage import case_help, command_help, overview, program

if TYPE_CHECKING:
    from mpi4py import MPI


class Command(NamedTuple):
    """A command: what stands behind its name, one line about it, and the function that does it.

    target: "module:function", imported when it is called, with the list of arguments; a parallel one also gets the
    communicator of all ranks and starts PETSc itself (fsipetsc.process.launch.start_petsc). options: "module:name" of its own
    options, heading -> Options (fsipetsc.options.read_table), which -help lists, or of a function of the arguments that
    returns them. prints: what it prints is what it is for; else nothing is lost where nothing can be printed.
    """

    arguments: str
    summary: str
    target: str
    parallel: bool = False
    options: str = ""
    prints: bool = False


COMMANDS = {
    "info": Command("RUN.h5", "what a result holds: case, options, times, layers, summary", "fsipetsc.cli:info"),
    "plot": Command(
        "RUN.h5 [-o DIR|FILE] [-fields p,T] [-times 0,0.5] [-all] [-animate]",
        "a result on a page (PNG, or as FILE ends: PDF, SVG); all pictures; a film (GIF)",
        "fsipetsc.cli:plot",
    ),
    "report": Command(
        "RUN.h5 [-o DIR]", "one HTML page of a result: film, pictures, ledgers, options, summary", "fsipetsc.cli:report"
    ),
    "diff": Command(
        "A.h5 B.h5",
        "what differs between two results: each field, in units in the last place, too",
        "fsipetsc.cli:diff",
    ),
    "new": Command(
        "FILE.py [-blocks]",
        "a case file of your own to start from, -blocks: in two dimensions; commented, and it runs",
        "fsipetsc.cli:new",
    ),
    "convergence": Command(
        "CASE [-option value ...]",
        "errors of a case, or differences between its grids, with observed orders and cost",
        "fsipetsc.analysis.convergence:convergence",
        parallel=True,
        options="fsipetsc.analysis.convergence:sections",
    ),
    "stability": Command(
        "[CASE] [-sweep] [-option value ...]",
        "the linear theory, checked: spectra, energy growth, time-step limits",
        "fsipetsc.analysis.stability:stability",
        parallel=True,
        options="fsipetsc.analysis.stability_options:sections",
        prints=True,
    ),
    "flutter": Command(
        "[-option value ... | RUN.h5]",
        "growth of the panel's motion over dynamic pressure and Mach number; of a result, the limit cycle",
        "fsipetsc.analysis.flutter:flutter",
        parallel=True,
        options="fsipetsc.analysis.flutter:sections",
    ),
    "modes": Command(
        "ring [-option value ...]",
        "frequencies of small motions of a case at rest, by the scheme and exactly",
        "fsipetsc.analysis.modes:modes",
        parallel=True,
        options="fsipetsc.analysis.modes:sections",
        prints=True,
    ),
    "verify": Command(
        "[NAME ...] [-verify_level full]",
        "cases against references: errors, observed orders, verdicts",
        "fsipetsc.verify.command:verify",
        parallel=True,
        options="fsipetsc.verify.command:SECTIONS",
        prints=True,
    ),
    "bench": Command(
        "[-option value ...]",
        "what a time step costs on 1 to N ranks, and where the time goes",
        "fsipetsc.bench.command:bench",
        parallel=True,
        options="fsipetsc.bench.command:SECTIONS",
    ),
}
_DEBUG = next(option for option in RUN if option.name == "fsi_debug")  # which every command takes
_VERSION_FLAGS = ("--version", "-version")
#: what stands behind an option of the commands that make pictures or a case file; None: nothing
_OF_REPORT = {"-o": "the name of a directory"}
_OF_PLOT = {
    **{"-o": "the name of a directory or a file", "-fields": "names of fields with commas", "-times": "times with commas"},
    **{"-all": None, "-animate": None},
}
_OF_NEW = {"-blocks": None}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program with the arguments behind its name; returns the exit status.

    None stands for sys.argv: then the process is the program's own. With arguments given, it is somebody else's, such as
    a notebook's: any number of runs can be made in it, and each leaves it as it was.
    """
    if argv is None:
        return _main(sys.argv[1:])
    with left_as_found():
        return _main(list(argv))


def _main(arguments: list[str]) -> int:
    complete_streams()
    if _is_run(arguments):
        return _in_parallel(arguments)
    if launcher_rank() > 0:
        return 0  # rank 0 alone answers
    try:
        _answer(arguments)
        _flush()
    except BrokenPipeError:  # the reader, a pager or head, has seen enough
        abandon_stdout()
    except (Exception, KeyboardInterrupt) as error:
        return end_together(error, None, debug=_debugging(arguments))
    return 0


def _debugging(arguments: Sequence[str]) -> bool:
    """Whether -fsi_debug is in force, wherever it was given; the error may be about the options themselves."""
    words = list(dropwhile(lambda word: not is_option(word), arguments))
    try:
        given = given_options(words).get(_DEBUG.name)
    except FsiError:
        return f"-{_DEBUG.name}" in words
    try:
        return given is not None and _DEBUG.parse(given.text)
    except FsiError:  # a bad value: the error is about it
        return False


def _flush() -> None:
    """Write out what has been printed, while an error can still be answered."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise FileError(f"the standard output cannot be written: {error.strerror}") from None


def _is_run(arguments: Sequence[str]) -> bool:
    """True for what is done by all ranks together, False for what one process answers."""
    if not arguments or arguments[0] in HELP_FLAGS + _VERSION_FLAGS:
        return False
    if any(word in HELP_FLAGS + _VERSION_FLAGS for word in arguments[1:]):
        return False
    return arguments[0] not in COMMANDS or COMMANDS[arguments[0]].parallel


def _answer(arguments: list[str]) -> None:
    first = arguments[0] if arguments else "-help"
    if first in _VERSION_FLAGS or (first not in COMMANDS and any(word in _VERSION_FLAGS for word in arguments)):
        print(f"fsipetsc {_version()}")
    elif first in HELP_FLAGS:
        print(overview(summaries(), {name: command[:2] for name, command in COMMANDS.items()}))
    elif first in COMMANDS:
        _run_command(first, arguments[1:])
    else:
        with _helping():
            case = load_case(first, tuple(COMMANDS))
            _check_help(arguments[1:], table(case))
            print(case_help(case, first))


def _run_command(name: str, arguments: list[str]) -> None:
    command = COMMANDS[name]
    if any(word in HELP_FLAGS for word in arguments):
        if command.options:
            with _helping():
                options = _named(command.options)
                sections = options(arguments) if callable(options) else options
                _check_help(arguments, {option.name: option for group in sections.values() for option in group})
                print(command_help(name, command.arguments, command.summary, sections))
        else:
            debug = f"-{_DEBUG.name}  {_DEBUG.help}"
            print(f"{program()} {name} {command.arguments}\n\n  {command.summary}\n\n  {debug}")
        return
    _named(command.target)(arguments)


@contextlib.contextmanager
def _helping() -> Iterator[None]:
    """What is printed within explains something that needs numba, which may be missing; then a last line says so."""
    from fsipetsc.cases.stand_in import numba_stood_in

    with numba_stood_in() as without:
        yield
    if without:
        print(f"\nTo run, {missing('numba')}.")


def _check_help(arguments: Sequence[str], options: Mapping[str, Option]) -> None:
    """Raise InputError if -help stands where the value of an option should."""
    for word, following in zip(arguments, arguments[1:]):
        option = options.get(word[1:].lower()) if word.startswith("-") else None
        if option is not None and option.needs_value and following in HELP_FLAGS + _VERSION_FLAGS:
            option.parse("")


def _named(place: str) -> Any:
    """What "module:name" stands for."""
    module, name = place.split(":")
    return getattr(importlib.import_module(module), name)


def _version() -> str:
    import fsipetsc

    return getattr(fsipetsc, "__version__", "(version unknown)")


def _in_parallel(arguments: list[str]) -> int:
    """A run, or a command that all ranks do together. Collective."""
    notes, case_file, debug = None, None, False
    try:
        world = start_mpi()
        notes = world.Dup()
        if arguments[0] in COMMANDS:
            _command_in_parallel(arguments, world)
        else:
            case_file = None if arguments[0] in BUILT_IN else arguments[0]
            with heedless():
                case = together(world, lambda: load_case(arguments[0], tuple(COMMANDS)))
                given = start_petsc(arguments[1:], world)
                option = table(case)["fsi_debug"]
                debug = option.parse(given["fsi_debug"].text) if "fsi_debug" in given else option.default
                from fsipetsc.stepping.run import run_given

                run_given(case, given, world)
    except BrokenPipeError:
        abandon_stdout()
    except (Exception, KeyboardInterrupt) as error:
        return end_together(error, notes, debug=debug or _debugging(arguments), case_file=case_file)
    finally:
        if notes is not None:
            notes.Free()
    return 0


def _command_in_parallel(arguments: list[str], world: MPI.Comm) -> None:
    command = COMMANDS[arguments[0]]
    with contextlib.nullcontext() if command.prints else heedless():
        _named(command.target)(arguments[1:], world)
        _flush()


def info(arguments: list[str]) -> None:
    """The command `info RUN.h5`."""
    (path,), _ = _files("info", arguments, 1)
    from fsipetsc.output.info import info as show

    print(show(path))


def plot(arguments: list[str]) -> None:
    """The command `plot RUN.h5` with its options."""
    (path,), given = _files("plot", arguments, 1, flags=_OF_PLOT)
    from fsipetsc.output.plots.command import draw

    for picture in draw(path, given):
        print(picture)


def report(arguments: list[str]) -> None:
    """The command `report RUN.h5 [-o DIR]`."""
    (path,), given = _files("report", arguments, 1, flags=_OF_REPORT)
    from fsipetsc.output.report import report as write

    print(write(path, given.get("-o", os.curdir)))


def diff(arguments: list[str]) -> None:
    """The command `diff A.h5 B.h5`."""
    (first, second), _ = _files("diff", arguments, 2)
    from fsipetsc.output.differences import compare, table

    print(table(compare(first, second)))


def new(arguments: list[str]) -> None:
    """The command `new FILE.py [-blocks]`."""
    (name,), given = _files("new", arguments, 1, "name of a case file", flags=_OF_NEW)
    from fsipetsc.output.new_case import new_case

    path = new_case(name, tuple(COMMANDS), "-blocks" in given)
    print(f"wrote {path}; it runs as it is:  {program()} {shlex.quote(str(path))}")


def _files(
    name: str,
    arguments: list[str],
    count: int,
    what: str = "result file",
    flags: Mapping[str, str | None] = MappingProxyType({}),
) -> tuple[list[str], dict[str, str]]:
    """The files that a command wants, as many as `count`, and its options with their values; InputError for anything else.

    what: the files are. flags: option -> what stands behind it, None for nothing; two dashes are as good as one.
    """
    usage = f"{program()} {name} {COMMANDS[name].arguments}"
    words, given, files = list(arguments), {}, []
    while words:
        word = words.pop(0)
        flag = word[1:] if word.startswith("--") else word
        if flag in flags:
            if flags[flag] is not None and (not words or not words[0] or is_option(words[0])):
                raise InputError(f"{flag} needs {flags[flag]}: {usage}")
            given[flag] = "" if flags[flag] is None else words.pop(0)
        elif word == f"-{_DEBUG.name}":
            continue  # see _debugging
        elif word.startswith("-"):
            raise InputError(f"unknown option {word} of the command {name}: {usage}")
        else:
            files.append(word)
    if "" in files:
        raise InputError(f"the command {name} wants files, and '' names none: {usage}")
    if len(files) != count:
        got = "none was given" if not files else "1 was given" if len(files) == 1 else f"{len(files)} were given"
        wanted = f"one {what}" if count == 1 else f"{count} {what}s"
        raise InputError(f"the command {name} wants {wanted}, {got}: {usage}")
    return files, given
