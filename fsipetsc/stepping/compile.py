"""The command ``python -m fsipetsc compile CASE``: makes the kernels that a case needs, and nothing
else, as on a login node whose compute nodes have no compiler.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.options import groups, read_options
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.streams import say
from fsipetsc.process.together import Comm, together


def sections(arguments: Sequence[str]) -> Mapping[str, Any]:
    """The options that -help lists: those of the case, if one is named."""
    named = arguments and not arguments[0].startswith("-")
    return groups(_case(arguments)) if named else {}


def compile(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective. InputError, FileError."""
    case = together(comm, lambda: _case(arguments))
    options = read_options(case, start_petsc(arguments[1:], comm))
    from fsipetsc.stepping.solve import build_problem, make_state  # which start PETSc if none has

    announce = say if comm.rank == 0 and not options["fsi_quiet"] else lambda text: None
    with make_state(build_problem(case, options, comm), options, comm, announce):
        pass
    announce(f"the kernels of {case.NAME} are ready")


def _case(arguments: Sequence[str]) -> Any:
    """The case that comes first."""
    if not arguments or arguments[0].startswith("-"):
        usage = "python -m fsipetsc compile CASE [-option value ...]"
        raise InputError(f"compile: CASE is missing: {usage}")
    return load_case(arguments[0])
