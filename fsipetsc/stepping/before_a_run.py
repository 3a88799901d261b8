"""What is done with a case before it runs. ``geometry CASE`` shows its blocks or layers as a table
and a picture; nothing is compiled. ``compile CASE`` makes the kernels that it needs, as on a login
node whose compute nodes have no compiler.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fsipetsc.cases import case_after, options_after
from fsipetsc.options import Option, read_options
from fsipetsc.output.geometry_picture import draw_geometry, geometry_rows, outlines
from fsipetsc.output.info import table
from fsipetsc.output.plots.page import PICTURES
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.program import say
from fsipetsc.process.together import Comm, together

_OF_GEOMETRY = (
    Option("o", str, None, "", "file of the picture; CASE-geometry.png if not given",
        check=lambda name: name.endswith(PICTURES) or f"a name with {' or '.join(PICTURES)}"),
)  # fmt: skip


def sections(command: str, arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help."""
    return options_after(command, arguments, _OF_GEOMETRY if command == "geometry" else ())


def compile(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective. InputError, FileError."""
    case = together(comm, lambda: case_after("compile", arguments))
    options = read_options(case, start_petsc(arguments[1:], comm))
    from fsipetsc.stepping.solve import build_problem, make_state  # which start PETSc if none has

    announce = say if comm.rank == 0 and not options["fsi_quiet"] else lambda text: None
    with make_state(build_problem(case, options, comm), options, comm, announce):
        pass
    announce(f"the kernels of {case.NAME} are ready")


def geometry(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective. InputError, FileError."""
    case = together(comm, lambda: case_after("geometry", arguments))
    opt = read_options(case, start_petsc(arguments[1:], comm), _OF_GEOMETRY)
    from fsipetsc.stepping.solve import build_problem

    problem = build_problem(case, opt, comm)
    together(comm, lambda: _show(case, problem, opt) if comm.rank == 0 else None)


def _show(case: Any, problem: Any, opt: dict[str, Any]) -> None:
    """Print the table, and draw the picture. InputError, FileError."""
    found, m = outlines(problem, opt["fsi_h"]), problem.unit("m")
    rows = geometry_rows(found, m)
    d, target = problem.dimension, Path(opt["o"] or f"{case.NAME}-geometry.png")
    axes = [*"XYZ"[: d - 1], "r" if getattr(problem, "symmetry", 0) else "XYZ"[d - 1]]
    labels = [f"{x} [m]" if m else x for x in axes]
    drawn = draw_geometry(target, found, f"{case.NAME}: {rows[-1][1]}", labels)
    if not opt["fsi_quiet"]:
        say(table(rows))
        say(f"picture in {drawn}")
