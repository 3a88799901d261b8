"""Procedures by themselves: recorded, compiled and loaded."""

from typing import Any

from fsipetsc.kernels import build
from fsipetsc.kernels.procedure import Code, Procedure


def recorded(function: Any, *records: Any) -> Procedure:
    """A function of records, compiled and loaded."""
    code = Code()
    found = code.procedure("procedure", function, *records)
    name = build.name_of(code.text)
    if build.found(name) is None:
        build.keep(build.made({name: code.text}))
    code.load(build.loaded(name, {}))
    return found
