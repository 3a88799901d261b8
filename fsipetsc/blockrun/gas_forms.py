"""Which form of convection a gas has, and which formulas of its law the options need."""

from typing import Any

from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.errors import InputError
from fsipetsc.materials.own import knows_entropy
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.stiffened_gas import StiffenedGas
from fsipetsc.operators.undivided import sigma_of
from fsipetsc.scheme.gas_rows import DivergenceForm, EntropyForm

#: laws whose entropy the two-point flux of fsipetsc.equations.gas conserves
CONSERVED = PerfectGas, StiffenedGas


def convection_of(option: str, law: Any) -> DivergenceForm | EntropyForm:
    """The form of -fsi_convection for a law of gas; auto: entropy where the flux conserves it."""
    divergence = option == "divergence" or not isinstance(law, CONSERVED)
    return DivergenceForm() if divergence else EntropyForm()


def check_gas_laws(problem: BlockProblem, form: Any) -> None:
    """InputError if the law of a gas lacks what an option needs; form: see
    fsipetsc.blockrun.block_state.BlockForm.
    """
    dissipates = sigma_of(form.dissipation, problem.joined) > 0.0
    given = f" {form.dissipation:g}" if form.dissipation else ", which is 1 where blocks are joined"
    for block in problem.blocks:
        law = block.material.gas_law if block.kind == "fluid" else None
        if law is None or isinstance(law, CONSERVED):
            continue
        owner = f"the law of the gas '{block.name}'"
        if form.convection == "entropy":
            found = "is not that of a perfect or stiffened gas, whose entropy this conserves"
            raise InputError(f"-fsi_convection entropy: {owner} {found}: expected auto, divergence")
        if dissipates and not knows_entropy(law):
            lacks = f"{owner} has no formula entropy(rho, T), which this needs"
            raise InputError(f"-fsi_dissipation{given}: {lacks}; -1: no dissipation")
