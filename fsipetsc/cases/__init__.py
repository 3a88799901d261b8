"""The built-in cases and the loading of users' own case files.

A case is a module, or what ``common.case`` makes. It has build, a function of the options in force
(name -> value) that returns a Problem or a BlockProblem. What a file need not define is filled in:
NAME, that of the result file, SUMMARY, the first line of its docstring, OPTIONS, a tuple of Option,
and DEFAULTS, name of an option -> default that replaces the common one.
"""

import importlib
import os
import re
import sys
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

from fsipetsc.errors import InputError, call
from fsipetsc.options import Option, groups

#: file -> its cases
_FILES = {
    "lines": "rod pulse box column piston heat wave",
    "shocks": "shock tube elastic_piston superseismic blast oblique",
    "flows": "panel step viscous_tube shell disk cylinder nozzle fin",
    "ring": "ring",
    "manufactured": "mms box_mms body_mms",
}
#: name -> file of every built-in case
BUILT_IN = {name: file for file, names in _FILES.items() for name in names.split()}


def named(case: Any, name: str, documented: Any) -> Any:
    """Give a case the name and the first line of a docstring, unless it has its own."""
    first = (documented.__doc__ or "").strip().partition("\n")[0].rstrip(".")
    if name in BUILT_IN:  # as they are listed
        first = first[:1].lower() + first[1:]
    about = {"NAME": name, "SUMMARY": first, "OPTIONS": (), "DEFAULTS": {}}
    vars(case).update(about | vars(case))
    return case


def load_case(name_or_path: str, also: Sequence[str] = ()) -> Any:
    """A built-in case, or the module of a case file; also: other names to suggest. InputError."""
    if name_or_path in BUILT_IN:
        file = importlib.import_module(f"fsipetsc.cases.{BUILT_IN[name_or_path]}")
        # ring.py is a case, and a template
        return getattr(file, name_or_path, None) or named(file, name_or_path, file)
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


def case_of(problem: Any, **defaults: Any) -> SimpleNamespace:
    """A case that is one problem; defaults: as in a case's DEFAULTS."""
    about = {"NAME": "problem", "SUMMARY": "", "OPTIONS": (), "DEFAULTS": defaults}
    return SimpleNamespace(**about, build=lambda opt: problem)


def _load_file(path: Path) -> ModuleType:
    """Run a case file, and check what it defines. InputError."""
    what = f"case file {path}"
    try:
        text, file = path.read_bytes(), path.resolve()
    except (OSError, ValueError) as error:
        raise InputError(f"{what}: {getattr(error, 'strerror', error)}") from None
    name = f"fsipetsc_case_{re.sub(r'[^0-9A-Za-z_]', '_', path.stem)}"
    module = sys.modules[name] = ModuleType(name)
    module.__file__ = str(file)
    if str(file.parent) not in sys.path:
        sys.path.append(str(file.parent))  # for modules of the user's beside the file
    call(exec, (call(compile, (text, str(file), "exec"), what), vars(module)), what)
    named(module, path.stem, module)
    options, defined = module.OPTIONS, callable(getattr(module, "build", None))
    of_options = isinstance(options, (tuple, list)) and all(isinstance(o, Option) for o in options)
    if not (defined and of_options and isinstance(module.DEFAULTS, Mapping)):
        expected = "a function build(opt); OPTIONS, a tuple of Option (of one: with a comma)"
        raise InputError(f"{what}: expected {expected}; DEFAULTS, a dict")
    groups(module)
    return module
