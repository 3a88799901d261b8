"""Dissipation in two dimensions: undivided differences, in each direction k along its line of points. Point formulas.

    (J U)_t  -=  H^-1 Delta_q^T  s lambda U_w  Delta_q w,    lambda = |Ja^k . u - g^k| + c |Ja^k|

in a gas, w its four entropy variables ((h - |u|^2/2)/T - S, u/T, v/T, -1/T), h = e + p/rho, U_w = dU/dw at the mean rho,
u/T and 1/T of the points in the middle. As in fsipetsc.physics.dissipation, with H = e + (p - T p_T)/rho + |u|^2/2,

    drho       = (rho^2 T / K_T) (dw1 + u dw2 + v dw3 + H dw4),     rho du = rho T (dw2 + u dw4),  rho dv likewise,
    rho cv dT  = rho cv T^2 dw4,                                    d(rho E) = H drho + u rho du + v rho dv + rho cv dT,

a sum of squares: the entropy of the gas grows by the sum of s lambda (Delta_q w) U_w (Delta_q w). In a solid, of both
components of the velocity, Z = sqrt(K m0),

    m0 u_t        -=  H^-1 Delta_q^T  s Z  Delta_q u
    alpha m0 T_t  +=  H^-1 M_q^T      s Z |Delta_q u|^2

what the motion loses goes into heat at the points in the middle. With q half the order, s = sigma/4^q damps what the grid
does not resolve. With q = 1 and s = S/2 alpha in a gas, 0.7 S alpha in a solid, it is that of shocks. The one of order q, which
is not monotone, is then multiplied with 1 - alpha, the least of all pairs of points that the difference takes. Between two

    alpha = min(1, max(0, 2.5 (s - 0.03))),   s = |d_+ - d_-| / (|d_+| + |d_-| + e),   d_+ = a_j+1 - a_j,  d_- = a_j - a_j-1

the larger s of the two, of a = rho and p in a gas, with e = 0.05 (a_j+1 + 2 a_j + a_j-1), and of both components of the
velocity in a solid, with e = 0.02 sqrt(K/m0): nothing changes for one who moves along. In smooth flow s falls with h^2, and
alpha is 0 as soon as s is below 0.03. An end point has no s of its own. The form is that of fsipetsc.operators.sensor.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.sensor import SMALL
from fsipetsc.operators.vectors import fma, magnitude, maximum, minimum, root
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane import gas, two_point
from fsipetsc.physics.plane.solid import rate

#: s up to which there is no shock, and how fast alpha rises from there
NO_SHOCK, RISE = 0.03, 2.5
#: e of a solid, over the speed of sound
SMALL_IN_SOLID = 0.02
#: what goes to the points by the weights of the difference, and what to those in its middle
DIFFERENCE, MIDDLE = 0, 1


@njit(**FORMULA)
def first_variable(law, c, point):
    """w1 at (rho, u, v, e, p, T), e per volume."""
    rho, u, v, e, p, T = point
    return ((e + p) / rho - fma(u, u, v * v)) / T - law.gas.entropy(c[0], rho, T)


@njit(**FORMULA)
def prepare_pairs(law, c, q):
    """What ``two_point.prepare_viscous`` has, and w1."""
    found = two_point.prepare_viscous(law, c, q)
    return (*found, first_variable(law, c, (found[0], found[1], found[2], found[3], found[4], found[6])))


@njit(**FORMULA)
def prepare_fluxes(law, c, q):
    """What ``gas.prepare_viscous`` has, and w1."""
    found = gas.prepare_viscous(law, c, q)
    return (*found, first_variable(law, c, (found[0], found[1], found[2], found[3], found[4], found[9])))


@njit(**FORMULA)
def gas_rate(law, c, v, divergence, extra, sums):
    """That of fsipetsc.physics.plane.gas, and the sums."""
    J, mass, x, y, e = gas.rate(law, c, v, divergence, (extra[-1],), sums)
    return J, mass + sums[0], x + sums[1], y + sums[2], e + sums[3]


@njit(**FORMULA)
def of_gas(law, c, mean, differences, m, strength):
    """s lambda U_w Delta w; mean: (rho, u/T, v/T, -1/T), m: (Ja_x, Ja_y, -g)."""
    rho, w2, w3, w4 = mean
    d1, d2, d3, d4 = differences
    T = -1.0 / w4
    u, v = w2 * T, w3 * T
    normal = fma(m[0], u, fma(m[1], v, m[2]))
    internal, p = law.gas.energy(c[0], rho, T), law.gas.pressure(c[0], rho, T)
    sound = law.gas.sound_speed_squared_of_energy(c[0], rho, internal)
    speed = strength * (magnitude(normal) + root(sound * fma(m[0], m[0], m[1] * m[1])))
    H = fma(0.5, fma(u, u, v * v), internal + (p - T * law.gas.pressure_by_temperature(c[0], rho, T)) / rho)
    mass = speed * rho * T * (rho / law.gas.bulk_modulus(c[0], rho, T)) * fma(H, d4, fma(v, d3, fma(u, d2, d1)))
    x, y = speed * rho * T * fma(u, d4, d2), speed * rho * T * fma(v, d4, d3)
    heat = speed * rho * law.gas.heat_capacity(c[0], rho, T) * (T * T) * d4
    return mass, fma(u, mass, x), fma(v, mass, y), fma(H, mass, fma(u, x, fma(v, y, heat)))


@njit(**FORMULA)
def alpha(s):
    """From 0 to 1."""
    return minimum(maximum(RISE * (s - NO_SHOCK), 0.0), 1.0)


@njit(**FORMULA)
def steepness(below, here, above, e):
    """s."""
    rise, fall = above - here, here - below
    return magnitude(rise - fall) / (magnitude(rise) + magnitude(fall) + e)


@njit(**FORMULA)
def steepness_of_gas(law, c, below, here, above):
    """The larger s of (rho, p), at three points in a row."""
    rho = steepness(below[0], here[0], above[0], SMALL * (below[0] + 2.0 * here[0] + above[0]))
    p = steepness(below[1], here[1], above[1], SMALL * (below[1] + 2.0 * here[1] + above[1]))
    return maximum(rho, p)


@njit(**FORMULA)
def of_solid(law, c, mean, differences, m, strength):
    """(s Z Delta u, s Z Delta v) / m0, and what is lost, over alpha m0."""
    u, v = differences
    rate = strength * root(c[7] * c[2])
    return rate * u, rate * v, -1.0 * rate * c[3] / c[2] * fma(u, u, v * v)


@njit(**FORMULA)
def steepness_of_solid(law, c, below, here, above):
    """The larger s of (u, v)."""
    e = SMALL_IN_SOLID * root(c[7] * c[2])
    return maximum(steepness(below[0], here[0], above[0], e), steepness(below[1], here[1], above[1], e))


def dissipative(equations: Formulas) -> Formulas:
    """Equations of a gas, in either form, or of a solid, with these terms, as fsipetsc.scheme.plane.dissipation takes them."""
    if equations.kind == FLUID:
        pairs = hasattr(equations, "pair")
        w = (12, 9, 10, 7) if pairs else (11, 6, 7, 8)
        new = {
            **({} if pairs else {"sums": (0, 1, 2, 3), "rate": gas_rate}),
            "prepared": tuple(range(13 if pairs else 12)),
            "prepare": prepare_pairs if pairs else prepare_fluxes,
            "flux": two_point.flux_and_metrics,
            "plain_flux": equations.flux,
            "extras": (0, 1, 2, 3, 4, 5, 6),
            "differenced": w,
            "averaged": (0, *w[1:]),
            "watched": (0, 4),
            "gather": (DIFFERENCE,) * 4,
            "dissipation": of_gas,
            "steepness": steepness_of_gas,
        }
    else:
        new = {
            "rate": solid_rate,
            "sums": (0, 1, 2),
            "differenced": (2, 3),
            "averaged": (),
            "watched": (2, 3),
            "gather": (DIFFERENCE, DIFFERENCE, MIDDLE),
            "dissipation": of_solid,
            "steepness": steepness_of_solid,
        }
    return Formulas(**{**vars(equations), **new})


@njit(**FORMULA)
def solid_rate(law, c, v, divergence, extra, sums):
    """With what is lost and won."""
    x, y, u, w, T = rate(law, c, v, divergence, extra, sums)
    return x, y, u + sums[0], w + sums[1], T + sums[2]
