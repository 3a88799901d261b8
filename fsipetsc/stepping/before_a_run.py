"""What is done with a case before it runs. ``new FILE.py`` copies a template under a name of the
user's. ``geometry CASE`` shows blocks as a table and a picture; nothing is compiled. ``compile
CASE`` makes the kernels of a case, as on a login node whose compute nodes have no compiler.
"""

import shlex
from collections.abc import Mapping
from pathlib import Path

from fsipetsc import cases
from fsipetsc.errors import InputError
from fsipetsc.options import PROGRAM, read_options
from fsipetsc.output.geometry_picture import draw_geometry, geometry_rows
from fsipetsc.output.info import table
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm, say, together


def new(name: str, given: Mapping[str, str]) -> str:
    """Write a template as the file `name`; return how it is run. InputError, OSError."""
    path = Path(name)
    if path.suffix != ".py" or path.stem in cases.BUILT_IN:
        expected = "expected one that ends in .py and is no built-in case, such as my_case.py"
        raise InputError(f"new: '{name}' is no name of a case file: {expected}")
    if len(given) > 1:
        raise InputError(f"new: {' and '.join(given)} are given: expected one of them")
    template = "ring" if "-blocks" in given else "".join(["template", *given]).replace("-", "_")
    text = Path(cases.__file__).with_name(f"{template}.py").read_text(encoding="utf-8")
    text = text.replace("FILE.py", shlex.quote(name)).replace("NAME.", f"{path.stem}.")
    with path.open("x", encoding="utf-8") as file:
        file.write(text)
    return f"wrote {path}; it runs as it is:  {PROGRAM} {shlex.quote(str(path))}"


def compile(arguments: list[str], comm: Comm) -> None:
    case = together(comm, lambda: cases.load_case(arguments[0]))
    options = read_options(case, start_petsc(arguments[1:], comm))
    from fsipetsc.stepping.run import build_problem, make_state  # which start PETSc if none has

    announce = say if comm.rank == 0 and not options["fsi_quiet"] else lambda text: None
    with make_state(build_problem(case, options, comm), options, comm, announce):
        announce(f"the kernels of {case.NAME} are ready")


def geometry(arguments: list[str], comm: Comm) -> None:
    case = together(comm, lambda: cases.load_case(arguments[0]))
    opt = read_options(case, start_petsc(arguments[1:], comm))
    from fsipetsc.stepping.run import build_problem

    problem = build_problem(case, {**opt, "fsi_coupling": "conservative"}, comm)  # of blocks

    def show() -> None:
        rows = geometry_rows(problem)
        drawn = draw_geometry(problem, case.NAME, rows[-1][1])
        if not opt["fsi_quiet"]:
            say(f"{table(rows)}\npicture in {drawn}")

    together(comm, show if comm.rank == 0 else lambda: None)
