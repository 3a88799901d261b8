"""Rates of end points that are not what the closure of the operator makes of the fluxes. Compiled.

Summation by parts puts the flux through an end of a layer into the rate of its end point, divided by a_0 h. Where the end is
*unloaded* it is taken out there, and what remains is the rate with neither traction nor heat nor mass going through the end.
What the end does to the gas or the solid is then put in its place: here by a wall or the end of a solid, and between gas and
solid by fsipetsc.coupling.conservative.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import ABSORBING, FREE, INTERFACE_END, WALL
from fsipetsc.boundaries.solid_ends import wave_impedance
from fsipetsc.coupling.interface import JUMP_FLUX, JUMP_STRESS, JUMP_U
from fsipetsc.operators.kernels import OPTIONS, ROW, U64, row_length
from fsipetsc.parallel.exchange import kinetic_energy_of
from fsipetsc.physics.layer import GIVEN_FLUX, LOADED, SHARED_HEAT


@njit(**OPTIONS)
def gas_end(law, layer, op, s, w, v, f, target, side):
    """The end point of a gas layer: unloaded, or else at an interface without conduction the keeper of its entropy."""
    if layer.unloaded[side] != LOADED:
        unload_gas(law, layer, op, s, w, v, f, target, side)
    elif layer.end_kind[side] == INTERFACE_END and layer.kappa == 0.0:
        keep_entropy(law, layer, op, s, w, v, f, target, side)


@njit(**OPTIONS)
def unload_gas(law, layer, op, s, w, v, f, target, side):
    """Take out the flux through the end of a stretched layer or at an interface.

    At a wall of velocity V, acceleration A the momentum of the end point is given, and the traction that this takes does work:
    e_t += V (rho A + V rho_t - m_t) in the rates without it.
    """
    end = layer.lo if side == 0 else layer.hi
    out = (2 * side - 1) / (layer.h * op.norm[0])  # of the layer
    rho_f, m_f, e_f = law.end_flux(law, layer, s, w, v, f, end)
    add_to_rate(s, target, 0, end, out * rho_f)
    add_to_rate(s, target, 1, end, out * m_f)
    change, V, A = out * e_f, layer.end_v[side], layer.end_a[side]
    if layer.end_kind[side] == WALL and (V != 0.0 or A != 0.0):
        scale = -1.0 / layer.h
        rho_X, m_X, _ = law.end_slopes(law, layer, op, s, w, v, f, side)
        rho_t, m_t = scale * rho_X + out * rho_f, scale * m_X + out * m_f
        rho_t, m_t = rho_t + forcing(s, target, 0, end), m_t + forcing(s, target, 1, end) + layer.force * s[U64(w + end)]
        change += V * (s[U64(w + end)] * A + V * rho_t - m_t)
    if layer.end_thermal[side] == GIVEN_FLUX:
        change += layer.end_heat[side] / (layer.h * op.norm[0])
    add_to_rate(s, target, 2, end, change)


@njit(**OPTIONS)
def keep_entropy(law, layer, op, s, w, v, f, target, side):
    """Without conduction the gas's end point at an interface is a particle that no heat reaches: it keeps its entropy.

    The rate of e is not the flux's but that of rho T S_t = tau u_x, tau = mu' u_x: with h = eps + p/rho,

        (J e)_t = u (J rho u)_t + (h - u^2/2) (J rho)_t - p J_t + J tau u_x.

    Summation by parts no longer makes the change of energy there that of the flux: by the closure's error, which conservation
    does not notice in smooth flow. A shock that reflects at the point would leave it with the entropy before.
    The error that the closure of order s makes in the energy would stay: nothing carries it away from there.
    """
    end, stride = (layer.lo if side == 0 else layer.hi), layer.stride
    scale, spacing = -1.0 / layer.h, layer.h * layer.J
    rho_X, m_X, e_X = law.end_slopes(law, layer, op, s, w, v, f, side)
    rho_t, m_t, e_t, u_x = scale * rho_X, scale * m_X, scale * e_X, end_slope(op, s, v + end, side) / spacing
    rho, gas = s[U64(w + end)], law.gas.constants(layer)
    u = s[U64(w + stride + end)] / rho
    internal = s[U64(w + 2 * stride + end)] / rho - 0.5 * u * u
    density = rho / layer.J
    T = law.gas.temperature(gas, density, internal)
    p = law.gas.pressure(gas, density, T)
    h = internal + p / density
    heating = layer.mu * law.transport.relative(law.transport.constants(layer), T)[0] * u_x * u_x * layer.J
    change = u * m_t + (h - 0.5 * u * u) * rho_t + heating - p * layer.spread / layer.h - e_t
    add_to_rate(s, target, 2, end, change)


@njit(**OPTIONS)
def end_flux(law, layer, s, w, v, f, end):
    """(rho, rho u, e) through an end point."""
    return s[U64(f + end)], s[U64(f + ROW + end)], s[U64(f + 2 * ROW + end)]


@njit(**OPTIONS)
def end_slopes(law, layer, op, s, w, v, f, side):
    """h D of these fluxes there."""
    at = f + (layer.lo if side == 0 else layer.hi)
    return end_slope(op, s, at, side), end_slope(op, s, at + ROW, side), end_slope(op, s, at + 2 * ROW, side)


@njit(**OPTIONS)
def solid_end(law, layer, op, s, w, v, f, target, side):
    """The end point of a solid where it is unloaded: traction and heat flux are taken out, and what the end does put in.

    At an interface the kinetic energy of the end point, m0 u^2/2, has a rate and a place of its own beside the unknowns: see
    fsipetsc.coupling.conservative. Prescribed jumps load the solid.
    """
    if layer.unloaded[side] == LOADED:
        return
    end, normal = (layer.lo if side == 0 else layer.hi), 2.0 * side - 1.0
    per_mass = 1.0 / (layer.h * op.norm[0] * layer.m0)
    net, conducted = s[U64(f + ROW + end)], s[U64(f + 2 * ROW + end)]
    u, given = s[U64(w + end)], layer.end_data[side, 0]
    acceleration, heating = -normal * net * per_mass, -normal * conducted * per_mass / layer.alpha
    if layer.end_kind[side] != INTERFACE_END:
        if layer.end_kind[side] == FREE:
            acceleration += normal * given * per_mass
        elif layer.end_kind[side] == ABSORBING:
            layer.end_impedance[side] = impedance(law, layer, op, s, w, given, end, side)
            acceleration += (normal * given - layer.end_impedance[side] * u) * per_mass
        if layer.end_thermal[side] == GIVEN_FLUX:
            heating += layer.end_heat[side] * per_mass / layer.alpha
    else:
        free = end_slope(op, s, f + ROW + end, side) / (layer.h * layer.m0) + layer.force + acceleration
        free += forcing(s, target, 0, end)
        power = layer.m0 * u * free
        jump, load = layer.end_jump[side], normal * per_mass
        if jump[JUMP_FLUX] != 0.0:
            if layer.unloaded[side] != SHARED_HEAT and layer.kappa_e > 0.0:
                heating += load * jump[JUMP_FLUX] / layer.alpha
            else:
                power += load * layer.m0 * jump[JUMP_FLUX]
        acceleration += load * jump[JUMP_STRESS]
        power += load * layer.m0 * (net * jump[JUMP_U] + jump[JUMP_STRESS] * (u - jump[JUMP_U]))
        set_rate(s, target, kinetic_energy_of(layer, side), power)
    add_to_rate(s, target, 0, end, acceleration)
    add_to_rate(s, target, 2, end, heating)


@njit(**OPTIONS)
def impedance(law, layer, op, s, w, given, end, side):
    """m0 c at the end of a solid, c the speed of elastic waves there; see fsipetsc.boundaries.solid_ends."""
    x_X = end_slope(op, s, w + 3 * layer.stride + end, side) / layer.h
    T = s[U64(w + 2 * layer.stride + end)]
    p = law.pressing.pressure(law.pressing.constants(layer), T, x_X)
    return wave_impedance(law, layer, T, p, given + p, x_X)


@njit(**OPTIONS)
def end_slope(op, s, at, side):
    """h D at the end point s[at] of a row, of which no more is known, perhaps, than what this takes."""
    step, d = 1 - 2 * side, 0.0
    for c in range(row_length(op)):
        d += op.closure[0, c] * s[U64(at + step * c)]
    return step * d


@njit(**OPTIONS)
def forcing(s, target, unknown, i):
    """What forcing adds to the rate of an unknown at point i."""
    return target.J * s[U64(target.forcing + unknown * target.stride + i)] if target.forcing >= 0 else 0.0


@njit(**OPTIONS)
def add_to_rate(s, target, unknown, i, change):
    """The rate of an unknown at point i, which has been sent on, was to be larger by ``change``."""
    at = unknown * target.stride + i
    s[U64(target.next + at)] += target.a * change
    if target.sum >= 0:
        s[U64(target.sum + at)] += target.b * change


@njit(**OPTIONS)
def set_rate(s, target, i, k):
    """Send on the rate k of what stands at place i of the first unknown."""
    s[U64(target.next + i)] = target.a * k + s[U64(target.source + i)]
    if target.sum >= 0:
        s[U64(target.sum + i)] = target.b * k + s[U64(target.base + i)]
