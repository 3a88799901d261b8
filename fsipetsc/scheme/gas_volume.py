"""The rates of a gas block as a function in C: fsipetsc/scheme/gas.c with its kernels."""

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.blocks.cube import cube_text
from fsipetsc.kernels.kernel import numbers_of
from fsipetsc.kernels.unit import c_source, unit
from fsipetsc.operators.bands import Band, Patch
from fsipetsc.scheme.gas_kernels import gas_kernels
from fsipetsc.scheme.rows import MARGIN, TILE, Array, aligned

#: most rows of a tile in three dimensions; nodes of a row, with those beside the tile
DEPTH = 8
ROW = TILE + 2 * MARGIN
#: zeros between two nodes with pairs of one distance that make two spans of them; most spans
GAP, SPANS = 16, 64
_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long


class _Axis(ctypes.Structure):
    _fields_ = [("S", _POINTER), ("weight", _POINTER)] + [
        (name, _NUMBER) for name in ("reach", "begin", "end", "size", "stride")
    ]


class _Gas(ctypes.Structure):
    _fields_ = [
        *((name, _Axis) for name in ("first", "inner", "last")),
        *((name, _POINTER) for name in ("p", "metrics", "potential", "supplied")),
        *((name, _NUMBER) for name in ("N", "J_t", "layers", "depth", "before")),
        *((name, _POINTER) for name in ("rows", "high", "low", "slope", "gain", "loss")),
    ]


def gas_text(gas: Any, d: int, form: Any, viscous: bool) -> str:
    """The C code of the function gas_rates for a gas in d dimensions."""
    kernels = gas_kernels(gas, d, form, viscous)
    constants = {
        "D": d,
        "VISCOUS": int(viscous),
        "FORCE": int(len(form.force.sums((0.0,) * d)) > d + 2),
        "TELLS_FAR": int(any(kernel.name == "gas_far" for kernel in kernels)),
        **{"ROW": ROW, "TILE": TILE, "MARGIN": MARGIN, "DEPTH": DEPTH, "GAP": GAP, "SPANS": SPANS},
    }
    cube = [cube_text()] if d == 3 else []
    return unit(constants, kernels, c_source("fsipetsc.scheme", "gas.c"), *cube)


class GasVolume:
    """What gas_rates takes of a part of a block: a struct in C, and the memory it points to.

    metrics: (rows, N), with J_t as the last row. Where a constant force acts pair by pair,
    potential: (N,) Phi of the ghosted nodes, supplied: (M (d + 1),) the force on each owned node
    and room for a power, interlaced, over the node's weight (fsipetsc.scheme.gas_force); else (0,).
    address: of the struct.
    """

    def __init__(
        self,
        gas: Any,
        d: int,
        form: Any,
        viscous: bool,
        bands: Sequence[Band],
        patch: Patch,
        metrics: Array,
    ) -> None:
        reach = [band.reach for band in bands]
        inner, last = (1, 2) if d == 3 else (2, 1)
        far = 1 + int(viscous)
        layers = far * reach[last] + 1
        depth = (DEPTH if d == 3 else 1) + 2 * far * reach[inner]
        numbers, sums = d + 5 + viscous * d * (d + 1), len(form.force.sums((0.0,) * d))
        raised = int(sums > d + 2)
        self.potential = np.zeros(raised * int(np.prod(patch.ghosted)))
        self.supplied = np.zeros(raised * int(np.prod(patch.own)) * (d + 1))
        room = {
            "rows": layers * depth * numbers,
            "high": layers * depth * sums,
            "low": sums,
            "slope": d * (d + 1),
            "gain": 1 + reach[0],
            "loss": 1 + reach[0],
        }
        memory = {name: aligned(count * ROW) for name, count in room.items()}
        memory["p"] = np.array([*numbers_of(gas), 0.0])
        memory |= {"metrics": metrics, "potential": self.potential, "supplied": self.supplied}
        self._bands = [(np.ascontiguousarray(b.S), np.ascontiguousarray(b.weight)) for b in bands]
        self._memory = memory
        strides = np.cumprod([1, *patch.ghosted])
        axes = {
            name: self._axis(k, patch, int(strides[k]))
            for name, k in (("first", 0), ("inner", inner), ("last", last))
        }
        self._struct = _Gas(
            **axes,
            **{name: array.ctypes.data for name, array in memory.items()},
            N=metrics.shape[1],
            J_t=len(metrics) - 1,
            layers=layers,
            depth=depth,
            before=far * reach[inner],
        )
        self.address = ctypes.addressof(self._struct)

    def forget(self) -> None:
        """Clear what is remembered of a bad state: no NaN may stay there for another step."""
        self._memory["rows"][:] = 0.0

    def _axis(self, k: int, patch: Patch, stride: int) -> _Axis:
        S, weight = self._bands[k]
        begin, size = patch.first[k], patch.ghosted[k]
        return _Axis(
            S.ctypes.data, weight.ctypes.data, len(S) - 1, begin, begin + patch.own[k], size, stride
        )
