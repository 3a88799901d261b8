"""Materials of the classes for layers as those for blocks; goes away with fsipetsc.physics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.power_law import PowerLaw
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.solid_pressure import Gruneisen, MieGruneisen, StiffenedPressure
from fsipetsc.materials.sutherland import Sutherland
from fsipetsc.paper.laws import law_of
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


class GasLaw(NamedTuple):
    """A gas law of a case in one dimension, fsipetsc.physics.own_laws, under the names of blocks."""

    law: Any

    def pressure(self, rho, T):
        """p [Pa]."""
        return self.law.pressure(rho, T)

    def internal_energy(self, rho, T):
        """e [J/kg]."""
        return self.law.energy(rho, T)

    def energy_density(self, rho, T):
        """rho e [J/m3]."""
        return rho * self.law.energy(rho, T)

    def temperature(self, rho, e):
        """T [K]."""
        return self.law.temperature(rho, e)

    def density(self, p, T):
        """rho [kg/m3]."""
        return self.law.density(p, T)

    def temperature_of(self, rho, p):
        """T [K] of a pressure."""
        return self.law.temperature_of_pressure(rho, p)

    def heat_capacity(self, rho, T):
        """de/dT [J/(kg K)]."""
        return self.law.heat_capacity(rho, T)

    def sound_speed_squared(self, rho, T):
        """c^2 [m2/s2]."""
        return self.law.sound_speed_squared(rho, T)

    def entropy(self, rho, T):
        """s [J/(kg K)]."""
        return self.law.entropy(rho, T)

    def bulk_modulus(self, rho, T):
        """rho dp/drho at constant T [Pa]."""
        return self.law.bulk_modulus(rho, T)

    def pressure_by_temperature(self, rho, T):
        """dp/dT at constant rho [Pa/K]."""
        return self.law.pressure_by_temperature(rho, T)


class TransportLaw(NamedTuple):
    """The same of mu and kappa relative to those of the material."""

    law: Any

    def viscosity(self, T):
        """mu(T)/mu."""
        return self.law.relative(T)[0]

    def conductivity(self, T):
        """kappa(T)/kappa."""
        return self.law.relative(T)[1]


class PressureLaw(NamedTuple):
    """The same of the pressure of a solid."""

    law: Any

    def pressure(self, J, T, m0, alpha):
        """p [Pa]."""
        return self.law.pressure(T, J)


def gas_of(material: Any, force: Sequence[float]) -> Fluid:
    """A gas under a body force per mass [m/s2]. InputError for a law that cannot be compiled."""
    if isinstance(material, Fluid):
        own = tuple(force) if any(force) else material.force
        return replace(material, force=own)
    numbers = material.mu, material.kappa, material.gamma, material.R
    law = _law(material.law, GasLaw, material, "gas")
    transport = _law(material.transport, TransportLaw, material, "transport")
    return Fluid(*numbers, law, transport, tuple(force) if any(force) else 0.0)


def line_solid_of(material: Any, p_ref: float) -> ElasticSolid:
    """A solid in one dimension, whose stress is K ln x_X - p_ref less its pressure. InputError."""
    pressure = _law(material.pressing, PressureLaw, material, "pressing")
    if pressure is None and material.gruneisen > 0.0:
        pressure = Gruneisen(material.gruneisen)
    numbers = material.kappa_e, material.m0, material.alpha, p_ref
    return ElasticSolid(0.0, material.K, *numbers, force=material.force, pressing=pressure)


def _law(law: Any, kind: type, material: Any, name: str) -> Any:
    """A law for blocks, None for the usual one; one of a case becomes one of this kind."""
    if isinstance(law, tuple):
        return law
    for known, now in _LAWS:
        if formulas_of(law) is known:
            count = len(now._fields) if now else 0
            return now(*law.numbers[:count]) if isinstance(law, Law) and now else None
    return kind(law_of(law, material, name))
