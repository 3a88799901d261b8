"""The rates of a solid block as a compiled function: fsipetsc/scheme/solid.c with its kernels."""

import ctypes
from typing import Any

import numpy as np

from fsipetsc.blocks.cube import cube_text
from fsipetsc.kernels.kernel import numbers_of
from fsipetsc.kernels.unit import c_source, unit
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.solid_kernels import solid_kernels
from fsipetsc.scheme.solid_work import WIDTH, Work

_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long


class _Solid(ctypes.Structure):
    _fields_ = [
        *((name, _POINTER) for name in ("boxes", "jumps", "weights", "ends")),
        *((name, _NUMBER) for name in ("tiles", "nodes", "most")),
        *((name, _NUMBER * n) for name, n in (("lags", 3), ("size", 2), ("own", 2), ("first", 3))),
        *((name, _NUMBER) for name in ("row", "layer", "layers", "step")),
        *((name, _POINTER) for name in ("p", "metrics", "prestress")),
        *((name, _NUMBER) for name in ("N", "M")),
        *((name, _POINTER) for name in ("unknowns", "strains", "tractions", "temperatures")),
        *((name, _POINTER) for name in ("heats", "slopes")),
    ]


def solid_text(solid: Any, d: int, prestressed: bool) -> str:
    """The C code of the function solid_rates for a solid in d dimensions."""
    constants = {
        "D": d,
        "CONDUCTS": int(solid.kappa > 0.0),
        "HOOPS": int(len(solid.around) > 0),
        "PRESTRESSED": int(prestressed),
        "WIDTH": int(WIDTH),
    }
    kernels = solid_kernels(solid, d, prestressed)
    cube = [cube_text()] if d == 3 else []
    return unit(constants, kernels, c_source("fsipetsc.scheme", "solid.c"), *cube)


class SolidVolume:
    """What solid_rates takes of a part of a block: a struct in C, and the memory it points to.

    metrics: (rows, N); prestress: (d d, N) or (d d, 0). address: of the struct.
    """

    def __init__(self, solid: Any, work: Work, metrics: Array, prestress: Array) -> None:
        patch, layout = work.patch, work.layout
        self._memory = {
            "boxes": np.ascontiguousarray(work.boxes, np.int64),
            "jumps": np.ascontiguousarray(work.jumps, np.int64),
            "weights": work.weights,
            "ends": np.ascontiguousarray(work.ends, np.int64),
            "p": np.array([*numbers_of(solid), 0.0]),
            "metrics": metrics,
            "prestress": prestress,
            "unknowns": work.unknowns,
            "strains": work.strains,
            "tractions": work.tractions,
            "temperatures": work.temps,
            "heats": work.heats,
            "slopes": work.slopes,
        }
        self._struct = _Solid(
            **{name: array.ctypes.data for name, array in self._memory.items()},
            tiles=len(work.boxes),
            nodes=work.jumps.shape[1],
            most=work.jumps.shape[2],
            lags=(_NUMBER * 3)(*work.lags),
            size=(_NUMBER * 2)(*patch.ghosted[:2]),
            own=(_NUMBER * 2)(*patch.own[:2]),
            first=(_NUMBER * 3)(*patch.first),
            row=layout.row,
            layer=layout.layer,
            layers=layout.layers,
            step=work.temps.size,
            N=metrics.shape[1],
            M=int(np.prod(patch.own)),
        )
        self.address = ctypes.addressof(self._struct)
