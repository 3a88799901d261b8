"""The physics of the layers of a problem, and what the scheme does with each of them.

A law is the formulas of a physics (fsipetsc.physics.fluid, .solid) and the loops over its kind of layer. Compiled functions
find that of a layer by its number among LAWS, ``with_chosen(of_layer.sweep, LAWS, layer.law, layer, ...)``.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.physics.constant_transport import constant_transport
from fsipetsc.physics.fluid import navier_stokes
from fsipetsc.physics.gruneisen import gruneisen
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.physics.solid import elastic_solid
from fsipetsc.scheme.end_rates import as_they_are, keep_entropy
from fsipetsc.scheme.extremes_and_sums import fluid_extremes_and_sums, solid_extremes_and_sums
from fsipetsc.scheme.layer_fields import fluid_fields, solid_fields
from fsipetsc.scheme.speeds import fluid_speeds, solid_speeds
from fsipetsc.scheme.sweep import sweep


def law(physics: Formulas) -> Formulas:
    """A physics with the loops of the scheme over its kind of layer."""
    if physics.kind == FLUID:
        loops = {"look": fluid_extremes_and_sums, "speeds": fluid_speeds, "save": fluid_fields, "amend": keep_entropy}
    else:
        loops = {"look": solid_extremes_and_sums, "speeds": solid_speeds, "save": solid_fields, "amend": as_they_are}
    return Formulas(**vars(physics), **loops)


LAWS = law(navier_stokes(perfect_gas, constant_transport)), law(elastic_solid(gruneisen))


@njit(**FORMULA)
def _look(law, *arguments):
    law.look(law, *arguments)


@njit(**FORMULA)
def _speeds(law, *arguments):
    return law.speeds(law, *arguments)


@njit(**FORMULA)
def _save(law, *arguments):
    law.save(law, *arguments)


of_layer = Formulas(sweep=sweep, look=_look, speeds=_speeds, save=_save)
