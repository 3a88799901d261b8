"""Materials of the classes for layers as those for blocks; goes away with fsipetsc.physics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from fsipetsc.checks import described
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.power_law import PowerLaw
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.solid_pressure import Gruneisen, MieGruneisen, StiffenedPressure
from fsipetsc.materials.sutherland import Sutherland
from fsipetsc.physics import (
    constant_transport,
    gruneisen,
    mie_gruneisen,
    perfect_gas,
    power_law,
    stiffened_gas,
    sutherland,
)
from fsipetsc.physics.material_law import Law, formulas_of

#: formulas of the old classes, and what they are now: a class of the numbers, None for the usual
_LAWS = [
    (perfect_gas.perfect_gas, None),
    (constant_transport.constant_transport, None),
    (gruneisen.gruneisen, None),
    (sutherland._formulas, Sutherland),
    (power_law._alike, PowerLaw),
    (power_law._apart, PowerLaw),
    (mie_gruneisen._formulas, MieGruneisen),
    (stiffened_gas._formulas, StiffenedPressure),
]


def gas_of(material: Any, force: Sequence[float]) -> Fluid:
    """A gas under a body force per mass [m/s2]. InputError for a law of a case."""
    if isinstance(material, Fluid):
        own = tuple(force) if any(force) else material.force
        return replace(material, force=own)
    numbers = material.mu, material.kappa, material.gamma, material.R
    own = tuple(force) if any(force) else 0.0
    return Fluid(*numbers, _law(material.law), _law(material.transport), own)


def line_solid_of(material: Any, p_ref: float) -> ElasticSolid:
    """A solid in one dimension, whose stress is K ln x_X - p_ref less its pressure. InputError."""
    pressure = _law(material.pressing)
    if pressure is None and material.gruneisen > 0.0:
        pressure = Gruneisen(material.gruneisen)
    numbers = material.kappa_e, material.m0, material.alpha, p_ref
    return ElasticSolid(0.0, material.K, *numbers, force=material.force, pressing=pressure)


def _law(law: Any) -> Any:
    """A law of those that there are. InputError for another one."""
    if isinstance(law, tuple):
        return law
    for known, now in _LAWS:
        if formulas_of(law) is known:
            count = len(now._fields) if now else 0
            return now(*law.numbers[:count]) if isinstance(law, Law) and now else None
    raise InputError(f"law is {described(law)}: expected one of fsipetsc.materials, or of its own")
