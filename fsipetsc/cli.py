"""The command line: runs a case, or one of the commands; and ends with a status that scripts can rely on."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

from fsipetsc.cases import BUILT_IN, load_case, summaries
from fsipetsc.errors import InputError
from fsipetsc.failure import settle
from fsipetsc.launch import HELP_FLAGS, launcher_rank, start_mpi, start_petsc
from fsipetsc.options import read_options
from fsipetsc.process import left_as_found
from fsipetsc.together import together
from fsipetsc.usage import case_help, command_help, overview, program


class Command(NamedTuple):
    """A command: what stands behind its name, one line about it, and the function that does it.

    target: "module:function", imported when it is called, with the list of arguments; a parallel one also gets the
    communicator of all ranks and starts PETSc itself (fsipetsc.launch.start_petsc). options: "module:name" of its own
    options, heading -> Options (fsipetsc.options.read_table), which -help lists, or of a function of the arguments that
    returns them.
    """

    arguments: str
    summary: str
    target: str
    parallel: bool = False
    options: str = ""


COMMANDS = {
    "info": Command("RUN.h5", "what a result holds: case, options, times, layers, summary", "fsipetsc.cli:info"),
    "plot": Command("RUN.h5 [-o DIR]", "pictures (PNG) of a result", "fsipetsc.cli:plot"),
    "convergence": Command(
        "CASE [-option value ...]",
        "errors, observed orders and cost of a case with an exact solution",
        "fsipetsc.analysis.convergence:convergence",
        parallel=True,
        options="fsipetsc.analysis.convergence:sections",
    ),
    "stability": Command(
        "[-sweep] [-option value ...]",
        "the linear theory, checked: spectra, energy growth, time-step limits",
        "fsipetsc.analysis.stability:stability",
        parallel=True,
        options="fsipetsc.analysis.stability_options:SECTIONS",
    ),
    "bench": Command(
        "[-option value ...]",
        "what a time step costs on 1 to N ranks, and where the time goes",
        "fsipetsc.analysis.bench:bench",
        parallel=True,
        options="fsipetsc.analysis.bench:SECTIONS",
    ),
}
_VERSION_FLAGS = ("--version", "-version")


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
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal that lacks a letter must not end a run
    if _is_run(arguments):
        return _in_parallel(arguments)
    if launcher_rank() > 0:
        return 0  # rank 0 alone answers
    try:
        _answer(arguments)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, a pager or head, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (Exception, KeyboardInterrupt) as error:
        return settle(error, None, debug="-fsi_debug" in arguments)
    return 0


def _is_run(arguments: Sequence[str]) -> bool:
    """True for what is done by all ranks together, False for what one process answers."""
    if not arguments or arguments[0] in HELP_FLAGS + _VERSION_FLAGS:
        return False
    if any(word in HELP_FLAGS + _VERSION_FLAGS for word in arguments[1:]):
        return False
    return arguments[0] not in COMMANDS or COMMANDS[arguments[0]].parallel


def _answer(arguments: list[str]) -> None:
    first = arguments[0] if arguments else "-help"
    if any(word in _VERSION_FLAGS for word in arguments):
        print(f"fsipetsc {_version()}")
    elif first in HELP_FLAGS:
        print(overview(summaries(), {name: command[:2] for name, command in COMMANDS.items()}))
    elif first in COMMANDS:
        _run_command(first, arguments[1:])
    else:
        print(case_help(load_case(first, tuple(COMMANDS)), first))


def _run_command(name: str, arguments: list[str]) -> None:
    command = COMMANDS[name]
    if any(word in HELP_FLAGS for word in arguments):
        if command.options:
            options = _named(command.options)
            sections = options(arguments) if callable(options) else options
            print(command_help(name, command.arguments, command.summary, sections))
        else:
            print(f"{program()} {name} {command.arguments}\n\n  {command.summary}")
        return
    _named(command.target)(arguments)


def _named(place: str) -> Any:
    """What "module:name" stands for."""
    module, name = place.split(":")
    return getattr(importlib.import_module(module), name)


def _version() -> str:
    import fsipetsc

    return getattr(fsipetsc, "__version__", "(version unknown)")


def _in_parallel(arguments: list[str]) -> int:
    """A run, or a command that all ranks do together. Collective."""
    first, notes, case_file = arguments[0], None, None
    debug = "-fsi_debug" in arguments
    try:
        world = start_mpi()
        notes = world.Dup()
        if first in COMMANDS:
            _named(COMMANDS[first].target)(arguments[1:], world)
            return 0
        case_file = None if first in BUILT_IN else first
        case = together(world, lambda: load_case(first, tuple(COMMANDS)))
        start_petsc(arguments[1:], world)
        options = read_options(case)
        debug = options["fsi_debug"]
        from fsipetsc.stepping.run import run_case

        run_case(case, options, world)
    except (Exception, KeyboardInterrupt) as error:
        return settle(error, notes, debug=debug, case_file=case_file)
    finally:
        if notes is not None:
            notes.Free()
    return 0


def info(arguments: list[str]) -> None:
    """The command `info RUN.h5`."""
    path, _ = _file_and_directory("info", arguments, ())
    from fsipetsc.output.info import info as show

    print(show(path))


def plot(arguments: list[str]) -> None:
    """The command `plot RUN.h5 [-o DIR]`."""
    path, directory = _file_and_directory("plot", arguments, ("-o",))
    from fsipetsc.output.plots import plot as draw

    for picture in draw(path, directory or os.curdir):
        print(picture)


def _file_and_directory(name: str, arguments: list[str], flags: Sequence[str]) -> tuple[str, str | None]:
    """The one file that a command wants and the value of -o; InputError for anything else."""
    usage = f"{program()} {name} {COMMANDS[name].arguments}"
    words, directory, files = list(arguments), None, []
    while words:
        word = words.pop(0)
        if word in flags:
            if not words:
                raise InputError(f"{word} needs the name of a directory: {usage}")
            directory = words.pop(0)
        elif word.startswith("-"):
            raise InputError(f"unknown option {word} of the command {name}: {usage}")
        else:
            files.append(word)
    if len(files) != 1:
        got = f"{len(files)} were given" if files else "none was given"
        raise InputError(f"the command {name} wants one result file, {got}: {usage}")
    return files[0], directory
