"""The record of a layer: which points there are, whose they are, how the frame moves, what stands
at the outer end."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

#: kinds of layers, and unknowns of a point of each: gas (rho, rho u, e), solid (u, sigma, T, x)
FLUID, SOLID = 0, 1
DOF = (3, 4)
_I, _F = np.int64, np.float64
RECORD = np.dtype(
    [
        ("kind", _I),  # FLUID or SOLID
        ("present", _I),  # 1: this rank owns points of the layer
        ("n", _I),  # points, some of them held in reserve,
        ("lo", _I),  # the first and the last active one: in a gas interface point and ghost point
        ("hi", _I),
        ("least", _I),  # active points that the operator and the end conditions need
        ("own_lo", _I),  # this rank owns own_lo <= i < own_hi
        ("own_hi", _I),
        ("halo_lo", _I),  # and has halos of so many points
        ("halo_hi", _I),
        ("halo", _I),  # these, where there is a neighbour
        ("start", _I),  # of the owned part in the rank's part of the solution, in doubles
        ("h", _F),
        ("s", _F),  # velocity of a gas's frame, that of its interface point
        ("x_interface", _F),  # x of a gas's interface
        # the ends: -1 where an interface stands, else a kind of fsipetsc.boundaries
        ("end_kind", _I, (2,)),
        ("end_degree", _I, (2,)),
        ("end_x", _F, (2,)),  # of a boundary
        ("end_data", _F, (2, 4)),
        (
            "end_thermal",
            _I,
            (2,),
        ),  # INSULATED, GIVEN_T or GIVEN_FLUX, at the end of a solid, and the temperature
        ("end_heat", _F, (2,)),  # or heat flux that is given
    ],
    align=True,
)


class Part(NamedTuple):
    """What compiled code takes of a rank's part of a layer.

    law: Gas or Elastic; record: one RECORD; forcing (owned, unknowns) or (0, unknowns); scratch:
    rows; y, stage, total, k: the completed solution, that of a stage, the sum of the stages and
    rates, (owned, unknowns) each.
    """

    law: Any
    record: np.ndarray
    forcing: np.ndarray
    scratch: np.ndarray
    y: np.ndarray
    stage: np.ndarray
    total: np.ndarray
    k: np.ndarray
