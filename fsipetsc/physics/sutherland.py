"""Sutherland's law of viscosity and conductivity: molecules that attract each other.

    mu(T)/mu = (T/T_0)^(3/2) (T_0 + S)/(T + S),        kappa(T)/kappa the same with an S of its own

with mu and kappa those at T_0 [K]. W. Sutherland, Philosophical Magazine 36 (1893) 507; S [K] of gases: F. M. White, Viscous
Fluid Flow (1974), Tables 1-2 (mu) and 1-3 (kappa), air: T_0 = 273, S = 111 and 194.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.checks import NONNEGATIVE, POSITIVE, number
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.physics.material_law import Law


@njit(**FORMULA)
def constants(record):
    """(1/T_0, S and T_0 + S of mu, the same of kappa)."""
    T_0, S, S_kappa = record.transport_numbers[0], record.transport_numbers[1], record.transport_numbers[2]
    return 1.0 / T_0, S, T_0 + S, S_kappa, T_0 + S_kappa


@njit(**FORMULA)
def relative(c, T):
    """(mu(T)/mu, kappa(T)/kappa)."""
    ratio = T * c[0]
    power = ratio * np.sqrt(ratio)
    return power * (c[2] / (T + c[1])), power * (c[4] / (T + c[3]))


_formulas = Formulas(constants=constants, relative=relative)


def sutherland(T_0: float, S: float, S_kappa: float | None = None) -> Law:
    """The law for the transport of a Fluid whose mu and kappa are those at T_0 [K]; S, S_kappa: [K], without S_kappa S.

    InputError for what is no number or out of range.
    """
    ranges = {"T_0": (T_0, POSITIVE), "S": (S, NONNEGATIVE), "S_kappa": (S if S_kappa is None else S_kappa, NONNEGATIVE)}
    return Law(_formulas, tuple(number(value, f"sutherland: {name}", at) for name, (value, at) in ranges.items()))
