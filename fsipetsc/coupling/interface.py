"""What every interface treatment is given and gives back.

The *traces* of an interface are the rows of both sides that an interface condition can reach, counted from the
interface into each material: ``trace_f[j] = (rho, rho u, e)_j`` and ``trace_s[j] = (u, sigma, T, x)_j`` for
j = 0 .. rows-1; ``conservative`` takes J (rho, rho u, e) and a fifth column: see there. A treatment is a compiled function

    treatment(pair, face, op, trace_f, trace_s)

with the laws of the pair of materials (fsipetsc.scheme.laws.pair), that changes both in place so that the conditions
(2.6)-(2.8b) hold up to the prescribed jumps; every rank computes it from the same numbers. The viscosity and the
conductivity of the gas are those at its temperature in row 0.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, row_length
from fsipetsc.physics.layer import NUMBERS

_I, _F = np.int64, np.float64
INTERFACE = np.dtype(
    [
        ("fluid", _I),  # layer numbers
        ("solid", _I),
        ("pair", _I),  # number among the pairs of laws of the problem, see fsipetsc.scheme.laws
        ("coupling", _I),  # a kind of fsipetsc.coupling
        ("normal", _F),  # +1 if the fluid lies right of the solid, -1 if left
        ("h", _F),  # of the solid
        ("h_gas", _F),  # of the gas's grid at rest; now
        ("J", _F),  # the distance of its points is J times as much,
        ("spacing", _F),  # this,
        ("ratio", _F),  # and over that of the solid's points this
        ("gamma", _F),
        ("R", _F),
        ("cv", _F),
        ("mu", _F),  # 4/3 mu
        ("kappa", _F),
        ("gas_numbers", _F, (NUMBERS,)),
        ("transport_numbers", _F, (NUMBERS,)),
        ("K", _F),
        ("kappa_e", _F),
        ("m0", _F),
        ("alpha", _F),
        ("gruneisen", _F),
        ("pressing_numbers", _F, (NUMBERS,)),
        # prescribed jumps: us-uf, sigma-p+pf-mu' u_X, Ts-Tf, kappa_e/x_X Ts_X - kappa Tf_X
        ("jump", _F, (4,)),
    ],
    align=True,
)
#: positions in INTERFACE["jump"]
JUMP_U, JUMP_STRESS, JUMP_T, JUMP_FLUX = 0, 1, 2, 3


@njit(**OPTIONS)
def closure_derivative(op, row, column, scale):
    """scale * sum_j beta_j row[j, column]: h times the one-sided derivative at the interface."""
    s = 0.0
    for j in range(row_length(op)):
        s += op.closure[0, j] * row[j, column]
    return scale * s


@njit(**OPTIONS)
def norm_weight(op, j):
    """Weight a_j of the norm: one beyond the closure."""
    return op.norm[j] if j < op.rows else 1.0


@njit(**OPTIONS)
def gas_velocity_and_temperature(pair, face, trace_f, j):
    """(u, T) in row j."""
    rho, u = trace_f[j, 0], trace_f[j, 1] / trace_f[j, 0]
    return u, pair.gas.temperature(pair.gas.constants(face), rho, trace_f[j, 2] / rho - 0.5 * u * u)


@njit(**OPTIONS)
def gas_energy(pair, face, rho, u, T):
    """e, the energy per volume."""
    return rho * (pair.gas.energy(pair.gas.constants(face), rho, T) + 0.5 * u * u)


@njit(**OPTIONS)
def gas_pressure(pair, face, rho, T):
    """p of the gas."""
    return pair.gas.pressure(pair.gas.constants(face), rho, T)


@njit(**OPTIONS)
def viscosity(pair, face, T):
    """4/3 mu(T)."""
    return face.mu * pair.transport.relative(pair.transport.constants(face), T)[0]


@njit(**OPTIONS)
def conductivity(pair, face, T):
    """kappa(T)."""
    return face.kappa * pair.transport.relative(pair.transport.constants(face), T)[1]


@njit(**OPTIONS)
def solid_strain(face, op, trace_s):
    """x_X at the interface."""
    return closure_derivative(op, trace_s, 3, -face.normal / face.h)


@njit(**OPTIONS)
def solid_pressure(pair, face, T, x_X):
    """p of the solid at the interface."""
    return pair.pressing.pressure(pair.pressing.constants(face), T, x_X)


@njit(**OPTIONS)
def residuals(pair, face, op, trace_f, trace_s, out):
    """Residuals of the four interface conditions, in the order and with the jumps of INTERFACE["jump"]."""
    d_f, d_s = face.normal / face.spacing, -face.normal / face.h
    n = row_length(op)
    u_X, Tf_X, Tf0, uf0 = 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        u, T = gas_velocity_and_temperature(pair, face, trace_f, j)
        u_X += d_f * op.closure[0, j] * u
        Tf_X += d_f * op.closure[0, j] * T
        if j == 0:
            Tf0, uf0 = T, u
    x_X = solid_strain(face, op, trace_s)
    ps = solid_pressure(pair, face, trace_s[0, 2], x_X)
    pf = gas_pressure(pair, face, trace_f[0, 0], Tf0)
    mu, kappa = viscosity(pair, face, Tf0), conductivity(pair, face, Tf0)
    out[0] = trace_s[0, 0] - uf0 - face.jump[JUMP_U]
    out[1] = trace_s[0, 1] - ps + pf - mu * u_X - face.jump[JUMP_STRESS]
    out[2] = trace_s[0, 2] - Tf0 - face.jump[JUMP_T]
    out[3] = face.kappa_e / x_X * closure_derivative(op, trace_s, 2, d_s) - kappa * Tf_X - face.jump[JUMP_FLUX]
