"""Viscosity and conductivity as powers of the temperature: mu(T)/mu = (T/T_0)^n, kappa(T)/kappa = (T/T_0)^n_kappa.

mu and kappa are those at T_0 [K]. n = 1/2: hard spheres, n = 1: Maxwell's molecules (S. Chapman and T. G. Cowling, The
Mathematical Theory of Non-Uniform Gases); n of gases: F. M. White, Viscous Fluid Flow (1974), Tables 1-2 (mu) and 1-3 (kappa),
air: 0.67 and 0.81.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.checks import ANY, POSITIVE, number
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.physics.material_law import Law


@njit(**FORMULA)
def constants(record):
    """(1/T_0, n, n_kappa)."""
    return 1.0 / record.transport_numbers[0], record.transport_numbers[1], record.transport_numbers[2]


@njit(**FORMULA)
def alike(c, T):
    """(mu(T)/mu, kappa(T)/kappa) where both have the same n: one power, which is what takes the time."""
    power = (T * c[0]) ** c[1]
    return power, power


@njit(**FORMULA)
def apart(c, T):
    """The same for two exponents."""
    return (T * c[0]) ** c[1], (T * c[0]) ** c[2]


_alike, _apart = Formulas(constants=constants, relative=alike), Formulas(constants=constants, relative=apart)


def power_law(T_0: float, n: float, n_kappa: float | None = None) -> Law:
    """The law for the transport of a Fluid whose mu and kappa are those at T_0 [K]; without n_kappa, kappa goes with n, too.

    InputError for what is no number or out of range.
    """
    ranges = {"T_0": (T_0, POSITIVE), "n": (n, ANY), "n_kappa": (n if n_kappa is None else n_kappa, ANY)}
    numbers = tuple(number(value, f"power_law: {name}", at) for name, (value, at) in ranges.items())
    return Law(_alike if numbers[1] == numbers[2] else _apart, numbers)
