"""The command line: runs a case, or one of the commands; its exit status is one for scripts."""

import importlib
import re
import sys
import textwrap
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from typing import Any, NamedTuple

from fsipetsc import __version__
from fsipetsc.cases import BUILT_IN, load_case
from fsipetsc.errors import InputError
from fsipetsc.options import PASSED_ON, PROGRAM, Option, groups, is_option, shown
from fsipetsc.process.launch import left_as_found, start_mpi, start_petsc
from fsipetsc.process.together import abandon_output, end_together, launcher_rank, together

#: characters of a line
WIDTH = 100


class Command(NamedTuple):
    """A command: the module with its function, what comes after its name, one line about it.

    By one process: a function of the files and, where there are any, the options as given, which
    returns what is printed. Else by all ranks: a function of the arguments and the communicator;
    OPTIONS of the module are its own, beside those of a case.
    """

    module: str
    arguments: str
    summary: str
    by_one: bool = False

    def find(self, name: str) -> Any:
        """Return a function or table of its module; None if there is none."""
        return getattr(importlib.import_module(f"fsipetsc.{self.module}"), name, None)


_OPTIONS = "[-option value ...]"
_CASE = f"CASE {_OPTIONS}"
COMMANDS = {
    "info": Command("output.info", "RUN.h5",
        "print what a result holds: case, options, times, layers, summary", True),
    "plot": Command("output.page", "RUN.h5 [-o DIR|FILE] [-fields p,T] [-times 0,0.5] "
        "[-contours 20] [-streamlines] [-all] [-animate]",
        "draw a result on a page (PNG, PDF, SVG or JPG as FILE ends), all pictures, a film", True),
    "report": Command("output.page", "RUN.h5 [-o DIR]",
        "make one HTML page of a result: all pictures, options, summary", True),
    "diff": Command("output.differences", "A.h5 B.h5",
        "print by how much two results differ, also in units in the last place", True),
    "new": Command("stepping.before_a_run", "FILE.py [-blocks] [-channel] [-plate] [-water]",
        "write a case file to start from: layers; curved blocks; a channel; a plate; a water pipe",
        True),
    "compile": Command("stepping.before_a_run", _CASE,
        "compile the kernels that a case needs, and do nothing else"),
    "geometry": Command("stepping.before_a_run", _CASE,
        "print and draw blocks, faces, conditions and spacing of a case, and do nothing else"),
    "convergence": Command("studies.convergence", _CASE,
        "print errors of a case, or differences between its grids, observed orders and cost"),
    "stability": Command("studies.stability", _OPTIONS,
        "check the linear theory of interfaces: spectra, energy growth, time-step limits"),
    "modes": Command("studies.modes", _CASE,
        "print frequencies of small motions about a steady state, of the scheme and exact"),
    "verify": Command("studies.verify.command", "[NAME ...] [-verify_level full]",
        "compare cases with references: errors, observed orders, verdicts"),
    "bench": Command("studies.bench", _OPTIONS,
        "measure what a time step costs on 1 to N ranks"),
}  # fmt: skip
HELP_FLAGS, _VERSION_FLAGS = {"-h", "-help", "--help"}, {"--version", "-version"}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program, as the command line does.

    Args:
        argv: the arguments after the program's name, as `["rod", "-fsi_order", "6"]`. None stands
            for `sys.argv`: then the process is the program's own. With arguments given, it is
            somebody else's, such as a notebook's: each run leaves it as it was.

    Returns:
        The exit status; errors are printed, not raised.
    """
    first, *rest = (sys.argv[1:] if argv is None else argv) or ["-help"]
    notes = None
    with nullcontext() if argv is None else left_as_found():
        try:
            command = COMMANDS.get(first)
            alone = command is not None and command.by_one
            if alone or not (HELP_FLAGS | _VERSION_FLAGS).isdisjoint([first, *rest]):
                if not launcher_rank():
                    _answer(first, command, rest)
            else:
                world = start_mpi(alone=True)
                notes = world.Dup()
                if command is not None:
                    if command.arguments == _CASE and (not rest or is_option(rest[0])):
                        raise InputError(f"{first}: CASE is missing: {PROGRAM} {first} {_CASE}")
                    command.find(first)(rest, world)
                else:
                    case = together(world, lambda: load_case(first, tuple(COMMANDS)))
                    given = start_petsc(rest, world)
                    from fsipetsc.stepping.run import run_given

                    run_given(case, given, world)
            print(end="", flush=True)  # while an error can still be answered
        except BrokenPipeError:  # the reader, a pager or head, has seen enough
            abandon_output()
        except (Exception, KeyboardInterrupt) as error:
            return end_together(error, notes)
        finally:
            if notes is not None:
                notes.Free()
    return 0


def _answer(first: str, command: Command | None, rest: list[str]) -> None:
    """Print a text about the program, or do a command that one process does."""
    if not _VERSION_FLAGS.isdisjoint([first, *rest]):
        print(f"fsipetsc {__version__}")
    elif first in HELP_FLAGS:
        print(_overview())
    elif command is None:
        case = load_case(first, tuple(COMMANDS))
        print(_options_help(f"{case.NAME}: {case.SUMMARY}", f"{first} {_OPTIONS}", groups(case)))
    elif HELP_FLAGS.isdisjoint(rest):
        print(command.find(first)(*_given(first, rest)))
    elif command.by_one:
        print(f"{PROGRAM} {first} {command.arguments}\n\n  {command.summary}")
    else:
        own = command.find("OPTIONS") or ()
        named = command.arguments == _CASE and not is_option(rest[0])
        sections = groups(load_case(rest[0]), own) if named else {"This command": own}
        about = f"{first}: {command.summary}", f"{first} {command.arguments}"
        print(_options_help(*about, sections))


def _given(command: str, arguments: list[str]) -> list[Any]:
    """Return the files, then option -> what was given, if the command has any. InputError."""
    usage = COMMANDS[command].arguments
    options = dict(re.findall(r"\[(-\w+) ?([^]]*)\]", usage))  # -> its value, "" if it has none
    wanted = re.sub(r"\[.*?\]", "", usage).split()
    files, found, words, faults = [], {}, iter(arguments), []
    for word in words:
        name = word[1:] if word.startswith("--") else word
        if name in options:
            found[name] = next(words, "") if options[name] else ""
            if options[name] and (not found[name] or is_option(found[name])):
                faults.append(f"{name} needs a value")
        elif len(files) < len(wanted) and word and not is_option(word):
            files.append(word)
        else:
            faults.append(f"unexpected argument '{word}'")
    faults += [f"{name} is missing" for name in wanted[len(files) :]]
    if faults:
        raise InputError(f"{command}: {faults[0]}: {PROGRAM} {command} {usage}")
    return [*files, found] if options else files


def _overview() -> str:
    """Return the short usage: how the program is called, cases and commands, a line each."""
    cases = {name: load_case(name).SUMMARY for name in BUILT_IN}
    sections = {
        f"Usage: {PROGRAM} ...": {
            _CASE: "run a case; in parallel with mpiexec -n N before it",
            "CASE -help": "all options of a case, with defaults and units",
            "COMMAND ...": "run a command, see below",
        },
        "Cases": {**cases, "FILE.py": "a case of your own, from a file"},
        "Commands": {f"{name} {of.arguments}": of.summary for name, of in COMMANDS.items()},
    }
    title = "fsipetsc: compressible gas and elastic solids, coupled, with PETSc"
    return _laid_out(title, sections, 24)


def _options_help(title: str, usage: str, options: Mapping[str, Sequence[Option]]) -> str:
    """List every option with type, default, unit and meaning; options: heading -> options."""
    head = f"{title}\n\n  [mpiexec -n N] {PROGRAM} {usage}"
    sections = {heading: dict(map(_row, found)) for heading, found in options.items() if found}
    sections["More of PETSc"] = {f"-{name}": what for name, what in PASSED_ON.items()}
    notes = (
        "Write an option as -name value; its type and default stand after its name. If one is "
        "given twice the last counts; the command line overrides PETSC_OPTIONS. A bool without a "
        "value is true; ints and floats are lists such as 0.1,0.25. PETSc's others are refused."
    )
    return "\n".join([_laid_out(head, sections, 40), "", *textwrap.wrap(notes, WIDTH)])


def _laid_out(title: str, sections: Mapping[str, Mapping[str, str]], left: int) -> str:
    """Lay out heading -> name -> text, on the right of names of up to ``left`` letters."""
    lines = [title]
    for heading, rows in sections.items():
        lines += ["", heading]
        for name, text in rows.items():
            if len(name) > left:
                lines += textwrap.wrap(f"  {name}", WIDTH, subsequent_indent="    ")
            begin = f"  {'' if len(name) > left else name:<{left}}  "
            indented = {"initial_indent": begin, "subsequent_indent": " " * len(begin)}
            lines += textwrap.wrap(text, WIDTH, break_on_hyphens=False, **indented) or [begin]
    return "\n".join(lines)


def _row(option: Option) -> tuple[str, str]:
    """Return (name, type, default and unit; meaning)."""
    kind = "text" if option.kind == "str" else option.kind
    choices = f" ({', '.join(map(str, option.choices))})" if option.choices else ""
    unit = f" [{option.unit}]" if option.unit else ""
    return f"-{option.name} {kind} {shown(option.default)}{unit}", option.help + choices
