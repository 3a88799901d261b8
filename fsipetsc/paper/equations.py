"""The equations of the paper at a point.

Gas, (4.20): compressible Navier-Stokes in a rigid frame that moves with the velocity s(t) of the
gas's interface point, X = x - x_I(t) + X_I, mu' = 4 mu / 3, e = rho (internal energy + u^2/2):

    rho_t     + (rho (u-s))_X                                            = 0
    (rho u)_t + (rho u (u-s) + p - mu' u_X)_X                            = rho force
    e_t       + (e (u-s) + u (p - mu' u_X) - kappa T_X)_X                = rho u force

Friction and conduction stand inside the outer derivative, so that D is applied twice and mu and
kappa may vary.

Solid, (4.19): Lagrangian, sigma an unknown beside the pressure p(epsilon, rho), epsilon = alpha T,
rho = m0 / x_X:

    u_t          = (sigma - p)_X / m0 + force         (T: the paper's row is misprinted, see (3.1c))
    sigma_t      = K / x_X u_X
    alpha m0 T_t = (sigma - p) u_X + (kappa_e / x_X T_X)_X
    x_t          = u
"""

from __future__ import annotations

from numba.extending import register_jitable


@register_jitable
def gas_flux(gas, s, rho, m, e, u, T, u_X, T_X):
    """(rho (u-s), rho u (u-s) + p - mu' u_X, e (u-s) + u (p - mu' u_X) - kappa T_X)."""
    relative, pressing = u - s, gas.law.pressure(rho, T) - gas.viscosity(T) * u_X
    return (
        rho * relative,
        m * relative + pressing,
        e * relative + u * pressing - gas.conductivity(T) * T_X,
    )


@register_jitable
def solid_flux(solid, sigma, T, x_X, T_X):
    """(1/x_X, sigma - p, kappa_e/x_X T_X)."""
    stretch = 1.0 / x_X
    return stretch, sigma - solid.pressure(T, x_X), solid.kappa_e * stretch * T_X


@register_jitable
def solid_rates(solid, u, stretch, net, u_X, net_X, conducted_X):
    """(u, sigma, T, x)_t; net: sigma - p, conducted: kappa_e/x_X T_X."""
    T_t = (net * u_X + conducted_X) / (solid.alpha * solid.m0)
    return net_X / solid.m0 + solid.force, solid.K * stretch * u_X, T_t, u
