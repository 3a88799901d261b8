"""The built-in cases and the loading of users' own case files.

A case is a module with
  NAME      str, names the result file, so no / in it   (if it is missing, the file's name)
  SUMMARY   str, one line                               (… empty)
  OPTIONS   tuple of fsipetsc.options.Option: materials, geometry
  DEFAULTS  dict, name of an option -> default that replaces the common one   (… empty)
  build     function of the options in force (name -> value) that returns a
            fsipetsc.problem.Problem or fsipetsc.blocks.problem.BlockProblem
To add a built-in case, write its file here and add its name to BUILT_IN. Nothing is imported before
it is needed.
"""

from __future__ import annotations

import ast
import importlib
import os
import re
import sys
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

from fsipetsc.blame import explain, short
from fsipetsc.errors import InputError
from fsipetsc.options import Option, groups

OF_LAYERS = ("rod", "mms", "pulse", "box", "heat", "column", "piston", "shock")
OF_BLOCKS = (
    *("plane_mms", "blast", "panel", "wave", "tube", "oblique", "step", "fin", "cylinder"),
    *("box_mms", "ring", "disk", "shell", "elastic_piston", "superseismic", "viscous_tube"),
)
BUILT_IN = (*OF_LAYERS, *OF_BLOCKS)


def summaries() -> dict[str, str]:
    """Name -> SUMMARY of every built-in case, read from the source without running it."""
    return {name: _summary(Path(__file__).with_name(f"{name}.py")) for name in BUILT_IN}


def template_text(blocks: bool = False) -> str:
    """The text of a case file to start from, of layers in one dimension or of blocks in two.

    In it FILE.py and NAME stand for its own name.
    """
    name = "block_template.py" if blocks else "template.py"
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def _summary(path: Path) -> str:
    try:
        tree = ast.parse(path.read_text(encoding="utf-8"))
    except OSError:
        return ""
    values = (node.value for node in tree.body if _assigned_name(node) == "SUMMARY")
    return next((ast.literal_eval(value) for value in values if value), "")


def _assigned_name(node: ast.stmt) -> str | None:
    target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
    return target.id if isinstance(target, ast.Name) else None


def load_case(name_or_path: str, also: Sequence[str] = ()) -> ModuleType:
    """The module of a built-in case, or of the case file at a path.

    also: further names that may be suggested for a misspelt one. Raises InputError, with file, line
    and reason if a user's file is at fault.
    """
    if name_or_path in BUILT_IN:
        return importlib.import_module(f"fsipetsc.cases.{name_or_path}")
    if name_or_path.endswith(".py") or os.sep in name_or_path:
        return _load_file(Path(name_or_path))
    if name_or_path.endswith(".h5") and os.path.isfile(name_or_path):
        commands = f"info {name_or_path}, plot {name_or_path}"
        raise InputError(f"'{name_or_path}' is no case; results are for commands: {commands}")
    beside = [f"{name_or_path}.py"] if os.path.isfile(f"{name_or_path}.py") else []
    near = beside or get_close_matches(name_or_path, [*BUILT_IN, *also], 1, 0.5)
    hint = f"; did you mean '{near[0]}'?" if near else "."
    known = f"There are {', '.join(BUILT_IN)}, and any case file (.py)"
    raise InputError(f"unknown case '{name_or_path}'{hint} {known}")


def _load_file(path: Path) -> ModuleType:
    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            # a pipe can be read once only, and not by all ranks
            raise InputError(f"case file {path}: not a regular file")
        path.read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(f"case file {path}: {getattr(error, 'strerror', error)}") from None
    name = f"fsipetsc_case_{re.sub(r'[^0-9A-Za-z_]', '_', path.stem)}"
    loader = SourceFileLoader(name, str(path.resolve()))
    module = ModuleType(name)
    module.__file__ = loader.path
    sys.modules[name] = module
    if str(path.resolve().parent) not in sys.path:
        sys.path.append(str(path.resolve().parent))  # for modules of the user's beside the file
    written, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        loader.exec_module(module)
    except (KeyboardInterrupt, MemoryError):
        raise
    except BaseException as error:  # sys.exit() among them
        raise InputError(explain(error, path)) from error
    finally:
        sys.dont_write_bytecode = written
    _complete(module, path)
    return module


def _complete(module: ModuleType, path: Path) -> None:
    """Check what the file defines, fill in what may be missing."""
    tuple_of = "OPTIONS, a tuple of Option, which may be ()"
    for name, what in {"build": "a function build(opt)", "OPTIONS": tuple_of}.items():
        if not hasattr(module, name):
            raise InputError(f"case file {path} does not define {what}")
    module.NAME = getattr(module, "NAME", path.stem)
    module.SUMMARY = getattr(module, "SUMMARY", "")
    module.DEFAULTS = getattr(module, "DEFAULTS", {})
    wrong = {
        "build": None if callable(module.build) else "must be a function",
        "NAME": _fault_in_name(module.NAME),
        "SUMMARY": None if isinstance(module.SUMMARY, str) else "must be a text",
        "DEFAULTS": None
        if isinstance(module.DEFAULTS, Mapping)
        else "must be a dict: name of an option -> value",
        "OPTIONS": _fault_in_options(module.OPTIONS),
    }
    for name, reason in wrong.items():
        if reason:
            raise InputError(f"case file {path}{_line_of(name, path)}: {name} {reason}")
    try:
        groups(module)
    except InputError as error:
        if str(error).startswith(f"{short(path.resolve())}, line "):  # of a function of the file
            error.args = (f"case file {error}",)
            raise
        name = "DEFAULTS" if "default" in str(error).lower() else "OPTIONS"
        raise InputError(f"case file {path}{_line_of(name, path)}: {error}") from None


def _fault_in_name(name: object) -> str | None:
    """A result is written where the program runs, whatever the case is called."""
    if not isinstance(name, str) or not name:
        return "must be a text"
    own = os.path.basename(name) == name and name not in (os.curdir, os.pardir)
    if name.isprintable() and own:
        return None
    return f"is {name!r}: it names the result file, so it must be a file's name without a directory"


def _fault_in_options(options: object) -> str | None:
    if not isinstance(options, (tuple, list)):
        return "must be a tuple of Option (a tuple of one needs a comma: (Option(…),))"
    wrong = [i for i, option in enumerate(options) if not isinstance(option, Option)]
    if not wrong:
        return None
    return f"must hold Options only, but number {wrong[0] + 1} is {options[wrong[0]]!r}"


def _line_of(name: str, path: Path) -> str:
    """ ", line N" of the first assignment to a name in a file, or ""."""
    nodes = ast.parse(path.read_bytes()).body
    lines = [node.lineno for node in nodes if _assigned_name(node) == name]
    return f", line {lines[0]}" if lines else ""
