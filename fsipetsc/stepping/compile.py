"""The command ``python -m fsipetsc compile CASE``: makes the kernels that a case needs, and nothing
else, as on a login node whose compute nodes have no compiler.
"""

from functools import partial

from fsipetsc.cases import case_after, options_after
from fsipetsc.options import read_options
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.streams import say
from fsipetsc.process.together import Comm, together

sections = partial(options_after, "compile")


def compile(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective. InputError, FileError."""
    case = together(comm, lambda: case_after("compile", arguments))
    options = read_options(case, start_petsc(arguments[1:], comm))
    from fsipetsc.stepping.solve import build_problem, make_state  # which start PETSc if none has

    announce = say if comm.rank == 0 and not options["fsi_quiet"] else lambda text: None
    with make_state(build_problem(case, options, comm), options, comm, announce):
        pass
    announce(f"the kernels of {case.NAME} are ready")
