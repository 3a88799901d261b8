"""The physics of the layers of a problem, and what the scheme does with each of them.

A law is the formulas of a physics (fsipetsc.physics.fluid, .solid) and the work of the scheme on its kind of layer; a pair is
the laws of gas and solid that meet at an interface. Compiled functions find that of a layer by its number among LAWS,
``with_chosen(of_layer.sweep, LAWS, layer.law, layer, ...)``, and that of an interface by its number among PAIRS.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.coupling import couple, residuals
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.physics.constant_transport import constant_transport
from fsipetsc.physics.fluid import navier_stokes
from fsipetsc.physics.gruneisen import gruneisen
from fsipetsc.physics.layer import FLUID, SOLID
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.physics.solid import elastic_solid
from fsipetsc.scheme.end_forces_and_entropy import end_forces, gas_entropy, gas_traction, solid_entropy, solid_traction
from fsipetsc.scheme.end_rates import as_they_are, keep_entropy
from fsipetsc.scheme.extremes_and_sums import fluid_extremes_and_sums, solid_extremes_and_sums
from fsipetsc.scheme.layer_ends import close_end, fill_embedded, note_embedded, note_nothing
from fsipetsc.scheme.layer_fields import fluid_fields, solid_fields
from fsipetsc.scheme.speeds import fluid_speeds, solid_speeds
from fsipetsc.scheme.sweep import sweep

#: by kind of layer: what the scheme does with it
_WORK = {
    FLUID: {
        "look": fluid_extremes_and_sums,
        "speeds": fluid_speeds,
        "save": fluid_fields,
        "amend": keep_entropy,
        "end": fill_embedded,
        "note": note_embedded,
        "traction": gas_traction,
        "entropy": gas_entropy,
    },
    SOLID: {
        "look": solid_extremes_and_sums,
        "speeds": solid_speeds,
        "save": solid_fields,
        "amend": as_they_are,
        "end": close_end,
        "note": note_nothing,
        "traction": solid_traction,
        "entropy": solid_entropy,
    },
}


def law(physics: Formulas) -> Formulas:
    """A physics with the work of the scheme on its kind of layer."""
    return Formulas(**vars(physics), **_WORK[physics.kind])


def pair(fluid: Formulas, solid: Formulas) -> Formulas:
    """The laws of the materials at an interface, from those of the layers."""
    return Formulas(gas=fluid.gas, transport=fluid.transport, pressing=solid.pressing)


LAWS = law(navier_stokes(perfect_gas, constant_transport)), law(elastic_solid(gruneisen))
PAIRS = (pair(*LAWS),)


@njit(**FORMULA)
def _look(law, *arguments):
    law.look(law, *arguments)


@njit(**FORMULA)
def _speeds(law, *arguments):
    return law.speeds(law, *arguments)


@njit(**FORMULA)
def _save(law, *arguments):
    law.save(law, *arguments)


@njit(**FORMULA)
def _end(law, *arguments):
    law.end(law, *arguments)


@njit(**FORMULA)
def _note(law, *arguments):
    law.note(law, *arguments)


@njit(**FORMULA)
def _entropy(law, *arguments):
    return law.entropy(law, *arguments)


of_layer = Formulas(
    sweep=sweep,
    look=_look,
    speeds=_speeds,
    save=_save,
    end=_end,
    note=_note,
    end_forces=end_forces,
    entropy=_entropy,
)
of_interface = Formulas(couple=couple, residuals=residuals)


def number_laws(layers: np.ndarray, faces: np.ndarray) -> None:
    """Note the numbers of the laws in the records of a plan."""
    layers["law"] = layers["kind"]
    faces["pair"] = 0
