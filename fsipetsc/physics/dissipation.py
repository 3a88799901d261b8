"""Dissipation: terms of undivided differences for the rates, see fsipetsc.scheme.undivided.

Of order q, half the order of D, everywhere (-fsi_dissipation, times 0.3: sigma):

    (J U)_t  -=  H^-1 Delta_q^T  sigma/4^q lambda U_w  Delta_q w,       lambda = |u - w_grid| + c

in a gas: U = (rho, rho u, e), w = ((g - u^2/2)/T, u/T, -1/T), g = e + p/rho - T S: the derivatives of -rho S by U; U_w = dU/dw
at the mean rho, u/T and 1/T of the points in the middle. In these lines e is the energy per mass. For any gas law,

    drho = (rho^2 T / K_T) (dw1 + u dw2 + (h + u^2/2) dw3),   K_T = rho p_rho,   h = e + (p - T p_T)/rho
    rho du = rho T (dw2 + u dw3),     rho c_v dT = rho c_v T^2 dw3
    d(rho u) = u drho + rho du,       d(rho e + rho u^2/2) = (h + u^2/2) drho + u rho du + rho c_v dT

so U_w is a sum of three squares: positive definite where rho, T, c_v and K_T are positive, and the entropy of the gas grows by
sum sigma/4^q lambda (Delta_q w) U_w (Delta_q w) >= 0. The mean of 1/T, not of T: at a jump of T it is that of the cold
side, and U_w Delta w stays near Delta U there, where with the hot side's it would be a multiple of it and stiff.

Of order 1, where fsipetsc.operators.sensor finds a shock (-fsi_shock S):

    (J U)_t  -=  H^-1 Delta_1^T  S/2 alpha max(lambda)  Delta_1 U

As -rho S is convex, (Delta w) (Delta U) >= 0 for any two states of any gas law: Delta U is U_w Delta w for the mean of U_w
on the way from one to the other. So the entropy grows whatever alpha >= 0 is, and with S = 1 it is the dissipation of Lax and
Friedrichs, of the faster one of the two points. The one of order q, which is not monotone, is then multiplied with 1 - alpha,
the least of all pairs of points that the difference takes.

In a solid, on the velocity, Z = sqrt(K m0 / x_X), what the flow loses going into heat at the points in the middle of the
difference:

    m0 u_t        -=  H^-1 Delta_q^T  sigma/4^q Z  Delta_q u
    alpha m0 T_t  +=  H^-1 M_q^T      sigma/4^q Z (Delta_q u)^2

and at a shock, of the stress, with q = 1, 0.7 S alpha for sigma/4^q and the larger Z. sum_i H_i m0 (u^2/2 + alpha T) stays.

Columns of Delta add up to nothing: mass, momentum and energy hold as without. Next to the ends a difference counts as much as
the least weight H of its points, that of two neighbours as their geometric mean, and no more than inside: H^-1 is up to 3.9
there, and would make the terms as much stiffer. With less between neighbours a shock that is reflected leaves wiggles there.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.differences import DIFFERENCE, MIDDLE
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA, OPTIONS, ROW
from fsipetsc.operators.memory import load, store
from fsipetsc.operators.sensor import largest_within, sense, weigh_ends
from fsipetsc.operators.vectors import LANES, fma, magnitude, maximum, numbers_from, root, spread
from fsipetsc.physics import fluid

#: usual sigma
SIGMA = 0.3
#: formulas of a gas law that are called with vectors of points here
IN_LOOPS = ("energy", "entropy", "heat_capacity", "pressure_by_temperature", "bulk_modulus")
#: free rows, as numbers of fsipetsc.scheme.undivided: how steep the rows are; alpha, which stays for a term that follows
_STEEPNESS, _ALPHA = 6, 7
#: 0.5 would be what a gas has; as the stress is not damped, more is wanted, and 1 is too stiff at Courant number 0.8
SOLID_SHARE = 0.7
#: of K, the stress below which no jump is looked for in a solid
_LEAST_STRAIN = 1e-10


@njit(**FORMULA)
def of_half_order(op):
    """The difference of order q."""
    return op.dissipation


@njit(**FORMULA)
def of_first_order(op):
    """That of order 1."""
    return op.shocks


@njit(**FORMULA)
def half_width(op):
    """Reach of a difference of order q."""
    return op.p


@njit(**FORMULA)
def twice_half_width(op):
    """Reach of the sensor."""
    return 2 * op.p


@njit(**FORMULA)
def fastest(law, constants, i, q, v):
    """lambda."""
    gas, per_J, s, apart = constants[0], constants[1], constants[2], constants[3]
    u, r = v[0], 1.0 / q[0]
    internal = q[2] * r - 0.5 * u * u
    c = root(law.gas.sound_speed_squared_of_energy(gas, q[0] * per_J, internal))
    return magnitude(u - fma(apart, numbers_from(i), s)) + c


# of order q in a gas


@njit(**FORMULA)
def entropy_variables(law, constants, i, q, v, f):
    """(lambda, w1, w2, w3)."""
    gas, u, T = constants[0], v[0], v[1]
    rho, per_T = q[0] * constants[1], 1.0 / T
    enthalpy = law.gas.energy(gas, rho, T) + law.gas.pressure(gas, rho, T) / rho
    w1 = (enthalpy - 0.5 * u * u) * per_T - law.gas.entropy(gas, rho, T)
    return fastest(law, constants, i, q, v), w1, u * per_T, -1.0 * per_T


@njit(**FORMULA)
def mean_state(q, c):
    """(J rho, J rho u, lambda, w2, w3)."""
    return q[0], c[2], c[3], c[0]


@njit(**FORMULA)
def variables(q, v, c):
    """w."""
    return c[1], c[2], c[3]


@njit(**FORMULA)
def increments(law, constants, means, own, differences):
    """lambda U_w Delta w, times what the ends and shocks leave of it."""
    gas, (mass, w2, w3, speed), (d1, d2, d3) = constants[0], means, differences
    rate = speed * own[0]
    rho, T = mass * constants[1], -1.0 / w3
    u, k = w2 * T, law.gas.bulk_modulus(gas, rho, T)
    p, p_T = law.gas.pressure(gas, rho, T), law.gas.pressure_by_temperature(gas, rho, T)
    h = law.gas.energy(gas, rho, T) + (p - T * p_T) / rho + 0.5 * u * u
    of_rho = rate * rho * T * (rho / k) * fma(h, d3, fma(u, d2, d1))
    of_u = rate * rho * T * fma(u, d3, d2)
    of_T = rate * rho * law.gas.heat_capacity(gas, rho, T) * (T * T) * d3
    return of_rho, fma(u, of_rho, of_u), fma(h, of_rho, fma(u, of_u, of_T))


@njit(**OPTIONS)
def see_ends(layer, op, s, places, i0, i1):
    """1, less at the ends."""
    limit, end = places[2][0], min(i1, layer.hi + 1 - op.p)
    for i in range(max(layer.lo, i0 - op.p), end, LANES):
        store(s, limit + i, spread(1.0))
    weigh_ends(s, limit, op.dissipation_ends, op.rows, op.p, layer.lo, layer.hi, i0, i1)


@njit(**OPTIONS)
def see_limit(layer, op, s, places, i0, i1):
    """1 - alpha, the least of those between the points of a difference, less at the ends; alpha is from the term of shocks."""
    limit, alpha = places[2][0], places[3] + _ALPHA * ROW
    begin, end = max(layer.lo, i0 - op.p), min(i1, layer.hi + 1 - op.p)
    largest_within(s, alpha, limit, op.p, begin, end)
    for i in range(begin, end, LANES):
        store(s, limit + i, 1.0 - load(s, limit + i))
    weigh_ends(s, limit, op.dissipation_ends, op.rows, op.p, layer.lo, layer.hi, i0, i1)


@njit(**OPTIONS)
def times_largest(layer, op, s, alpha, speed, to, i0, i1):
    """alpha between each two points times the larger one of their speeds, less at the ends."""
    for i in range(max(layer.lo, i0 - 1), min(i1, layer.hi), LANES):
        store(s, to + i, load(s, alpha + i) * maximum(load(s, speed + i), load(s, speed + i + 1)))
    weigh_ends(s, to, op.shock_ends, op.rows, 1, layer.lo, layer.hi, i0, i1)


@njit(**FORMULA)
def gas_scale(layer, q):
    """Of densities, times J."""
    scale = -layer.dissipation / (4.0**q * layer.h)
    return scale, scale, scale


@njit(**FORMULA)
def gas_at_wall(velocity, changes):
    """The wall gives its point the momentum, and takes up the change of it: that is work."""
    rho, m, e = changes
    return rho, m, e + velocity * (velocity * rho - m)


# of order 1 in a gas


@njit(**FORMULA)
def speed_and_pressure(law, constants, i, q, v, f):
    """(lambda, p)."""
    return fastest(law, constants, i, q, v), spread(law.gas.pressure(constants[0], q[0] * constants[1], v[1]))


@njit(**OPTIONS)
def see_shocks_of_gas(layer, op, s, places, i0, i1):
    """alpha of rho and p, and alpha max(lambda)."""
    q, c, own, free = places
    alpha = free + _ALPHA * ROW
    sense(s, layer.lo, layer.hi, op.p, q[0], c[1], 0.0, free + _STEEPNESS * ROW, alpha, i0, i1)
    times_largest(layer, op, s, alpha, c[0], own[0], i0, i1)


@njit(**FORMULA)
def no_means(q, c):
    """Differences have a number of their own alone."""
    return ()


@njit(**FORMULA)
def unknowns(q, v, c):
    """All of them."""
    return q


@njit(**FORMULA)
def jumps(law, constants, means, own, differences):
    """Each with the same factor."""
    return own[0] * differences[0], own[0] * differences[1], own[0] * differences[2]


@njit(**FORMULA)
def gas_scale_at_shocks(layer, q):
    """Of J rho and the like."""
    scale = -0.5 * layer.shocks / (layer.h * layer.J)
    return scale, scale, scale


# solid


@njit(**FORMULA)
def no_constants(law, layer):
    """None are needed."""
    return ()


@njit(**FORMULA)
def relative_impedance(law, constants, i, q, v, f):
    """Z over sqrt(K m0)."""
    return (root(f[0]),)


@njit(**FORMULA)
def mean_impedance(q, c):
    """Its mean is taken."""
    return c


@njit(**FORMULA)
def velocity(q, v, c):
    """u."""
    return (q[0],)


@njit(**FORMULA)
def friction(law, constants, means, own, differences):
    """What goes out of u and, as heat, into T, of the mean Z."""
    flux = means[0] * own[0] * differences[0]
    return flux, flux * differences[0]


@njit(**FORMULA)
def friction_at_shocks(law, constants, means, own, differences):
    """The same of the larger Z."""
    flux = own[0] * differences[0]
    return flux, flux * differences[0]


@njit(**OPTIONS)
def see_shocks_of_solid(layer, op, s, places, i0, i1):
    """alpha of sigma, and alpha max(Z)."""
    c, own, free, sigma = places[1], places[2], places[3], places[0][1]
    alpha = free + _ALPHA * ROW
    least = _LEAST_STRAIN * layer.K
    sense(s, layer.lo, layer.hi, op.p, sigma, sigma, least, free + _STEEPNESS * ROW, alpha, i0, i1)
    times_largest(layer, op, s, alpha, c[0], own[0], i0, i1)


@njit(**FORMULA)
def solid_scale(layer, q):
    """(of u, of T)."""
    flux = layer.dissipation / (4.0**q * layer.h) * (layer.K / layer.m0) ** 0.5
    return -flux, flux / layer.alpha


@njit(**FORMULA)
def solid_scale_at_shocks(layer, q):
    """The same."""
    flux = SOLID_SHARE * layer.shocks / layer.h * (layer.K / layer.m0) ** 0.5
    return -flux, flux / layer.alpha


@njit(**FORMULA)
def unchanged(velocity, changes):
    """No wall stands at a solid."""
    return changes


def gas_dissipation(limited: bool) -> Formulas:
    """The term of order q; limited: by the sensor, whose term comes before."""
    return Formulas(
        unknowns=(0, 1, 2),
        levels=of_half_order,
        coefficients=(0, 1, 2, 3),
        own=(8,),
        sums=(4, 5, 6),
        constants=fluid.constants,
        reach=half_width,
        weigh=entropy_variables,
        look=see_limit if limited else see_ends,
        averaged=mean_state,
        rows=variables,
        flux=increments,
        gather=(DIFFERENCE, DIFFERENCE, DIFFERENCE),
        scale=gas_scale,
        at_wall=gas_at_wall,
        kinetic=0,
    )


def solid_dissipation(limited: bool) -> Formulas:
    """The term of order q; limited: by the sensor, whose term comes before."""
    return Formulas(
        unknowns=(0, 2),
        levels=of_half_order,
        coefficients=(0,),
        own=(8,),
        sums=(4, 5),
        constants=no_constants,
        reach=half_width,
        weigh=relative_impedance,
        look=see_limit if limited else see_ends,
        averaged=mean_impedance,
        rows=velocity,
        flux=friction,
        gather=(DIFFERENCE, MIDDLE),
        scale=solid_scale,
        at_wall=unchanged,
        kinetic=1,
    )


GAS_SHOCKS = Formulas(
    unknowns=(0, 1, 2),
    levels=of_first_order,
    coefficients=(0, 1),
    own=(2,),
    sums=(3, 4, 5),
    constants=fluid.constants,
    reach=twice_half_width,
    weigh=speed_and_pressure,
    look=see_shocks_of_gas,
    averaged=no_means,
    rows=unknowns,
    flux=jumps,
    gather=(DIFFERENCE, DIFFERENCE, DIFFERENCE),
    scale=gas_scale_at_shocks,
    at_wall=gas_at_wall,
    kinetic=0,
)
SOLID_SHOCKS = Formulas(
    unknowns=(0, 2),
    levels=of_first_order,
    coefficients=(0,),
    own=(2,),
    sums=(3, 4),
    constants=no_constants,
    reach=half_width,
    weigh=relative_impedance,
    look=see_shocks_of_solid,
    averaged=no_means,
    rows=velocity,
    flux=friction_at_shocks,
    gather=(DIFFERENCE, MIDDLE),
    scale=solid_scale_at_shocks,
    at_wall=unchanged,
    kinetic=1,
)
#: alone, and behind the term of shocks
GAS_DISSIPATION = gas_dissipation(False), gas_dissipation(True)
SOLID_DISSIPATION = solid_dissipation(False), solid_dissipation(True)
