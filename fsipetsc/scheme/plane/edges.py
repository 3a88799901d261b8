"""What goes through the edges of a layer in two dimensions. Compiled.

The rates that the sweep makes are *unloaded*: no traction, no heat and no mass goes through any edge. Here a row of them gets
what does: -F.N / (h a_0), F.N the flux out of the layer per length of the edge:

    SLIP      (0, p N, p w) of the gas at the edge itself, w the velocity of the wall . N
    OPEN      (F(U_in) + F(U_out)).N / 2 - lambda (U_out - U_in) / 2, with the faster of the waves of both states
    OUTFLOW   F(U_in).N; with a pressure p_b beyond and a Mach number through the edge m < 1, as OPEN: U_out has the density
              and the velocity of U_in, and the pressure p + (1 - m^2) (p_b - p); m = 0 where gas flows in
    FREE      -p_b cof F . N on a solid: a pressure that follows the surface

Interfaces (fsipetsc.coupling.plane), no-slip walls, what is clamped or given, need nothing: the unknowns are
set there.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.boundaries.plane import FREE, OPEN, OUTFLOW, SLIP
from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.operators.rows import STRIDE, along, at
from fsipetsc.physics.plane.gas import LINE_ROWS
from fsipetsc.scheme.plane.gains import gain


@njit(**OPTIONS)
def kind_at(layer, side, i):
    """What stands at the lower or upper edge at column i."""
    kind = layer.edge_y[side]
    if kind == INTERFACE_END and not layer.face[side, 0] <= i < layer.face[side, 1]:
        return layer.beside[side]
    return kind


@njit(**OPTIONS)
def amend_gas(law, layer, op, s, place, lines, j):
    """Of a gas: all four edges."""
    zeta, per_length = (layer.first_y + j) / (layer.ny - 1), 1.0 / ((layer.ny - 1) * layer.h_y)
    high = lines + LINE_ROWS * STRIDE
    for side in range(2):
        if j == layer.end_y[side]:
            line = high if side == 1 else lines
            for i in range(place.first, place.end):
                kind = kind_at(layer, side, i)
                if kind == SLIP or kind == OPEN or kind == OUTFLOW:
                    nx, ny = -s[U64(line + 5 * STRIDE + i)], 1.0 + s[U64(line + 4 * STRIDE + i)]
                    w = nx * s[U64(line + 2 * STRIDE + i)] + ny * s[U64(line + 3 * STRIDE + i)]
                    through(law, layer, op, s, place, j, i, kind, side, nx, ny, w, side, layer.h_y)
        i = layer.end_x[side]
        if place.first <= i < place.end:
            kind = layer.edge_x[side]
            if kind == SLIP or kind == OPEN or kind == OUTFLOW:
                low, up = lines + i, high + i
                nx = (s[U64(up + STRIDE)] - s[U64(low + STRIDE)]) * per_length
                ny = (s[U64(low)] - s[U64(up)]) * per_length
                u, v = s[U64(low + 2 * STRIDE)], s[U64(low + 3 * STRIDE)]
                u, v = u + zeta * (s[U64(up + 2 * STRIDE)] - u), v + zeta * (s[U64(up + 3 * STRIDE)] - v)
                through(law, layer, op, s, place, j, i, kind, side, nx, ny, nx * u + ny * v, 2 + side, layer.h_x)


@njit(**OPTIONS)
def through(law, layer, op, s, place, j, i, kind, side, nx, ny, w, edge, h):
    """Give the rates at column i what goes through an edge with N = (nx, ny), which points to larger X or Y; w: grid
    velocity . N.
    """
    rho, u, v = s[U64(at(place.v, 0, j) + i)], s[U64(at(place.v, 1, j) + i)], s[U64(at(place.v, 2, j) + i)]
    e, p = s[U64(at(place.v, 3, j) + i)], s[U64(at(place.v, 4, j) + i)]
    inside, scale, r = (rho, rho * u, rho * v, e), (1.0 - 2.0 * side) / (h * op.norm[0]), place.rates + i
    if kind == SLIP:
        s[U64(r + 2 * STRIDE)] += scale * nx * p
        s[U64(r + 3 * STRIDE)] += scale * ny * p
        s[U64(r + 4 * STRIDE)] += scale * w * p
        gain(layer, op, j, i, 0.0, scale * nx * p, scale * ny * p, scale * w * p)
        return
    f, given = normal_flux(inside, u, v, p, nx, ny, w), layer.outside[edge]
    if kind == OPEN or given[0] > 0.0:
        gas = law.gas.constants(layer)
        rho_o, u_o, v_o, T_o = given[0], given[1], given[2], given[3]
        if kind == OUTFLOW:
            out = (2.0 * side - 1.0) * (nx * u + ny * v - w)
            rho_o, u_o, v_o, T_o = rho, u, v, beyond(law, gas, rho, p, out / (nx * nx + ny * ny) ** 0.5, given[0])
        p_o = law.gas.pressure(gas, rho_o, T_o)
        e_o = rho_o * (law.gas.energy(gas, rho_o, T_o) + 0.5 * (u_o * u_o + v_o * v_o))
        g = normal_flux((rho_o, rho_o * u_o, rho_o * v_o, e_o), u_o, v_o, p_o, nx, ny, w)
        T, N = law.gas.temperature_of_pressure(gas, rho, p), (nx * nx + ny * ny) ** 0.5
        here = abs(nx * u + ny * v - w) + N * law.gas.sound_speed_squared(gas, rho, T) ** 0.5
        there = abs(nx * u_o + ny * v_o - w) + N * law.gas.sound_speed_squared(gas, rho_o, T_o) ** 0.5
        fastest = max(here, there) * (2.0 * side - 1.0)
        f = (
            0.5 * (f[0] + g[0] - fastest * (rho_o - inside[0])),
            0.5 * (f[1] + g[1] - fastest * (rho_o * u_o - inside[1])),
            0.5 * (f[2] + g[2] - fastest * (rho_o * v_o - inside[2])),
            0.5 * (f[3] + g[3] - fastest * (e_o - inside[3])),
        )
    for c in range(4):
        s[U64(r + (c + 1) * STRIDE)] += scale * f[c]
    gain(layer, op, j, i, scale * f[0], scale * f[1], scale * f[2], scale * f[3])


@njit(**OPTIONS)
def beyond(law, gas, rho, p, velocity, given):
    """The temperature beyond an OUTFLOW with the pressure ``given``; velocity: of the gas through it."""
    T = law.gas.temperature_of_pressure(gas, rho, p)
    m_squared = max(velocity, 0.0) ** 2 / law.gas.sound_speed_squared(gas, rho, T)
    return law.gas.temperature_of_pressure(gas, rho, p + max(1.0 - m_squared, 0.0) * (given - p))


@njit(**OPTIONS)
def normal_flux(U, u, v, p, nx, ny, w):
    """N . (f, g) - w U."""
    V = nx * u + ny * v
    return U[0] * (V - w), U[1] * (V - w) + nx * p, U[2] * (V - w) + ny * p, U[3] * (V - w) + p * V


@njit(**OPTIONS)
def amend_solid(law, layer, op, s, place, lines, j):
    """Of a solid: a pressure that follows its lower or upper edge; the sides in X carry nothing."""
    for side in range(2):
        if j != layer.end_y[side] or layer.edge_y[side] != FREE or layer.outside[side, 0] == 0.0:
            continue
        load = (1.0 - 2.0 * side) * layer.outside[side, 0] / (layer.h_y * op.norm[0] * layer.m0)
        dx, dy = place.slopes, place.slopes + 2 * STRIDE
        for k in range(2):
            v, to = at(place.v, k, j), (dx if k == 0 else dy)
            along(op, s, v, to, place.first, place.end, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
        for i in range(place.first, place.end):
            a_x, a_y = -load * s[U64(dy + i)], load * (1.0 + s[U64(dx + i)])
            s[U64(place.rates + 2 * STRIDE + i)] += a_x
            s[U64(place.rates + 3 * STRIDE + i)] += a_y
            u, v = s[U64(at(place.v, 2, j) + i)], s[U64(at(place.v, 3, j) + i)]
            gain(layer, op, j, i, 0.0, layer.m0 * a_x, layer.m0 * a_y, layer.m0 * (u * a_x + v * a_y))
