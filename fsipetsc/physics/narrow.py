"""What makes friction and conduction narrow: terms of undivided differences, for the rates.

D acts twice on u and T, with b = mu' and kappa between, or kappa_e / x_X in a solid. The narrow second derivative of
fsipetsc.operators.narrow is D2(b) = D b D - H^-1 R(b), R(b) = sum_q Delta_q^T mean_q(b) Delta_q, so that

    (rho u)_t  -=  H^-1 R(b) u                           h = 1
    e_t        -=  H^-1 (R(u b) u + R(kappa) T)
    alpha m0 T_t  -=  H^-1 R(kappa_e / x_X) T            (solid)

Columns of R add up to nothing: mass, momentum and total energy hold as with D twice. What the flow loses, the heat gains:
sum_i H_i (e - rho u^2/2)_t gains, with the same differences in all places,

    - sum_q sum (mean_q(u b) Delta_q 1 - mean_q(b) Delta_q u) Delta_q u  =  sum_q sum mean_q(b) (Delta_q u)^2  >=  0

as Delta_q 1 = 0: beside sum_i H_i b (D u)^2, that of D twice, and never against it, whatever the mean of u b is. The mean
of the product is what makes the formula of the energy as narrow as that of momentum.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.differences import DIFFERENCE, no_look
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.vectors import fma, spread


@njit(**FORMULA)
def narrowing(op):
    """The differences, and what their means are."""
    return op.narrowing


@njit(**FORMULA)
def reach_of_flux(op):
    """As far as what D makes is known."""
    return op.reach


@njit(**FORMULA)
def coefficients(q, c):
    """The means are of these."""
    return c


@njit(**FORMULA)
def gas_constants(law, layer):
    """(mu', kappa) of the material, and what the transport law needs."""
    return layer.mu, layer.kappa, law.transport.constants(layer)


@njit(**FORMULA)
def gas_coefficients(law, constants, i, q, v, f):
    """(b, u b, kappa)."""
    u, T = v[0], v[1]
    of_mu, of_kappa = law.transport.relative(constants[2], T)
    b = of_mu * constants[0]
    return spread(b), u * b, spread(of_kappa * constants[1])


@njit(**FORMULA)
def velocity_and_temperature(q, v, c):
    """u and T as the gradients see them, at ghost points, too."""
    return v[0], v[1]


@njit(**FORMULA)
def gas_flux(law, constants, means, own, differences):
    """(b u_X, u b u_X + kappa T_X)."""
    b, ub, kappa = means
    return b * differences[0], fma(ub, differences[0], kappa * differences[1])


@njit(**FORMULA)
def gas_scale(layer, first):
    """Of densities, times J."""
    scale = -1.0 / (layer.h * layer.h * layer.J)
    return scale, scale


@njit(**FORMULA)
def gas_at_wall(velocity, changes):
    """The wall gives its point the momentum, and takes up this change of it: that is work."""
    m, e = changes
    return m, e - velocity * m


@njit(**FORMULA)
def solid_at_wall(velocity, changes):
    """T alone."""
    return changes


@njit(**FORMULA)
def solid_constants(law, layer):
    """kappa_e."""
    return layer.kappa_e


@njit(**FORMULA)
def solid_coefficients(law, constants, i, q, v, f):
    """(kappa_e / x_X,); the flux has 1/x_X already."""
    return (f[0] * constants,)


@njit(**FORMULA)
def temperature(q, v, c):
    """T of the solid."""
    return (q[2],)


@njit(**FORMULA)
def solid_flux(law, constants, means, own, differences):
    """(kappa_e / x_X T_X,)."""
    return (means[0] * differences[0],)


@njit(**FORMULA)
def solid_scale(layer, first):
    """Of T, for a flux of heat."""
    return (-1.0 / (layer.h * layer.h * layer.alpha * layer.m0),)


#: for ``undivided`` of the two physics, see fsipetsc.scheme.undivided
NARROW_GAS = (
    Formulas(
        unknowns=(1, 2),
        levels=narrowing,
        coefficients=(0, 1, 2),
        sums=(3, 4),
        own=(),
        constants=gas_constants,
        reach=reach_of_flux,
        weigh=gas_coefficients,
        look=no_look,
        averaged=coefficients,
        rows=velocity_and_temperature,
        flux=gas_flux,
        scale=gas_scale,
        gather=(DIFFERENCE, DIFFERENCE),
        at_wall=gas_at_wall,
        kinetic=0,
    ),
)
NARROW_SOLID = (
    Formulas(
        unknowns=(2,),
        levels=narrowing,
        coefficients=(0,),
        sums=(3,),
        own=(),
        constants=solid_constants,
        reach=reach_of_flux,
        weigh=solid_coefficients,
        look=no_look,
        averaged=coefficients,
        rows=temperature,
        flux=solid_flux,
        scale=solid_scale,
        gather=(DIFFERENCE,),
        at_wall=solid_at_wall,
        kinetic=0,
    ),
)
