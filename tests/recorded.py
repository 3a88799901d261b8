"""Procedures by themselves: recorded, compiled and loaded."""

from typing import Any

from fsipetsc.kernels import build
from fsipetsc.kernels.procedure import Code, Procedure


def recorded(function: Any, *records: Any) -> Procedure:
    """A function of records, compiled and loaded."""
    code = Code()
    found = code.procedure("procedure", function, *records)
    name = build.name_of(code.text)
    if build.lacks(name):
        build.keep(name, *build.made([code.text]))
    code.load(build.loaded(name, {}))
    return found
