"""The same gas with convection in two-point form, which conserves entropy, and friction and conduction that produce it.

    (J U)_i,t  =  -2 sum_l D_il F(i, l)  -  D (viscous flux)

    F = m (1, {u}, u_i u_l / 2 + c_v T^) + (0, {p}, (p_i u_l + p_l u_i) / 2),       m = rho^ ({u} - {w})

{a} is the mean of a_i and a_l, rho^ the logarithmic mean of the densities, 1/T^ that of 1/T (fsipetsc.operators.means), w the
velocity of the grid. F is consistent with the flux and symmetric, so that what D conserves is conserved as by D of the flux.
With the entropy variables w = ((g - u^2/2)/T, u/T, -1/T) of the perfect gas, psi = R rho (u - w_grid) and R rho

    (w_i - w_l) F(i, l)  =  psi_i - psi_l  +  (terms of the motion of the grid)

so by summation by parts sum_i H_i w_i (J U)_i,t has no inner terms: the entropy of the gas changes by what goes through its
ends.
Friction and conduction take the derivatives of w, u_x = T (w2_x + u w3_x), T_x = T^2 w3_x: by these

    sum_i H_i w_i D (0, tau, u tau + kappa T_x)_i  =  ends  -  sum_i H_i (tau u_x / T + kappa T_x^2 / T^2),

and the entropy grows by the sum. (With derivatives of u and T the sign is not certain.)

Source: H. Ranocha, Dissertation, TU Braunschweig 2018, for F at rest; G. Schnuecke, N. Krais, T. Bolemann and G. J. Gassner,
J. Sci. Comput. 82 (2020), 69, for grids that move.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.means import distance, mean_factors
from fsipetsc.operators.vectors import fma
from fsipetsc.physics import fluid


@njit(**FORMULA)
def constants(law, layer):
    """Those of the fluid, c_v, mu' and kappa."""
    gas, per_J, s, apart, transport, force = fluid.constants(law, layer)
    return gas, per_J, s, apart, transport, force, layer.cv, layer.mu, layer.kappa


@njit(**FORMULA)
def prepare(law, constants, q):
    """(u, T, u/T, -1/T, 1/(J rho), 1/T, p); the third and the fourth are what the gradients see."""
    rho, m, e = q
    r = 1.0 / rho
    u = m * r
    T = law.gas.temperature_in_loops(constants[0], rho * constants[1], e * r - 0.5 * u * u)
    per_T = 1.0 / T
    return u, T, u * per_T, -1.0 * per_T, r, per_T, law.gas.pressure(constants[0], rho * constants[1], T)


@njit(**OPTIONS)
def prescribe(layer, s, v, begin, end):
    """Where a boundary wants the gradients to see other values of u and T at its ghost point, those of these."""
    for side in range(2):
        ghost = layer.lo if side == 0 else layer.hi
        if layer.end_apart[side] != 0 and begin <= ghost < end:
            u, T = layer.end_gradient[side, 0], layer.end_gradient[side, 1]
            s[U64(v[2] + ghost)], s[U64(v[3] + ghost)] = u / T, -1.0 / T


@njit(**FORMULA)
def gradients(law, layer, q, v):
    """(u/T)_x and (-1/T)_x."""
    per_spacing = 1.0 / (layer.J * layer.h)
    return (v[2], v[3]), (per_spacing, per_spacing)


@njit(**FORMULA)
def viscous_flux(law, constants, i, q, v, gradients):
    """(0, -tau, -u tau - kappa T_x)."""
    u, T = v[0], v[1]
    of_mu, of_kappa = law.transport.relative(constants[4], T)
    tau = of_mu * constants[7] * (T * fma(u, gradients[1], gradients[0]))
    conduction = of_kappa * constants[8] * (T * T * gradients[1])
    return 0.0 * tau, -1.0 * tau, fma(-1.0 * u, tau, -1.0 * conduction)


@njit(**FORMULA)
def pair_flux(constants, one, other, w):
    """F of two points: (J rho, u, T, 1/(J rho), 1/T, p) of each, mean velocity w of the grid."""
    rho, u, T, per_rho, per_T, p = one
    rho_l, u_l, T_l, per_rho_l, per_T_l, p_l = other
    of_rho, of_T = mean_factors(distance(rho, per_rho, rho_l, per_rho_l), distance(T, per_T, T_l, per_T_l))
    mean_u = 0.5 * (u + u_l)
    mass = 0.5 * constants[1] * (rho + rho_l) * of_rho * (mean_u - w)
    energy = fma(0.5 * u, u_l, 0.5 * constants[6] * (T + T_l) * of_T)
    return mass, fma(mass, mean_u, 0.5 * (p + p_l)), fma(mass, energy, 0.5 * fma(p, u_l, p_l * u))


@njit(**FORMULA)
def state_rows(q, v):
    """Where the rows are that ``pair_flux`` takes."""
    return q[0], v[0], v[1], v[4], v[5], v[6]


def entropy_conserving(physics: Formulas) -> Formulas:
    """A gas of fsipetsc.physics.fluid with convection in this form; a perfect one."""
    own = dict(
        prepared=(0, 1, 14, 15, 16, 17, 18),
        constants=constants,
        prepare=prepare,
        prescribe=prescribe,
        first=gradients,
        flux=viscous_flux,
        pair_flux=pair_flux,
        state_rows=state_rows,
        flux_of_pairs=(3, 4, 5),
        sums_of_pairs=(6, 7, 8),
    )
    return Formulas(**{**vars(physics), **own})
