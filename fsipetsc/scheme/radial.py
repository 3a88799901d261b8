"""The terms of a gas around an axis (kappa = 1) or a centre (2) beside its fluxes.

Fluxes through the areas a^k = (b^k_1, A b^k_2), A = |r|^kappa, leave out that pressure and viscous
stress act around the axis, too. With S of fsipetsc.blocks.grid, the momentum along r gets

    (p - tau_o) S,    tau_o = mu (2 e/kappa - 2/3 (div + e)),    e = u_r S/J

where e is the sum of the rates of all hoops, and div = 1/J sum_k a^k . D_k u is found by entropy
variables. As e is part of the divergence, the flux of momentum through a^k gets -2/3 mu e a^k, and
that of energy u times as much. Energy has no source. p S is sum_k D_k (a^k p) of a uniform p, so
rest is kept; what p S does to the entropy cancels what sum_k D_k a^k leaves of the fluxes;
viscosity makes entropy at each node.
"""

from fsipetsc.equations.vectors import add, dot, scale
from fsipetsc.kernels.arrays import column
from fsipetsc.kernels.loops import each
from fsipetsc.scheme.normals import slope_at
from fsipetsc.scheme.part import area, gas_at, ghosted_node


def add_radial(part, q, rates):
    """Add the terms at the head of this file; q: (N, d + 3) ghosted, rates: (M, d + 3).

    part.grid: see fsipetsc.blocks.grid. part.hoops: ((d + 1)^2, N) for u/T and -1/T, and for
    the viscous fluxes of hoops along each axis; None in a gas without viscosity.
    """
    source = part.grid.source
    for i in each(rates.shape[0]):
        n = ghosted_node(i, part.patch)
        rates[i, 1 + len(part.like)] += gas_at(part, q, n)[1] * source[n]
    if part.hoops is not None:
        add_viscous(part, q, rates)


def add_viscous(part, q, rates):
    """Add what viscous stresses around the axis do to momentum and energy."""
    find_hoops(part, q)
    gas, d, like_z = part.laws, len(part.like), (*part.like, 0.0)
    source, room = part.grid.source, part.hoops
    for i in each(rates.shape[0]):
        n = ghosted_node(i, part.patch)
        w = gas_at(part, q, n)
        u, T, spread, fluxes = gas.velocity(w), w[2], 0.0, like_z
        for k in range(d):
            a = area(part, k, n)
            slope, flux = (
                slope_at(part, n, k, lambda n, first=first: column(like_z, room, n, first), own)
                for first, own in ((0, -1.0), ((k + 1) * (d + 1), 1.0))
            )
            spread, fluxes = spread + dot(a, u) * slope[-1] + dot(a, slope[:-1]), add(fluxes, flux)
        div, e = T / q[n, 0] * spread, u[-1] * source[n] / q[n, 0]
        mu = gas.mu * gas.transport.viscosity(T)
        push = mu * (2.0 * e / len(part.grid.hoops) - 2.0 / 3.0 * (div + e)) * source[n]
        fluxes = (*fluxes[: d - 1], fluxes[d - 1] - push, fluxes[d])
        for c in range(d + 1):
            rates[i, 2 + c] += fluxes[c]


def find_hoops(part, q):
    """Fill the room with entropy variables and with the viscous fluxes of hoops."""
    gas, d, room = part.laws, len(part.like), part.hoops
    for n in each(part.grid.source.size, vector=True):
        w = gas_at(part, q, n)
        mu = gas.mu * gas.transport.viscosity(w[2])
        stress = -2.0 / 3.0 * mu * w[2 + d] * part.grid.source[n] / q[n, 0]
        room[:, n] = gas.entropy_variables(w)
        for k in range(d):
            a = area(part, k, n)
            power = stress * dot(a, gas.velocity(w))
            room[(k + 1) * (d + 1) :, n] = *scale(stress, a), power
