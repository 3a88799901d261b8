"""The rates and strains of a solid block in C: fsipetsc/scheme/solid.c with its kernels."""

import ctypes
from typing import Any

import numpy as np

from fsipetsc.blocks.cube import cube_text
from fsipetsc.kernels.kernel import numbers_of
from fsipetsc.kernels.unit import c_source, unit
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.solid_kernels import solid_kernels
from fsipetsc.scheme.solid_work import WIDTH, Work, in_order
from fsipetsc.scheme.stage import Owned, Spans, Stage, no_stage

_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long


class _Solid(ctypes.Structure):
    _fields_ = [
        *((name, _POINTER) for name in ("boxes", "jumps", "weights", "ends", "far", "inner")),
        *((name, _NUMBER) for name in ("tiles", "nodes", "most")),
        ("size", _NUMBER * 2),
        *((name, Owned * 3) for name in ("own", "inside")),
        *((name, _NUMBER) for name in ("row", "layer", "layers", "step")),
        *((name, _POINTER) for name in ("p", "metrics", "prestress")),
        *((name, _NUMBER) for name in ("N", "M")),
        ("stage", Stage),
        *((name, _POINTER) for name in ("unknowns", "strains", "tractions", "temperatures")),
        *((name, _POINTER) for name in ("heats", "slopes")),
    ]


def solid_text(solid: Any, d: int, order: int, prestressed: bool) -> str:
    """The C code of solid_sweep and solid_strains for a solid in d dimensions; order: of the
    operators in the interior.
    """
    constants = {
        "D": d,
        "CONDUCTS": int(solid.kappa > 0.0),
        "HOOPS": int(len(solid.around) > 0),
        "PRESTRESSED": int(prestressed),
        "WIDTH": int(WIDTH),
        "PAIRS": order // 2,
    }
    kernels = solid_kernels(solid, d, order, prestressed)
    cube = [cube_text()] if d == 3 else []
    loops = [c_source("fsipetsc.scheme", name) for name in ("stage.c", "solid.c")]
    return unit(constants, kernels, *loops, *cube)


class SolidVolume:
    """A struct in C with what these functions take of a part of a block, and the memory it points
    to.

    metrics: (rows, N); prestress: (d d, N) or (d d, 0). address: of the struct.
    """

    def __init__(self, solid: Any, work: Work, metrics: Array, prestress: Array) -> None:
        patch, layout = work.patch, work.layout
        self._memory = {
            "boxes": np.ascontiguousarray(work.boxes, np.int64),
            "jumps": np.ascontiguousarray(work.jumps, np.int64),
            "weights": work.weights,
            "ends": np.ascontiguousarray(work.ends, np.int64),
            "far": work.far,
            "inner": work.inner,
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
            size=(_NUMBER * 2)(*patch.ghosted[:2]),
            own=(Owned * 3)(*(Owned(f, f + n) for f, n in zip(patch.first, patch.own))),
            row=layout.row,
            layer=layout.layer,
            layers=layout.layers,
            step=work.temps.size,
            N=metrics.shape[1],
            inside=(Owned * 3)(*(Owned(0, 0, *ends) for ends in work.inside)),
            M=int(np.prod(patch.own)),
            stage=no_stage(),
        )
        self.address = ctypes.addressof(self._struct)
        self._d = len(solid.force)

    def let_advance(self, stage: Stage, free: Spans) -> None:
        """Let sweeps store stages, as GasVolume of fsipetsc.scheme.gas_volume does."""
        self._struct.stage = stage
        for own, ends in zip(self._struct.own, in_order(free, self._d), strict=True):
            own.free_begin, own.free_end = ends
