"""From a case and options to its problem, and the state of a run of it."""

from collections.abc import Callable, Mapping
from typing import Any

from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blockrun.gas_part import check_gas_laws
from fsipetsc.blockrun.saved import chosen
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import described
from fsipetsc.errors import InputError, call, place_of
from fsipetsc.paper.paper_state import PaperState
from fsipetsc.problem import Problem, blocks_of_line
from fsipetsc.process import libraries
from fsipetsc.process.together import together


def build_problem(case: Any, opt: Mapping[str, Any], comm: MPI.Comm) -> Problem | BlockProblem:
    """Return what the case says for the options in force: layers for the paper's couplings, else
    blocks.

    Collective; InputError, with file and line of a user's case file.
    """

    def build() -> Problem | BlockProblem:
        problem = call(case.build, (opt,), "build")
        if isinstance(problem, BlockProblem):
            return problem
        if not isinstance(problem, Problem):
            found = "nothing (is its return missing?)" if problem is None else described(problem)
            raise InputError(
                f"{place_of(case.build)}: build(opt) returns {found}: "
                "expected a Problem or BlockProblem"
            )
        if opt["fsi_coupling"] != "conservative":
            return problem
        return blocks_of_line(problem, opt["fsi_h"], opt["fsi_order"])

    return together(comm, build)


def make_state(
    problem: Problem | BlockProblem,
    opt: dict[str, Any],
    comm: MPI.Comm,
    announce: Callable[[str], None] = lambda text: None,
) -> PaperState | BlockState:
    """Return the state that the options in force ask for. Collective.

    announce: called on rank 0, with a message, before and after kernels are compiled. InputError
    where grid, order and ranks do not fit, or a law cannot be recorded.
    """
    libraries.keeps_text = opt["fsi_debug"]
    if isinstance(problem, BlockProblem):
        form = block_form(opt)
        check_gas_laws(problem, form)
        recorded = together(comm, lambda: chosen(problem, opt["fsi_probes"]))
        of_run = form, opt["fsi_partition"], recorded, announce
        return BlockState(comm, problem, opt["fsi_order"], *of_run)
    if opt["fsi_probes"]:
        said = "here series of all interfaces are recorded anyway"
        raise InputError(f"-fsi_probes is of blocks: {said}")
    kept = problem.invariants
    if opt["fsi_check"] is not None and not (kept.get("masses") or kept.get("energy")):
        raise InputError(
            "-fsi_check: nothing is conserved here, neither the mass of a gas nor the energy"
        )
    return PaperState(comm, problem, opt, announce)


def block_form(opt: Mapping[str, Any]) -> BlockForm:
    """Return the form of the equations that is asked for. InputError for another method."""
    coupling, mapping = ("conservative",), ("auto", "stretched")
    there = {"fsi_coupling": coupling, "fsi_mapping": mapping, "fsi_viscous": ("wide",)}
    for name, wanted in there.items():
        if opt[name] not in wanted:
            blocks = "this case is made of blocks, as is any with -fsi_coupling conservative"
            raise InputError(f"-{name} {opt[name]}: {blocks}: expected {' or '.join(wanted)}")
    return BlockForm(opt["fsi_convection"], opt["fsi_dissipation"], opt["fsi_shock"])
