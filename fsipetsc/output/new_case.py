"""A case file to start from: a copy of a template of fsipetsc/cases under a name of the user's."""

import re
import sys
from collections.abc import Sequence
from pathlib import Path

from fsipetsc.blame import NEEDED
from fsipetsc.cases import BUILT_IN, template_text
from fsipetsc.errors import FileError, InputError
from fsipetsc.output.file_layout import check_folder


def new_case(name: str, commands: Sequence[str], blocks: bool = False) -> Path:
    """Write the template of layers, or of blocks, as the file `name`; its path.

    commands: names of the program's commands. InputError for a name that could not be run, or would
    hide something else; FileError where there is a file, which is left, or none can be written.
    """
    path = Path(name)
    _check(path, name, commands)
    check_folder(name)
    text = template_text(blocks)
    if re.fullmatch(r"[\w./-]+", name):  # as it may stand in the examples
        text = text.replace("FILE.py", name).replace("NAME.", f"{path.stem}.")
    try:
        with open(path, "x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise FileError(
            f"{name}: exists already and is not overwritten; give another name, or move it away"
        ) from None
    except OSError as error:
        raise FileError(f"{name}: cannot be written: {error.strerror}") from None
    return path


def _check(path: Path, name: str, commands: Sequence[str]) -> None:
    """InputError unless a case file can have this name."""
    stem = path.stem
    if path.suffix != ".py":
        expected = "expected one that ends in .py, such as my_case.py"
        raise InputError(f"new: '{name}' is no name of a case file: {expected}")
    taken = "a built-in case" if stem in BUILT_IN else "a command" if stem in commands else ""
    if not taken and stem in (*sys.stdlib_module_names, "fsipetsc", *NEEDED):
        taken = "a Python module, which this file would hide"
    if taken:
        expected = f"expected another name, such as my_{stem}.py"
        raise InputError(f"new: '{stem}' is the name of {taken}: {expected}")
