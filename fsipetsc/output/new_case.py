"""A case file to start from: a copy of a template of fsipetsc/cases under a name of the user's."""

import re
import shlex
from collections.abc import Mapping
from pathlib import Path

from fsipetsc import cases
from fsipetsc.errors import FileError, InputError
from fsipetsc.options import PROGRAM


def new(name: str, given: Mapping[str, str]) -> str:
    """Write the template of layers, or that of the option given, as the file `name`; how it is run.

    InputError for a name that could not be run, and for two options; FileError where there is a
    file, which is left; OSError where none can be written.
    """
    path, stem = Path(name), Path(name).stem
    if path.suffix != ".py":
        expected = "expected one that ends in .py, such as my_case.py"
        raise InputError(f"new: '{name}' is no name of a case file: {expected}")
    if stem in cases.BUILT_IN:
        expected = f"expected another name, such as my_{stem}.py"
        raise InputError(f"new: '{stem}' is the name of a built-in case: {expected}")
    if len(given) > 1:
        raise InputError(f"new: {' and '.join(given)} are given: expected one of them")
    template = "".join(["template", *(option.replace("-", "_") for option in given), ".py"])
    text = Path(cases.__file__).with_name(template).read_text(encoding="utf-8")
    if re.fullmatch(r"[\w./-]+", name):  # as it may stand in the examples
        text = text.replace("FILE.py", name).replace("NAME.", f"{stem}.")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        said = f"{name}: exists already and is not overwritten; give another name"
        raise FileError(said) from None
    return f"wrote {path}; it runs as it is:  {PROGRAM} {shlex.quote(str(path))}"
