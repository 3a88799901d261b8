"""The record that describes this rank's part of one layer in two dimensions to compiled code.

A layer has nx by ny points, X along the rows and Y across them. A rank holds ``height`` rows of ``width`` points, halos among
them, and owns those from ``own_x[0]`` to ``own_x[1] - 1`` in the rows ``own_y[0]`` to ``own_y[1] - 1``, counted in what it
holds. The points at the edges of the layer, counted so too, are ``end_x`` and ``end_y``, wherever they may lie; a periodic
layer has none in X, and ``end_x`` is far away.
"""

from __future__ import annotations

import numpy as np

from fsipetsc.physics.layer import NUMBERS

#: unknowns per point: gas (J, J rho, J rho u, J rho v, J e), solid (x, y, u, v, T)
DOF = 5
#: what comes in through edges: mass, momentum along x and y, energy
GAINED = 4
#: where the edges in X of a periodic layer are
NOWHERE = 1 << 40
#: heat of a solid: with the work of the stresses (the paper's), or conducted only, beside an elastic energy
COUPLED, ELASTIC = 0, 1

_I, _F = np.int64, np.float64
PLANE_LAYER = np.dtype(
    [
        ("kind", _I),  # FLUID or SOLID
        ("width", _I),
        ("height", _I),
        ("own_x", _I, (2,)),
        ("own_y", _I, (2,)),
        ("end_x", _I, (2,)),
        ("end_y", _I, (2,)),
        ("first_x", _I),  # number in the layer of the first column held
        ("first_y", _I),
        ("ny", _I),
        ("h_x", _F),
        ("h_y", _F),
        ("ring", _I),  # rows of scratch that each quantity has, see fsipetsc.scheme.plane.sweep
        ("edge_y", _I, (2,)),  # what stands at the lower and upper edge: INTERFACE_END or a kind of fsipetsc.boundaries.plane
        ("beside", _I, (2,)),  # what stands there beside an interface that takes a part of the edge,
        ("face", _I, (2, 2)),  # namely the columns, counted in those held, from the first to before the second of these
        ("edge_x", _I, (2,)),  # what stands at the left and right edge
        ("thermal", _I, (4,)),  # at the lower, upper, left and right edge: INSULATED or GIVEN_T
        ("outside", _F, (4, 4)),  # rho, u, v, T outside an open edge; T of a wall; pressure on a free edge
        ("force", _F, (2,)),
        ("dissipation", _F),  # sigma/4^q of differences of half the order, and S/2 (or 0.7 S) of first ones where shocks are
        ("shocks", _F),
        ("gained", _F, (GAINED,)),  # rates of what comes in through edges, see fsipetsc.scheme.plane.gains
        # gas
        ("gamma", _F),
        ("R", _F),
        ("cv", _F),
        ("mu", _F),
        ("kappa", _F),
        ("gas_numbers", _F, (NUMBERS,)),
        ("transport_numbers", _F, (NUMBERS,)),
        # solid
        ("m0", _F),
        ("mu_e", _F),
        ("lambda_e", _F),
        ("p_ref", _F),
        ("alpha", _F),
        ("kappa_e", _F),
        ("heat", _I),
        ("solid_numbers", _F, (NUMBERS,)),
    ],
    align=True,
)
