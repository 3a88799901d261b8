"""Names of the formulas of laws, which compiled code may call as methods."""

from __future__ import annotations

from fsipetsc.operators.loops import formulas

#: of a gas: name -> arguments
GAS_LAW = {
    "pressure": "rho, T",
    "internal_energy": "rho, T",
    "energy_density": "rho, T",
    "temperature": "rho, e",
    "density": "p, T",
    "heat_capacity": "rho, T",
    "sound_speed_squared": "rho, T",
    "entropy": "rho, T",
    "bulk_modulus": "rho, T",
    "pressure_by_temperature": "rho, T",
}
#: of viscosity and conductivity relative to those of the material
TRANSPORT_LAW = {"viscosity": "T", "conductivity": "T"}
#: of a solid; F: the deformation gradient, d*d numbers
SOLID_LAW = {"stress": "F", "energy": "F", "wave_modulus": "F"}

formulas(*GAS_LAW, *TRANSPORT_LAW, *SOLID_LAW)
