"""The kernels of a gas block's rates: what is read at a node or a pair, which formula it goes
through, where it is stored; and what fsipetsc/scheme/gas.c takes, which calls them.

A row of a tile has the primitive variables w of its nodes and, in viscous gases, J and the fluxes
a^k . f_v of each axis k. Metrics are read where the block has them: a^1 … a^d, the velocity of the
grid, around an axis A. On a grid that moves J has a two-point flux, too: - g, that of U = 1.
"""

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.blocks.cube import cube_text
from fsipetsc.equations.gas import NEAR
from fsipetsc.equations.tensors import outer
from fsipetsc.equations.vectors import add, along, mean, scale, sub
from fsipetsc.kernels.kernel import PLANES, ROWS, SHARED, Kernel, interlaced, numbers_of
from fsipetsc.kernels.memory import Array, aligned
from fsipetsc.kernels.unit import c_source, unit
from fsipetsc.operators.bands import Band, Patch
from fsipetsc.scheme.stage import KINDS, Owned, Spans, Stage, no_stage, store


def gas_kernels(gas: Any, d: int, form: Any, viscous: bool, moves: bool) -> list[Kernel]:
    """All kernels of a gas in d dimensions; form: fsipetsc.scheme.gas_forms."""
    sums = len(form.force.sums((0.0,) * d))
    made = [_load(gas, d, viscous), *_pairs(gas, d, form, viscous, moves)]
    kinds = KINDS if sums == d + 2 else KINDS[:1]
    made += [_store(d, sums, moves, number, kind) for number, kind in enumerate(kinds)]
    return [*made, _slope(gas, d), _viscous(gas, d)] if viscous else made


def _load(gas: Any, d: int, viscous: bool) -> Kernel:
    kernel = Kernel("gas_load", "The primitive variables w of the nodes of a row, perhaps J.")
    q = kernel.read("q", PLANES, d + 3)
    kernel.store("w", ROWS, kernel.parameters(gas).primitive(q))
    if viscous:
        kernel.store("w", ROWS, q[:1], d + 5)
    return kernel


def _pairs(gas: Any, d: int, form: Any, viscous: bool, moves: bool) -> list[Kernel]:
    """The kernel of pairs that are near one another, which counts those that are not, and the
    kernel of these, if the form tells them apart.
    """
    near = Kernel("gas_near", "The fluxes of pairs of near nodes, added to the sums of both.")
    _pair(near, gas, d, form, viscous, moves, True)
    if near.counted is None:
        return [near]
    far = Kernel("gas_far", "The fluxes of the other pairs, added to the sums of both nodes.")
    _pair(far, gas, d, form, viscous, moves, False)
    return [near, far]


def _pair(
    kernel: Kernel, gas: Any, d: int, form: Any, viscous: bool, moves: bool, near: bool
) -> None:
    """Let the kernel add what the lower node of a pair loses and the upper one gains, times the
    weight of the pair: that of the row, times that of the node. It is 0 of pairs that are not of
    the kernel's kind; those formulas are finite for ratios of states up to 1e28.
    """
    flux, force = (form.near, form.force.near) if near else (form.any, form.force.any)
    gas = kernel.parameters(gas)
    l, r = kernel.read("l", ROWS, d + 5), kernel.read("r", ROWS, d + 5)
    a_l, a_r = kernel.read("a_l", PLANES, d), kernel.read("a_r", PLANES, d)
    (of_row,), (of_node,) = kernel.read("of_row", SHARED, 1), kernel.read("of_node", ROWS, 1)
    distance = form.distance(gas, l, r)
    if not isinstance(distance, float):
        apart = distance > NEAR
        of_node = np.where(apart, *((0.0, of_node) if near else (of_node, 0.0)))
        kernel.count(apart)
    g = 0.0
    if moves:
        grid = len(gas.of_grid((0.0,) * d))
        v_l, v_r = kernel.read("v_l", PLANES, grid), kernel.read("v_r", PLANES, grid)
        g = gas.volume_flux(a_l, v_l, a_r, v_r)
    F, rise = flux(gas, l, r, a_l, a_r, g), 0.0
    sums = len(form.force.sums((0.0,) * d))
    if sums > d + 2:
        (low,), (high,) = kernel.read("potential_l", ROWS, 1), kernel.read("potential_r", ROWS, 1)
        rise = high - low
    both = force(gas, F, l, r, a_l, a_r, rise)
    if viscous:
        s = mean(kernel.read("s_l", ROWS, d + 1), kernel.read("s_r", ROWS, d + 1))
        both = tuple((F[0], *sub(F[1 : d + 2], s), *F[d + 2 :]) for F in both)
    if moves:
        both, sums = tuple((*F, -g) for F in both), sums + 1
    less, more = (scale(of_row * of_node, numbers) for numbers in both)
    low, high = (kernel.read(name, ROWS, sums) for name in ("low", "high"))
    kernel.store("low", ROWS, sub(low, less))
    kernel.store("high", ROWS, add(high, more))


def _store(d: int, sums: int, moves: bool, number: int, kind: str) -> Kernel:
    says = "J_t, the rates of J rho, J rho u, J E, the force, of a row, or what follows from them."
    kernel = Kernel(f"gas_{kind}", says)
    (of_row,), (of_node,) = kernel.read("of_row", SHARED, 1), kernel.read("of_node", ROWS, 1)
    total = add(*(kernel.read(name, ROWS, sums + moves) for name in ("low", "high")))
    total = scale(of_row * of_node, total)
    store(kernel, number, (total[-1] if moves else 0.0, *total[: d + 2]))
    if sums > d + 2:
        kernel.store("supplied", interlaced(f"{d + 1}"), (*total[d + 2 : sums], 0.0))
    return kernel


def _slope(gas: Any, d: int) -> Kernel:
    """D_k z of the entropy variables z, from the nodes of one distance before and after."""
    kernel = Kernel("gas_slope", "What the nodes of one distance give to D z, added to it.")
    gas = kernel.parameters(gas)
    below, z, above = (
        gas.entropy_variables(kernel.read(name, ROWS, d + 5)) for name in ("below", "here", "above")
    )
    before, after = kernel.read("before", ROWS, 1)[0], kernel.read("after", ROWS, 1)[0]
    more = along(scale(0.5 * after, sub(above, z)), 0.5 * before, sub(z, below))
    kernel.add("slope", ROWS, more)
    return kernel


def _viscous(gas: Any, d: int) -> Kernel:
    kernel = Kernel("gas_viscous", "The viscous fluxes a^k . f_v of all axes k of a row's nodes.")
    gas, w = kernel.parameters(gas), kernel.read("w", ROWS, d + 5)
    (J,) = kernel.read("w", ROWS, 1, d + 5)
    areas = [kernel.read("a", PLANES, d, k * d) for k in range(d)]
    slopes = [kernel.read("slope", ROWS, d + 1, k * (d + 1)) for k in range(d)]
    scaled, inverse = outer(slopes[0][:-1], areas[0]), scale(slopes[0][-1], areas[0])
    for slope, area in zip(slopes[1:], areas[1:], strict=True):
        scaled, inverse = add(scaled, outer(slope[:-1], area)), along(inverse, slope[-1], area)
    scaled, inverse = scale(1.0 / J, scaled), scale(1.0 / J, inverse)
    stress, heat = gas.viscous_stress(w, scaled, inverse), gas.conduction(w, inverse)
    for k, area in enumerate(areas):
        kernel.store("s", ROWS, gas.viscous_flux(w, stress, heat, area), k * (d + 1))
    return kernel


#: most nodes of a tile along the first axis, by dimension; in three most rows along the second one
TILES, DEPTH = {1: 232, 2: 136, 3: 72}, 8
#: nodes beside a tile that it reaches, at most
MARGIN = 24
#: zeros between two nodes with pairs of one distance that make two spans of them; most spans
GAP, SPANS = 16, 64
_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long


class _Axis(ctypes.Structure):
    _fields_ = [
        *((name, _POINTER) for name in ("S", "weight")),
        ("own", Owned),
        *((name, _NUMBER) for name in ("reach", "size", "stride")),
    ]


class _Gas(ctypes.Structure):
    _fields_ = [
        *((name, _Axis) for name in ("first", "inner", "last")),
        *((name, _POINTER) for name in ("p", "metrics", "potential", "supplied")),
        ("stage", Stage),
        *((name, _NUMBER) for name in ("N", "layers", "depth", "before")),
        *((name, _POINTER) for name in ("rows", "high", "low", "slope", "along")),
        *((name, _POINTER) for name in ("per_weight", "gain", "loss", "gains", "losses", "tiles")),
        ("count", _NUMBER),
    ]


def gas_text(gas: Any, d: int, form: Any, viscous: bool, moves: bool) -> str:
    """The C code of the function gas_sweep for a gas in d dimensions."""
    kernels = gas_kernels(gas, d, form, viscous, moves)
    constants = {
        "D": d,
        "VISCOUS": int(viscous),
        "MOVES": int(moves),
        "FORCE": int(len(form.force.sums((0.0,) * d)) > d + 2),
        "TELLS_FAR": int(any(kernel.name == "gas_far" for kernel in kernels)),
        **{"ROW": TILES[d] + 2 * MARGIN, "MARGIN": MARGIN, "SPANS": SPANS},
    }
    cube = [cube_text()] if d == 3 else []
    loops = [c_source("fsipetsc.scheme", name) for name in ("stage.c", "gas.c")]
    return unit(constants, kernels, *loops, *cube)


class GasVolume:
    """A struct in C with what gas_sweep takes of a part of a block, and the memory it points to.

    metrics: (rows, N). Where a constant force acts pair by pair,
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
        moves: bool,
        bands: Sequence[Band],
        patch: Patch,
        metrics: Array,
    ) -> None:
        reach = [band.reach for band in bands]
        inner, last = (1, 2) if d == 3 else (2, 1)
        far = 1 + int(viscous)
        layers = far * reach[last] + 1
        depth = (DEPTH if d == 3 else 1) + 2 * far * reach[inner]
        numbers, sums = d + 5 + viscous * (1 + d * (d + 1)), len(form.force.sums((0.0,) * d))
        raised = int(sums > d + 2)
        self.potential = np.zeros(raised * int(np.prod(patch.ghosted)))
        self.supplied = np.zeros(raised * int(np.prod(patch.own)) * (d + 1))
        room = {
            "rows": layers * depth * numbers,
            "high": layers * depth * (sums + moves),
            "low": sums + moves,
            "slope": d * (d + 1),
            "gains": 1,
            "losses": 1,
        }
        memory = {n: aligned(count * (TILES[d] + 2 * MARGIN)) for n, count in room.items()}
        memory["along"], memory["gain"], memory["loss"] = _weights(bands[0])
        memory["per_weight"] = 1.0 / bands[0].weight
        memory["tiles"] = _tiles(d, bands[0].S, patch, inner)
        memory["p"] = np.array([*numbers_of(gas), 0.0])
        memory |= {"metrics": metrics, "potential": self.potential, "supplied": self.supplied}
        self._bands = [(np.ascontiguousarray(b.S), np.ascontiguousarray(b.weight)) for b in bands]
        self._memory = memory
        strides = np.cumprod([1, *patch.ghosted])
        self._places = {"first": 0, "inner": inner, "last": last}
        axes = {n: self._axis(k, patch, int(strides[k])) for n, k in self._places.items()}
        self._struct = _Gas(
            **axes,
            **{name: array.ctypes.data for name, array in memory.items()},
            N=metrics.shape[1],
            layers=layers,
            depth=depth,
            before=far * reach[inner],
            stage=no_stage(),
            count=len(memory["tiles"]),
        )
        self.address = ctypes.addressof(self._struct)

    def let_advance(self, stage: Stage, free: Spans) -> None:
        """Make stages of the nodes within ``free``, first and first beyond along each axis of the
        ghosted array, to whose rates nothing else adds.
        """
        self._struct.stage = stage
        for name, k in self._places.items():
            own = getattr(self._struct, name).own
            own.free_begin, own.free_end = free[k]

    def forget(self) -> None:
        """Clear the memory of rows, so that no NaN of a bad state stays there for another step."""
        self._memory["rows"][:] = 0.0

    def _axis(self, k: int, patch: Patch, stride: int) -> _Axis:
        S, weight = self._bands[k]
        begin, size = patch.first[k], patch.ghosted[k]
        own = Owned(begin, begin + patch.own[k])
        return _Axis(S.ctypes.data, weight.ctypes.data, own, len(S) - 1, size, stride)


def _weights(band: Band) -> tuple[Array, Array, Array]:
    """along, gain and loss of fsipetsc/scheme/gas.c: S of pairs, S over the weights of the upper
    and of the lower nodes, after MARGIN zeros and before others.
    """
    reach, n = len(band.S) - 1, len(band.weight)
    along, gain, loss = np.zeros((3, reach + 1, n + 2 * MARGIN))
    for k in range(1, min(reach + 1, n)):
        S, lower = band.S[k, : n - k], slice(MARGIN, MARGIN + n - k)
        along[k, lower] = S
        gain[k, lower] = S / band.weight[k:]
        loss[k, lower] = S / band.weight[: n - k]
    return along, gain, loss


def _tiles(d: int, S: Array, patch: Patch, inner: int) -> Array:
    """Records of all tiles: x0, x1, y0, y1, how many spans, these."""
    tiles, deep = [], DEPTH if d == 3 else 1
    for y0, y1 in _pieces(patch.first[inner], patch.own[inner], deep, deep):
        for x0, x1 in _pieces(patch.first[0], patch.own[0], TILES[d], 8):
            spans = _spans(S, x0, x1)
            assert len(spans) <= SPANS, "more spans than a tile has room for"
            numbers = [x0, x1, y0, y1, len(spans), *(number for span in spans for number in span)]
            tiles.append(numbers + [0] * (5 + 3 * SPANS - len(numbers)))
    return np.array(tiles, np.int64)


def _pieces(begin: int, count: int, most: int, multiple: int) -> list[tuple[int, int]]:
    """First node and first beyond of pieces of so many nodes, about equal, ``most`` at most; all
    but the last have a multiple of some number.
    """
    size = -(-count // -(-count // most))
    size += -size % multiple
    ends = range(begin, begin + count, size)
    return [(a, min(a + size, begin + count)) for a in ends]


def _spans(S: Array, x0: int, x1: int) -> list[tuple[int, int, int]]:
    """Distance, first lower node and first beyond of the pairs along a row of which a node is in a
    tile. A few pairs of weight 0 are taken along where that saves a span.
    """
    spans = []
    for k in range(1, len(S)):
        first = max(x0 - k, 0)
        lower = first + np.flatnonzero(S[k, first : min(x1, S.shape[1] - k)])
        for i in lower.tolist():
            if spans and spans[-1][0] == k and i - spans[-1][2] < GAP:
                spans[-1] = k, spans[-1][1], i + 1
            else:
                spans.append((k, i, i + 1))
    return spans
