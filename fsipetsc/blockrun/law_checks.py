"""Checks that gas laws have what the options need; gases that a force pushes node by node."""

from typing import Any

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.errors import InputError
from fsipetsc.materials.own import knows_entropy
from fsipetsc.operators.bands import sigma_of
from fsipetsc.scheme.gas_force import NodeForce
from fsipetsc.scheme.gas_forms import CONSERVED, convection_of


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


def loose_gases(problem: BlockProblem, convection: str) -> list[Block]:
    """The gases on which a constant force acts node by node with this -fsi_convection."""
    d, found = problem.dimension, []
    for block in problem.blocks:
        if block.kind == "fluid":
            form = convection_of(convection, block.material.equations(d, problem.symmetry))
            found += [block] if isinstance(form.force, NodeForce) else []
    return found
