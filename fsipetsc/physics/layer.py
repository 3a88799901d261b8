"""The record that describes one layer to the compiled kernels.

A layer has the points ``0 .. n-1``, from left to right. Its *active* points are ``lo..hi``: all of them in a solid
and in a stretched gas layer; in a rigid one the interface point, the ghost point of the embedded boundary, and all between.
This rank owns ``own_lo <= i < own_hi`` and holds halos of ``halo_lo`` and ``halo_hi`` points beside them.

The grid of a gas layer moves. Point i has the velocity s + i ``spread``, and the unknowns are J (rho, rho u, e), J the
distance of two points over h, its value at rest. Rigid: all points go with the interface, spread = 0 and J = 1. Stretched: the
layer reaches from end to end, and so do its points, J = (x_n-1 - x_0) / ((n-1) h).
"""

from __future__ import annotations

import numpy as np

FLUID, SOLID = 0, 1
#: unknowns per point: fluid (rho, rho u, e), solid (u, sigma, T, x)
DOF = (3, 4)
#: of a layer
ENDS = 2

#: what is asked of the heat at a wall or at the outer end of a solid
INSULATED, GIVEN_T, GIVEN_FLUX = 0, 1, 2
#: values of LAYER["unloaded"]: the boundary flux stays in the rates of an end point, or is left out; and then the
#: other side of the interface may have part in the temperature, too
LOADED, UNLOADED, SHARED_HEAT = 0, 1, 2

#: room for the numbers of a law of a material, see fsipetsc.physics.material_law
NUMBERS = 6

_I, _F = np.int64, np.float64
LAYER = np.dtype(
    [
        ("kind", _I),
        ("law", _I),  # number among the laws of the problem, see fsipetsc.scheme.laws
        ("present", _I),  # this rank owns points of the layer
        ("n", _I),
        ("lo", _I),
        ("hi", _I),
        ("least", _I),  # active points that the operator and the end conditions need
        ("own_lo", _I),
        ("own_hi", _I),
        ("halo_lo", _I),
        ("halo_hi", _I),
        ("start", _I),  # of the owned part in the rank's part of the solution vector, in doubles
        ("ends", _I),  # of the kinetic energies of its end points there, which the conservative coupling needs, else -1
        ("work", _I),  # of owned part and halos in a work area, in doubles
        ("stride", _I),  # from one unknown to the next in a work area, where each stands for itself
        ("outbox", _I, (2,)),  # addresses of the edges to and from the neighbours; see parallel.shared_memory
        ("inbox", _I, (2,)),
        ("middle", _I, (2,)),  # points of the part that a step treats tile by tile, see fsipetsc.scheme.runge_kutta
        ("h", _F),
        ("force", _F),  # body force per mass
        ("dissipation", _F),  # how strong it is, see fsipetsc.physics.dissipation,
        ("shocks", _F),  # and that of first order at shocks
        # fluid: materials and the moving frame
        ("gamma", _F),
        ("R", _F),
        ("cv", _F),
        ("mu", _F),  # 4/3 mu
        ("kappa", _F),
        ("gas_numbers", _F, (NUMBERS,)),
        ("transport_numbers", _F, (NUMBERS,)),
        ("stretched", _I),  # 1: both ends of the gas are grid points
        ("s", _F),  # velocity of point 0; of all points in the rigid frame, that of the fluid's own interface point
        ("spread", _F),  # by how much the next point is faster
        ("J", _F),
        ("stage_frame", _F, (5, 3)),  # these three in the stages of the step being made
        # solid
        ("K", _F),
        ("kappa_e", _F),
        ("m0", _F),
        ("alpha", _F),
        ("gruneisen", _F),  # p = gruneisen rho epsilon; 0 for the elastic solid
        ("pressing_numbers", _F, (NUMBERS,)),
        # the ends: -1 where an interface stands, else a kind of fsipetsc.boundaries
        ("end_kind", _I, (2,)),
        ("end_degree", _I, (2,)),
        ("end_x", _F, (2,)),  # Eulerian position of an embedded boundary, of both ends of a stretched layer
        ("end_data", _F, (2, 4)),
        ("end_thermal", _I, (2,)),  # INSULATED, GIVEN_T or GIVEN_FLUX, and the temperature
        ("end_heat", _F, (2,)),  # or heat flux that is given
        ("end_v", _F, (2,)),  # velocity of the end of a stretched layer
        ("end_a", _F, (2,)),  # and acceleration, of a wall
        ("unloaded", _I, (2,)),
        # momentum that an unloaded end was given with its velocity, in the step that has been completed last
        ("end_impulse", _F, (2,)),
        ("end_impedance", _F, (2,)),  # m0 c at an absorbing end that is unloaded
        ("end_jump", _F, (2, 4)),  # jumps prescribed at an interface, as in fsipetsc.coupling.interface
        ("end_apart", _I, (2,)),  # 1: u and T of the ghost point are others for the gradients (fluid), namely
        ("end_gradient", _F, (2, 2)),  # these
        # Eulerian position of the interface that carries the rigid frame (fluid)
        ("x_interface", _F),
    ],
    align=True,
)
