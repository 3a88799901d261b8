"""The command line: runs a case, or one of the commands; its exit status is one for scripts."""

import importlib
import re
import shlex
import sys
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from fsipetsc import __version__
from fsipetsc.cases import load_case, summaries
from fsipetsc.errors import InputError
from fsipetsc.options import groups, is_option
from fsipetsc.process.failure import end_together
from fsipetsc.process.launch import launcher_rank, left_as_found, start_mpi, start_petsc
from fsipetsc.process.streams import abandon, complete_streams
from fsipetsc.process.together import Comm, together
from fsipetsc.usage import PROGRAM, options_help, overview


class Command(NamedTuple):
    """A command: what comes after its name, and one line about it.

    module: of what all ranks do; its function of the command's name gets the arguments and their
    communicator, and starts PETSc; its SECTIONS, or sections(arguments), are the options that -help
    lists. "": what one process does, see ``_done_by_one``.
    """

    arguments: str
    summary: str
    module: str = ""


COMMANDS = {
    "info": Command("RUN.h5", "print what a result holds: case, options, times, layers, summary"),
    "plot": Command("RUN.h5 [-o DIR|FILE] [-fields p,T] [-times 0,0.5] [-all] [-animate]",
        "draw a result on a page (PNG, or PDF or SVG as FILE ends), all pictures, a film (GIF)"),
    "report": Command("RUN.h5 [-o DIR]",
        "make one HTML page of a result: film, pictures, options, summary"),
    "diff": Command("A.h5 B.h5",
        "print by how much two results differ, also in units in the last place"),
    "new": Command("FILE.py [-blocks]",
        "write a case file to start from; -blocks: in two dimensions"),
    "convergence": Command("CASE [-option value ...]",
        "print errors of a case, or differences between its grids, observed orders and cost",
        "fsipetsc.analysis.convergence"),
    "stability": Command("[-sweep] [-option value ...]",
        "check the linear theory of interfaces: spectra, energy growth, time-step limits",
        "fsipetsc.analysis.stability"),
    "flutter": Command("[-option value ...]",
        "find the dynamic pressure at which a panel flutters, for several Mach numbers",
        "fsipetsc.analysis.flutter"),
    "modes": Command("ring|shell [-option value ...]",
        "print frequencies of small motions of a case at rest, of the scheme and exact",
        "fsipetsc.analysis.modes"),
    "verify": Command("[NAME ...] [-verify_level full]",
        "compare cases with references: errors, observed orders, verdicts",
        "fsipetsc.verify.command"),
    "bench": Command("[-option value ...]",
        "measure what a time step costs on 1 to N ranks",
        "fsipetsc.bench.command"),
}  # fmt: skip
HELP_FLAGS, _VERSION_FLAGS = {"-h", "-help", "--help"}, {"--version", "-version"}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program with the arguments after its name; returns the exit status.

    None stands for sys.argv: then the process is the program's own. With arguments given, it is
    somebody else's, such as a notebook's: each run leaves it as it was.
    """
    if argv is None:
        return _main(sys.argv[1:])
    with left_as_found():
        return _main(list(argv))


def _main(arguments: list[str]) -> int:
    complete_streams()
    notes = None
    try:
        first = arguments[0] if arguments else "-help"
        by_one = first in COMMANDS and not COMMANDS[first].module
        if by_one or not (HELP_FLAGS | _VERSION_FLAGS).isdisjoint([first, *arguments]):
            if launcher_rank() == 0:
                _answer(first, arguments[1:])
        else:
            world = start_mpi()
            notes = world.Dup()
            _do_together(first, arguments[1:], world)
        print(end="", flush=True)  # while an error can still be answered
    except BrokenPipeError:  # the reader, a pager or head, has seen enough
        abandon(1)
    except (Exception, KeyboardInterrupt) as error:
        return end_together(error, notes)
    finally:
        if notes is not None:
            notes.Free()
    return 0


def _answer(first: str, rest: list[str]) -> None:
    """Print a text about the program, or do a command that one process does."""
    if not _VERSION_FLAGS.isdisjoint([first, *rest]):
        print(f"fsipetsc {__version__}")
    elif first in HELP_FLAGS:
        print(overview(summaries(), {name: command[:2] for name, command in COMMANDS.items()}))
    elif first not in COMMANDS:
        case = load_case(first, tuple(COMMANDS))
        title = f"{case.NAME}: {case.SUMMARY}"
        print(options_help(title, f"{first} [-option value ...]", groups(case)))
    elif HELP_FLAGS.isdisjoint(rest):
        for line in _done_by_one(first, _given(first, rest)):
            print(line)
    elif (command := COMMANDS[first]).module:
        module: Any = importlib.import_module(command.module)
        sections = getattr(module, "SECTIONS", None) or module.sections(rest)
        about = f"{first}: {command.summary}", f"{first} {command.arguments}"
        print(options_help(*about, sections, in_loop=False))
    else:
        print(f"{PROGRAM} {first} {command.arguments}\n\n  {command.summary}")


def _do_together(name: str, arguments: list[str], world: Comm) -> None:
    """A run, or a command that all ranks do together. Collective."""
    if name in COMMANDS:
        module = importlib.import_module(COMMANDS[name].module)
        getattr(module, name)(arguments, world)
        return
    case = together(world, lambda: load_case(name, tuple(COMMANDS)))
    given = start_petsc(arguments, world)
    from fsipetsc.stepping.run import run_given

    run_given(case, given, world)


def _done_by_one(name: str, found: dict[str, str]) -> Iterable[object]:
    """Do a command with its files and options; returns the lines to print."""
    if name == "info":
        from fsipetsc.output.info import info

        return [info(found["RUN.h5"])]
    if name == "plot":
        from fsipetsc.output.plots.page import plot

        return plot(found.pop("RUN.h5"), found)
    if name == "report":
        from fsipetsc.output.report import report

        return [report(found["RUN.h5"], found.get("-o", "."))]
    if name == "diff":
        from fsipetsc.output.differences import compare, table

        return [table(compare(found["A.h5"], found["B.h5"]))]
    from fsipetsc.output.new_case import new_case

    path = new_case(found["FILE.py"], tuple(COMMANDS), "-blocks" in found)
    return [f"wrote {path}; it runs as it is:  {PROGRAM} {shlex.quote(str(path))}"]


def _given(command: str, arguments: list[str]) -> dict[str, str]:
    """Option or file, as the command's arguments name it -> what was given. InputError."""
    usage = COMMANDS[command].arguments
    options = dict(re.findall(r"\[(-\w+) ?([^]]*)\]", usage))  # -> its value, "" if it has none
    files, found = re.sub(r"\[.*?\]", "", usage).split(), {}
    waiting, fault = list(arguments), ""
    while waiting and not fault:
        word = waiting.pop(0)
        name = word[1:] if word.startswith("--") else word
        if files and word and not is_option(word):
            found[files.pop(0)] = word
        elif name not in options:
            fault = f"unexpected argument '{word}'"
        elif options[name] and (not waiting or is_option(waiting[0])):
            fault = f"{name} needs a value"
        else:
            found[name] = waiting.pop(0) if options[name] else ""
    if fault or files:
        fault = fault or f"{files[0]} is missing"
        raise InputError(f"{command}: {fault}: {PROGRAM} {command} {usage}")
    return found
