"""Names of the formulas of laws, which compiled code calls as methods.

A law is a NamedTuple of its numbers with these methods. They are scalar formulas of +, -, *, /, **,
min, max, abs, numpy's sqrt and log of fsipetsc.equations.logarithm, without an ``if`` on their
arguments. Other functions of numpy work as well, but loops with them are slower.
"""

from __future__ import annotations

#: of a gas: name -> arguments; rho [kg/m3], T [K], e [J/kg], p [Pa]
GAS_LAW = {
    "pressure": "rho, T",
    "internal_energy": "rho, T",
    "energy_density": "rho, T",
    "temperature": "rho, e",
    "density": "p, T",
    "temperature_of": "rho, p",
    "heat_capacity": "rho, T",
    "sound_speed_squared": "rho, T",
    "entropy": "rho, T",
    "bulk_modulus": "rho, T",
    "pressure_by_temperature": "rho, T",
}
#: of viscosity and conductivity relative to those of the material
TRANSPORT_LAW = {"viscosity": "T", "conductivity": "T"}
#: of a solid; F: the deformation gradient, d*d numbers row by row
SOLID_LAW = {"stress": "F", "energy": "F", "wave_modulus": "F"}
#: of the pressure of a solid; J: det F, m0: density at rest, alpha: specific heat
SOLID_PRESSURE = {
    "pressure": "J, T, m0, alpha",
    "pressure_by_temperature": "J, T, m0, alpha",
    "stiffness": "J, T, m0, alpha",
}
