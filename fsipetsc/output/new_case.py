"""A case file to start from: a copy of fsipetsc/cases/template.py, or block_template.py, under a name of the user's."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from importlib.machinery import PathFinder
from pathlib import Path

from fsipetsc.cases import BUILT_IN, template_text
from fsipetsc.errors import FileError, InputError
from fsipetsc.options import LONGEST_NAME
from fsipetsc.output.places import check_folder


def new_case(name: str, commands: Sequence[str], blocks: bool = False) -> Path:
    """Write the template of layers, or of blocks, as the file `name`; its path.

    commands: names of the program's commands. InputError for a name that could not be run, or would hide something else;
    FileError where there is a file already, which is left as it is, or none can be written.
    """
    path = Path(name)
    _check(path, name, commands)
    check_folder(name, path.parent)
    text = template_text(blocks)
    if re.fullmatch(r"[\w./-]+", name):  # as it may stand in the examples
        text = text.replace("FILE.py", name)
        for suffix in ("h5", "xdmf"):
            text = text.replace(f"NAME.{suffix}", f"{path.stem}.{suffix}")
    try:
        with open(path, "x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise FileError(
            f"{name}: exists already, and nothing is overwritten; give another name, or move it away"
        ) from None
    except OSError as error:
        raise FileError(f"{name}: cannot be written: {error.strerror}") from None
    return path


def _check(path: Path, name: str, commands: Sequence[str]) -> None:
    """InputError unless a case file can have this name."""
    stem = path.stem
    if name.endswith("/") or path.suffix != ".py" or not name.isprintable():
        raise InputError(f"new: '{name}' is no name of a case file: expected one that ends in .py, such as my_case.py")
    if len(os.fsencode(f"{stem}.h5")) > LONGEST_NAME:
        raise InputError(f"new: '{path.name}' is too long: the result's name would have more than {LONGEST_NAME} bytes")
    taken = "a built-in case" if stem in BUILT_IN else "a command" if stem in commands else None
    if taken is None and _is_module(stem):
        taken = "a Python module, which this file would hide"
    if taken:
        raise InputError(f"new: '{stem}' is the name of {taken}: expected another name, such as my_{stem}.py")


def _is_module(name: str) -> bool:
    """Whether a module of this name is installed; what stands in the working directory does not count."""
    if name in sys.stdlib_module_names or name == "fsipetsc":
        return True
    here = os.getcwd()
    found = PathFinder.find_spec(name, [folder for folder in sys.path if folder and os.path.abspath(folder) != here])
    return found is not None and found.origin is not None  # a mere folder of that name has none
