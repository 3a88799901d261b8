"""A run without a result file: for studies that make many runs and compare their ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blame import call, place_of
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.checks import described
from fsipetsc.errors import InputError
from fsipetsc.options import InForce, publish
from fsipetsc.paper.state import PaperState, is_of_paper, make_paper_state
from fsipetsc.physics.dissipation import SIGMA
from fsipetsc.plane import PlaneProblem
from fsipetsc.problem import Problem
from fsipetsc.process.together import together
from fsipetsc.scheme.laws import Form
from fsipetsc.scheme.plane.equations import PlaneForm
from fsipetsc.stepping.fused import NAME as FUSED
from fsipetsc.stepping.integrator import Integrator
from fsipetsc.stepping.phases import LoggedState
from fsipetsc.stepping.plane.state import PlaneState
from fsipetsc.stepping.state import State


@dataclass(frozen=True)
class Outcome:
    """What is left of a run: cost and errors.

    t: time reached [s]. points: active ones at the end. wall_time: of the time loop [s]. errors: kind of layer -> name ->
    error in the norm in force, as fsipetsc.stepping.frames.errors gives them; None without an exact solution.
    """

    t: float
    steps: int
    evaluations: int
    points: int
    wall_time: float
    errors: dict[str, dict[str, float]] | None


def build_problem(case: Any, opt: Mapping[str, Any], comm: MPI.Comm) -> Problem | PlaneProblem | RunProblem:
    """What the case says for the options in force. Collective; InputError, with file and line of a user's case file."""

    def build() -> Problem | PlaneProblem | RunProblem:
        problem = call(case.build, (InForce(opt),), "build")
        if isinstance(problem, BlockProblem):
            return RunProblem(problem)
        if not isinstance(problem, (Problem, PlaneProblem)):
            found = "nothing (is its return missing?)" if problem is None else described(problem)
            raise InputError(f"{place_of(case.build)}: build(opt) returns {found}: expected a Problem or PlaneProblem")
        return problem

    return together(comm, build)


def make_state(
    problem: Problem | PlaneProblem | RunProblem, opt: dict[str, Any], comm: MPI.Comm
) -> State | PaperState | PlaneState | BlockState:
    """The state that the options in force ask for; with -log_view one that logs what it does. Collective.

    In two dimensions PETSc's methods make the steps where data depend on time: rk stands in ``opt`` for fused then.
    InputError where grid, order and ranks do not fit.
    """
    if isinstance(problem, RunProblem):
        plane_form(opt)
        of_blocks = BlockForm(opt["fsi_convection"], opt["fsi_dissipation"], opt["fsi_shock"])
        return BlockState(comm, problem, opt["fsi_order"], of_blocks, opt["fsi_partition"])
    if isinstance(problem, PlaneProblem):
        form = plane_form(opt)
        if opt["ts_type"] == FUSED and not problem.steady_data:
            opt["ts_type"] = "rk"
            publish(opt)
        points, partition = opt["fsi_points"] or (), opt["fsi_partition"]
        return PlaneState(comm, problem, opt["fsi_order"], opt["fsi_h"], form, points, partition)
    if opt["fsi_points"]:
        raise InputError("-fsi_points is of two dimensions: in one, series of all interfaces are recorded anyway")
    if is_of_paper(problem, opt):
        return make_paper_state(problem, opt, comm)
    return make_layer_state(problem, opt, comm)


def make_layer_state(problem: Problem, opt: Mapping[str, Any], comm: MPI.Comm) -> State:
    """The state of the program that the paper's method and blocks replace. Collective."""
    names = ("fsi_order", "fsi_h", "fsi_coupling", "fsi_mapping", "fsi_partition", "fsi_spare")
    kind = LoggedState if PETSc.Log.isActive() else State
    entropy = bool(opt["fsi_entropy"] or opt["fsi_check"])
    sigma, entropic = SIGMA * opt["fsi_dissipation"], opt["fsi_convection"] == "entropy"
    form = Form(opt["fsi_viscous"] == "narrow", sigma, opt["fsi_shock"], entropic)
    return kind(comm, problem, *(opt[name] for name in names), entropy, opt["fsi_shared_memory"], form)


#: what two dimensions have of options that choose between methods
_IN_THE_PLANE = {
    "fsi_coupling": ("conservative",),
    "fsi_mapping": ("auto", "stretched"),
    "fsi_viscous": ("wide",),
}


def plane_form(opt: Mapping[str, Any]) -> PlaneForm:
    """That of the equations in two dimensions that is asked for. InputError for a method that these do not have."""
    for name, there in _IN_THE_PLANE.items():
        if opt[name] not in there:
            raise InputError(f"-{name} {opt[name]}: in two dimensions it is {' or '.join(map(str, there))}")
    convection = "divergence" if opt["fsi_convection"] == "divergence" else "entropy"
    return PlaneForm(convection, SIGMA * opt["fsi_dissipation"], opt["fsi_shock"])


def check_begin(opt: Mapping[str, Any]) -> None:
    """InputError for options by which a run begins elsewhere: of a command that begins with the data of a case."""
    for name in ("fsi_initial", "fsi_restart"):
        if opt[name] is not None:
            raise InputError(f"-{name}: this command begins with the data of the case")


def solve(
    case: Any,
    opt: dict[str, Any],
    comm: MPI.Comm,
    announce: Callable[[str], None] = lambda text: None,
    times: Sequence[float] = (),
    look: Callable[[State | PlaneState, float], None] = lambda state, t: None,
) -> Outcome:
    """Integrate a case from t = 0 to -ts_max_time, or -ts_max_steps, and write nothing. Collective on comm.

    announce: says on rank 0 that the kernels are being compiled, if they are. look(state, t): called at 0, at these times [s]
    in between and at the end. Raises InputError and ComputationError.
    """
    check_begin(opt)
    with make_state(build_problem(case, opt, comm), opt, comm) as state:
        state.compile(announce)
        integrator = Integrator(
            state,
            opt,
            sorted({*(float(t) for t in times if t < opt["ts_max_time"]), opt["ts_max_time"]}),
            on_frame=lambda t: look(state, t),
            on_series=lambda: integrator.series.take(comm),
            on_step=lambda steps, t, dt: None,
            on_grids=lambda: None,
        )
        integrator.start()
        integrator.run()
        return Outcome(
            integrator.t,
            integrator.steps,
            integrator.evaluations,
            state.points,
            integrator.wall_time,
            state.errors(integrator.t, opt["fsi_norm"]),
        )
