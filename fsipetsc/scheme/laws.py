"""The physics of the layers of a problem, and what the scheme does with each of them.

A law is the formulas of a physics (fsipetsc.physics.fluid, .solid) and the work of the scheme on its kind of layer; a pair is
the laws of gas and solid that meet at an interface. Compiled functions find that of a layer by its number among LAWS,
``with_chosen(of_layer.sweep, LAWS, layer.law, layer, ...)``, and that of an interface by its number among PAIRS.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from fsipetsc.coupling import couple, residuals
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.variants import Variants, digest
from fsipetsc.physics import dissipation
from fsipetsc.physics.constant_transport import constant_transport
from fsipetsc.physics.fluid import Fluid, navier_stokes
from fsipetsc.physics.gruneisen import gruneisen
from fsipetsc.physics.layer import FLUID, SOLID
from fsipetsc.physics.material_law import formulas_of
from fsipetsc.physics.narrow import NARROW_GAS, NARROW_SOLID
from fsipetsc.physics.own_laws import check
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.physics.solid import Solid, elastic_solid
from fsipetsc.physics.two_point import entropy_conserving
from fsipetsc.problem import Problem
from fsipetsc.scheme.end_forces_and_entropy import end_forces, gas_entropy, gas_traction, solid_entropy, solid_traction
from fsipetsc.scheme.end_rates import end_flux, end_slopes, gas_end, solid_end
from fsipetsc.scheme.extremes_and_sums import fluid_extremes_and_sums, solid_extremes_and_sums
from fsipetsc.scheme.kinetic import keep_energy, leave_energy
from fsipetsc.scheme.layer_ends import close_end, close_gas, note_embedded, note_nothing
from fsipetsc.scheme.layer_fields import fluid_fields, solid_fields
from fsipetsc.scheme.speeds import fluid_speeds, solid_speeds
from fsipetsc.scheme.sweep import sweep
from fsipetsc.scheme.two_point import add_pairs, flux_through_end, slopes_at_end
from fsipetsc.scheme.undivided import add_undivided, nothing

#: by kind of layer: what the scheme does with it
_WORK = {
    FLUID: {
        "look": fluid_extremes_and_sums,
        "speeds": fluid_speeds,
        "save": fluid_fields,
        "amend": gas_end,
        "end_flux": end_flux,
        "end_slopes": end_slopes,
        "end": close_gas,
        "note": note_embedded,
        "traction": gas_traction,
        "entropy": gas_entropy,
    },
    SOLID: {
        "look": solid_extremes_and_sums,
        "speeds": solid_speeds,
        "save": solid_fields,
        "amend": solid_end,
        "end": close_end,
        "note": note_nothing,
        "traction": solid_traction,
        "entropy": solid_entropy,
    },
}


def law(physics: Formulas, settle: Any = leave_energy) -> Formulas:
    """A physics with the work of the scheme on its kind of layer."""
    work = {"add": add_undivided if physics.undivided else nothing, "settle": settle, **_WORK[physics.kind]}
    if hasattr(physics, "pair_flux"):
        work |= {"add": add_pairs, "end_flux": flux_through_end, "end_slopes": slopes_at_end}
    return Formulas(**vars(physics), **work)


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


@dataclass(frozen=True)
class Form:
    """Which form of the equations is discretised: the options of these names.

    narrow: second derivatives; dissipation, shocks: how strong, 0 for none; entropy: convection in two-point form.
    """

    narrow: bool = False
    dissipation: float = 0.0
    shocks: float = 0.0
    entropy: bool = False


#: D twice, nothing added
PLAIN = Form()


class ProblemLaws:
    """The laws of a problem: those in LAWS and PAIRS, or others, with which compiled functions are compiled once more.

    layers, pairs: formulas, each once; of_layers, of_interfaces: their numbers, layer by layer, interface by interface.
    entropy: whether it is to be computed; form: of the equations. InputError for a law of the user's that is not what it
    must be.
    """

    def __init__(self, problem: Problem, entropy: bool = False, form: Form = PLAIN) -> None:
        found = [_law_of(layer.material, form) for layer in problem.layers]
        wanting = ["-fsi_entropy and -fsi_check need"] * entropy + ["-fsi_dissipation needs"] * (form.dissipation > 0)
        for layer, known in zip(problem.layers, found, strict=True):
            if wanting and not getattr(getattr(known, "gas", None), "knows_entropy", True):
                what = f"no formula entropy(c, rho, T), which {wanting[-1]}"
                raise InputError(f"the gas law of layer '{layer.name}' has {what}")
            if form.entropy and getattr(known, "gas", perfect_gas) is not perfect_gas:
                what = "the two-point form of convection is that of a perfect gas: take -fsi_convection divergence"
                raise InputError(f"layer '{layer.name}' has a gas law of its own, and {what}")
        names = {digest(law): law for law in found}
        # the same laws in another order are no others
        names = dict(sorted(names.items(), key=lambda item: (item[1].kind, item[0])))
        if names.keys() <= _BUILT_IN.keys():
            names = _BUILT_IN
        self.layers, numbers = tuple(names.values()), {name: k for k, name in enumerate(names)}
        self.of_layers = [numbers[digest(law)] for law in found]
        met = [(self.of_layers[fluid], self.of_layers[solid]) for fluid, solid in problem.interfaces]
        known = sorted(set(met))
        self.of_interfaces = [known.index(numbers) for numbers in met]
        # compiled functions name a pair also where no interface will ever ask for it: a single layer
        self.pairs = tuple(pair(self.layers[fluid], self.layers[solid]) for fluid, solid in known) or PAIRS
        self._variants = None
        if names is not _BUILT_IN:
            name = "laws-" + digest((tuple(names), tuple(known)))
            if name not in _VARIANTS:
                if not Variants.on_disk(name):
                    _check(found, form)
                _VARIANTS[name] = Variants(((LAWS, self.layers), (PAIRS, self.pairs)), name)
            self._variants = _VARIANTS[name]

    def compiled(self, function: Any) -> Any:
        """A compiled function, for these laws."""
        return self._variants.of(function) if self._variants else function

    def number(self, layers: np.ndarray, faces: np.ndarray) -> None:
        """Note the numbers of the laws in the records of a plan."""
        layers["law"], faces["pair"] = self.of_layers, self.of_interfaces


def _check(laws: list[Formulas], form: Form) -> None:
    """InputError for formulas that cannot be compiled."""
    for law in laws:
        for kind in ("gas", "transport", "pressing"):
            if getattr(getattr(law, kind, None), "own", False):
                check(getattr(law, kind), kind, dissipation.IN_LOOPS if form.dissipation > 0.0 and kind == "gas" else ())


def _law_of(material: Fluid | Solid, form: Form) -> Formulas:
    """That of a layer of this material."""
    is_gas, shocks = isinstance(material, Fluid), form.shocks > 0.0
    terms = (NARROW_GAS if is_gas else NARROW_SOLID) if form.narrow else ()
    if shocks:
        terms += (dissipation.GAS_SHOCKS if is_gas else dissipation.SOLID_SHOCKS,)
    if form.dissipation > 0.0:
        terms += ((dissipation.GAS_DISSIPATION if is_gas else dissipation.SOLID_DISSIPATION)[shocks],)
    if is_gas:
        gas, transport = formulas_of(material.law), formulas_of(material.transport)
        physics = navier_stokes(gas, transport, terms, material.force != 0.0)
        return law(entropy_conserving(physics) if form.entropy else physics)
    dissipates = shocks or form.dissipation > 0.0
    return law(elastic_solid(formulas_of(material.pressing), terms), keep_energy if dissipates else leave_energy)


#: digest -> law, of those in LAWS; name of a set of laws -> what has been compiled for it
_BUILT_IN = {digest(law): law for law in LAWS}
_VARIANTS: dict[str, Variants] = {}
