"""Rates of the nodes of a solid block, without fluxes through its faces. fsipetsc.equations.solid
has the equations, fsipetsc.operators.bands the weights S_il of pairs. With

    D_k f   = sum_l S_il (f_l - f_i) / (2 weight_i)     derivative along axis k
    D°_k f  = sum_l S_il (f_l + f_i) / (2 weight_i)     the same without flux through the ends

and the tractions t^k = P A^k, the rates of displacement, velocity and energy are

    D_t = v,    J0 m0 v_t = sum_k D°_k t^k,
    J0 m0 e_t = v . sum_k D°_k t^k + sum_k t^k . D_k v.

The power is, pair by pair, S_il (t_i . v_l + t_l . v_i)/2: nothing is lost or won.

A layer is loaded, and its F and t^k are found, when rates that need them are next. Boxes of nodes
around a tile say where what is needed: F, T and t^k where its pairs reach, displacements where
these reach in turn; conduction reaches once more. What two tiles need is found twice by the same
operations: rates do not depend on tiles, nor on how a block is cut. The kernels are at the end.
"""

from collections.abc import Sequence
from itertools import product as combined
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.checks import Array
from fsipetsc.equations.tensors import add_unit, apply, column_sums, product, transpose
from fsipetsc.equations.vectors import add, along, dot, scale, sub, total
from fsipetsc.kernels.arrays import aligned
from fsipetsc.kernels.kernel import OWNED, PLANES, ROWS, SHARED, Kernel, floats_of
from fsipetsc.kernels.loops import each, otherwise, pick, when
from fsipetsc.operators.bands import Patch
from fsipetsc.scheme.sweep import KINDS, Sweep, in_order, kept, order, parts, pieces, store

#: planes of a tile
TILE = "{c} * step + {i}"
#: kinds of derivatives: D_k and D°_k
PLAIN, FREE = range(2)
#: most nodes of a tile along the first axis, and along the second one of three, for d = 1, 2, 3
TILES = ((1024, 1), (128, 1), (64, 32))
#: longest pairs of all operators; nodes of a row with all that they reach
REACH = 7
WIDTH = 1024 + 6 * REACH
#: what is known of a tile's nodes: unknowns; F, T and t^k; heats; rates
KNOWN, STRAINED, HEATED, OWN = range(4)


def distances(layers: int, strides: Any, axes: Any, pairs: int) -> Array:
    """Return `far` of SolidSweep."""
    places, m = np.arange(layers)[:, None], np.arange(1, pairs + 1) * np.array([[[1]], [[-1]]])
    along_layers = (places + m) % layers - places
    every = [(along_layers if k == 2 else m + 0 * places) * strides[k] for k in axes]
    return np.concatenate(every, axis=-1)


def boxes_of(bands: Any, patch: Patch, d: int, conducts: bool) -> Array:
    """Return the boxes KNOWN … OWN of all tiles of the owned nodes: (tiles, 4, 3, 2)."""
    most, found = (*TILES[d - 1], patch.own[2]), []
    for own in combined(*map(pieces, patch.first, patch.own, most)):
        near = reached(bands, own)
        strained = reached(bands, near) if conducts else near
        found.append([reached(bands, strained), strained, near, own])
    return np.array(found)


def reached(bands: Any, box: Any) -> Any:
    """Return the box of all nodes that have pairs with those of a box, and of these."""
    found = []
    for (S, _), (begin, end) in zip(bands, box, strict=True):
        m, i = np.nonzero(S)
        l = np.minimum(i + m, S.shape[1] - 1)
        met = (begin <= i) & (i < end) | (begin <= l) & (l < end)
        found.append((min([begin, *i[met]]), max([end - 1, *l[met]]) + 1))
    return found


def neighbours(bands: Any) -> tuple[Array, Array, Array]:
    """jumps, weights and runs of SolidSweep."""
    most = max(2 * band.reach + 1 for band in bands)
    shape = 3, max(len(band.weight) for band in bands), 1 + most + -most % 4
    jumps, weights = np.zeros(shape, np.int64), np.zeros((2, *shape))
    for axis, (S, weight) in enumerate(bands):
        for i in range(len(weight)):
            pairs = [(m, S[m, i]) for m in range(1, min(len(S), len(weight) - i))]
            pairs += [(-m, -S[m, i - m]) for m in range(1, min(len(S), i + 1))]
            own = sum(S_il for _, S_il in pairs)
            pairs = [(m, S_il) for m, S_il in [*pairs, (0, own)] if abs(S_il) > 1e-12]
            here = slice(1, 1 + len(pairs))
            jumps[axis, i, 0], jumps[axis, i, here] = len(pairs), [m for m, _ in pairs]
            for kind, sign in ((PLAIN, -1.0), (FREE, 1.0)):
                signed = [S_il if m else sign * S_il for m, S_il in pairs]
                weights[kind, axis, i, here] = np.array(signed) / (2.0 * weight[i])
    n = len(bands[0].weight)
    all_of = np.concatenate([jumps[0, :n], *weights[:, 0, :n]], axis=1)
    ends = 1 + np.flatnonzero((all_of[1:] != all_of[:-1]).any(axis=1))
    return jumps, weights, np.stack([[0, *ends], [*ends, n]], axis=1)


class SolidSweep(Sweep):
    """The sweeps of a part of a block: their data, beside the record of the part, and what is
    recorded of a tile. bands: of the ghosted nodes along three axes; here axes are first, inner and
    last one. Methods take n nodes from x on along the first axis, of row y in layer z.

    p: parameters of the kernels. boxes: (tiles, 4, 3, 2) first node and first beyond of KNOWN …
    OWN. steps, to_strains: (n, 2) stages and layers (fsipetsc.scheme.sweep.order) of rates and of
    strains. jumps: (3, n, most) of each axis and node how many neighbours there are, and how far;
    weights: (2, 3, n, most) S_il/(2 weight_i) of these, for PLAIN and FREE, which differ at the
    node itself; runs: (n, 2) of the nodes along the first axis those for which they are the same.
    inside: three pairs, first node and first beyond of those of the interior, None of axes that are
    not there; far: (2, layers, d pairs) of these, how far those of a pair are ahead and behind in a
    tile, by place in the ring; inner: (d pairs,) weights of both. row, layer: nodes of a row and of
    a layer of a tile; layers: how many are kept. tile: by components, of the nodes of a tile:
    unknowns, strains F, tractions t^k, temperatures T, heats A^k . h; slopes: of those of a row.
    """

    def __init__(self, solid: Any, d: int, kernels: Any, bands: Any, patch: Patch) -> None:
        bands, patch = in_order(bands, d), Patch(*(in_order(of_axes, d) for of_axes in patch))
        self.kernels, self.p = kernels, np.array([*floats_of(solid), 0.0])
        conducts, pairs = kernels.conduct is not None, kernels.pairs
        self.boxes = boxes_of(bands, patch, d, conducts)
        known, *stages = [tuple(box) for box in self.boxes[0, :, 2].tolist()]  # those of all tiles
        stages = stages if conducts else [stages[0], stages[-1]]
        self.steps = order(bands[2].S, (known, *stages))
        self.to_strains = order(bands[2].S, (known, stages[-1]))
        self.jumps, self.weights, self.runs = neighbours(bands)
        axes = (0, 2) if d == 2 else range(d)
        inside = [band.interior(pairs) if k in axes else None for k, band in enumerate(bands)]
        of_pairs = [self.weights[PLAIN, k, inside[k][0], 1 : 1 + pairs] for k in axes]
        sizes = self.boxes[:, KNOWN, :2, 1] - self.boxes[:, KNOWN, :2, 0]
        self.row, inner = sizes.max(axis=0).tolist()
        self.layer, self.layers = self.row * inner, (3 + conducts) * bands[2].reach + 1
        strides = 1, self.row, self.layer
        self.inside, self.far = tuple(inside), distances(self.layers, strides, axes, pairs)
        self.inner = np.concatenate(of_pairs)
        # whole vectors, an odd number: components do not compete for one place of the fast memory
        self.step = 8 * (self.layers * self.layer // 16 * 2 + 3)
        counts = {"unknowns": 2 * d + 1, "strains": len(solid.unstrained((0.0,) * d))}
        counts |= {"tractions": d * d, "temperatures": 1, "heats": d}
        made = {name: aligned(c * self.step).reshape(c, -1) for name, c in counts.items()}
        self.tile, self.slopes = SimpleNamespace(**made), np.zeros((2 * d * d + d, WIDTH))

    def sweep(self, part, found, y, q, f):
        """Store the rates of the owned nodes, or what becomes of them (fsipetsc.scheme.sweep), in
        f; y, q: planes of the owned nodes, and of all with a halo of two interior reaches, with
        conduction of three.
        """
        heats = [(self.find_heats, HEATED)] * (self.kernels.conduct is not None)
        stages = (self.load, KNOWN), (self.pull, STRAINED), *heats, (self.store, OWN)
        self.begin(part, found, y, q, f)
        self.take(self.steps, stages)

    def sweep_strains(self, part, y, q, F):
        """Fill planes of the strains F of the owned nodes; y, q: planes of their unknowns, and of
        those of a halo of one reach.
        """
        stages = (self.load, KNOWN), (self.find_strains, OWN)
        self.begin(part, None, y, q, F)
        self.take(self.to_strains, stages)

    def take(self, steps, stages):
        """Take the stages of all tiles: what is done with a row of nodes, and the box of these
        rows.
        """
        boxes = self.boxes
        for t in each(boxes.shape[0]):
            self.x0, self.y0 = (boxes[t, KNOWN, k, 0] for k in range(2))
            for s in each(steps.shape[0]):
                stage, z = steps[s, 0], steps[s, 1]
                for number, (do, box) in enumerate(stages):
                    with when(stage == number):
                        for y in each(boxes[t, box, 1, 0], boxes[t, box, 1, 1]):
                            x = boxes[t, box, 0, 0]
                            do(x, boxes[t, box, 0, 1] - x, y, z)

    def at(self, x, y, z):
        """The place of a node in planes of the tile."""
        return z % self.layers * self.layer + (y - self.y0) * self.row + (x - self.x0)

    def given(self, x, y, z):
        """What kernels take of the nodes from one on."""
        at, place, ring = self.at(x, y, z), self.ghosted_at(x, y, z), z % self.layers
        found = {name: array[0, at:] for name, array in vars(self.tile).items()}
        found |= {"slopes": self.slopes[0], "metrics": self.part.metrics[0, place:], "N": self.N}
        if self.part.prestress is not None:
            found["prestress"] = self.part.prestress[0, place:]
        found |= {"far": self.far[0, ring], "back": self.far[1, ring], "w": self.inner}
        return {**found, "step": self.step, "p": self.p}

    def load(self, x, n, y, z):
        """Load unknowns."""
        for begin, count, q, N in self.loaded(x, x + n, y, z):
            at, unknowns = self.at(begin, y, z), self.tile.unknowns
            for c in range(2 * self.d + 1):
                for i in each(count, vector=True):
                    unknowns[c, at + i] = q[c * N + i]

    def differentiate(self, kind, f, count, to, x, n, y, z):
        """Store D_k of count planes of f[k] for all axes k in planes of slopes, from ``to`` on; if
        kind is FREE, D°_k. Nodes with the same neighbours are taken together: along the row those
        in the interior, across it all.
        """
        for k, planes in enumerate(f):
            axis, out = 2 * k if self.d == 2 else k, self.slopes[to + k * count :]
            if axis:
                self.combine(kind, axis, (y, z)[axis - 1], planes, count, out, x, x, n, y, z)
                continue
            for run in each(self.runs.shape[0]):
                begin = np.maximum(self.runs[run, 0], x)
                many = np.minimum(self.runs[run, 1], x + n) - begin
                with when(many > 0):
                    self.combine(kind, 0, begin, planes, count, out, x, begin, many, y, z)

    def combine(self, kind, axis, node, f, count, out, x, begin, n, y, z):
        """The same along one axis, of n nodes from ``begin`` on of the row that begins at x; node:
        whose neighbours they have along the axis.
        """
        at, jumps, weights = self.at(begin, y, z), self.jumps[axis, node], self.weights
        for group in each((jumps[0] + 3) // 4):
            several = [4 * group + 1 + m for m in range(4)]
            w = [weights[kind, axis, node, m] for m in several]
            places = [at + self.away(axis, jumps[m], z) for m in several]
            for c in each(count):
                for i in each(n, vector=True):
                    found, place = dot(w, [f[c, far + i] for far in places]), begin - x + i
                    out[c, place] = np.where(group == 0, found, out[c, place] + found)

    def away(self, axis, jump, z):
        """Numbers between a node and a neighbour along an axis in planes of the tile."""
        if axis < 2:
            return jump * self.row if axis else jump
        there = z % self.layers + jump
        around = pick(there < 0, self.layers, pick(there < self.layers, 0, -self.layers))
        return (jump + around) * self.layer

    def pull(self, x, n, y, z):
        """Find F, T and the tractions t^k, within the interior with kernels of its own."""
        for begin, count, inside in parts(x, x + n, y, z, self.inside):
            with when(inside):
                self.kernels.pull_inside(count, **self.given(begin, y, z))
            with otherwise():
                place = begin, count, y, z
                self.differentiate(PLAIN, [self.tile.unknowns] * self.d, self.d, 0, *place)
                self.kernels.pull(count, **self.given(begin, y, z))

    def find_heats(self, x, n, y, z):
        """Find the heats A^k . h."""
        self.differentiate(PLAIN, [self.tile.temperatures] * self.d, 1, 0, x, n, y, z)
        self.kernels.conduct(n, **self.given(x, y, z))

    def find_strains(self, x, n, y, z):
        """Store F."""
        F = self.f[0, self.own_at(x, y, z) :]
        self.differentiate(PLAIN, [self.tile.unknowns] * self.d, self.d, 0, x, n, y, z)
        self.kernels.strain(n, F=F, M=self.M, **self.given(x, y, z))

    def store(self, x, n, y, z):
        """Store rates, but the next stage of nodes to whose rates nothing is added."""
        d, tile = self.d, self.tile
        tractions = [tile.tractions[k * d :] for k in range(d)]
        for first, length, kind in self.stored(x, x + n, y, z):
            for begin, count, inside in parts(first, first + length, y, z, self.inside):
                own, given = self.own_at(begin, y, z), self.given(begin, y, z)
                with when(inside):
                    self.run(self.kernels.stores_inside, kind, count, own, **given)
                with otherwise():
                    place = begin, count, y, z
                    self.differentiate(FREE, tractions, d, 0, *place)
                    self.differentiate(PLAIN, [tile.unknowns[d:]] * d, d, d * d, *place)
                    if self.kernels.conduct is not None:
                        heats = [tile.heats[k:] for k in range(d)]
                        self.differentiate(FREE, heats, 1, 2 * d * d, *place)
                    self.run(self.kernels.stores, kind, count, own, **given)


@kept
def solid_kernels(solid: Any, d: int, order: int, prestressed: bool) -> SimpleNamespace:
    """All kernels of a solid in d dimensions; order: of the operators in the interior. _inside:
    those of nodes there, which have so many pairs of nodes on both sides. conduct: None without
    conduction.
    """
    pairs, kinds = order // 2, list(enumerate(KINDS))
    return SimpleNamespace(
        pairs=pairs,
        strain=_strain(solid, d),
        pull=_pull(solid, d, 0, prestressed),
        pull_inside=_pull(solid, d, pairs, prestressed),
        stores=tuple(_accelerate(solid, d, 0, *kind) for kind in kinds),
        stores_inside=tuple(_accelerate(solid, d, pairs, *kind) for kind in kinds),
        conduct=_conduct(solid, d) if solid.kappa > 0.0 else None,
    )


def _slopes(
    kernel: Kernel, pairs: int, f: str, first: Sequence[int], count: int, to: int
) -> tuple[Any, ...]:
    """Derivatives D_k of so many planes of f for each axis k, which begin at its number of
    ``first``: if pairs is 0 from rows that have them, from ``to`` on; in the interior from so many
    pairs of nodes on both sides, with weights w and distances far, axis by axis:

        D_k f = sum_m w_km (f_(i + m) - f_(i - m))
    """
    if not pairs:
        return kernel.read("slopes", ROWS, len(first) * count, to)
    found: tuple[Any, ...] = ()
    for k, plane in enumerate(first):
        D: tuple[Any, ...] = ()
        for number in range(k * pairs, (k + 1) * pairs):
            ends = (f"{TILE} + {far}[{number}]" for far in ("far", "back"))
            both = (kernel.read(f, layout, count, plane) for layout in ends)
            (w,), change = kernel.read("w", SHARED, 1, number), sub(*both)
            D = along(D, w, change) if D else scale(w, change)
        found += D
    return found


def _strain(solid: Any, d: int) -> Kernel:
    kernel = Kernel("solid_strain", "F = 1 + 1/J0 sum_k D_k D A^k, with the stretch of hoops.")
    solid = kernel.parameters(solid)
    kernel.store("F", OWNED, _found_strain(kernel, solid, d, 0))
    return kernel


def _found_strain(kernel: Kernel, solid: Any, d: int, pairs: int) -> Any:
    A, (J0,) = kernel.read("metrics", PLANES, d * d), kernel.read("metrics", PLANES, 1, d * d)
    D_D = _slopes(kernel, pairs, "unknowns", (0,) * d, d, 0)
    gradient = scale(1.0 / J0, product(transpose(D_D), A))
    D = kernel.read("unknowns", TILE, d) if solid.around else ()
    R = kernel.read("metrics", PLANES, 1, d * d + 1)[0] if solid.around else 0.0
    return solid.with_hoops(add_unit(1.0, gradient), D, R)


def _pull(solid: Any, d: int, pairs: int, prestressed: bool) -> Kernel:
    """Add a prestress S to P, and take its energy S : (F - 1)/m0 from that of which T is made."""
    says = "F, T, and the tractions t^k = (P + S) A^k with a prestress S."
    kernel, conducts = Kernel("solid_pull" + "_inside" * (pairs > 0), says), solid.kappa > 0.0
    solid, A = kernel.parameters(solid), kernel.read("metrics", PLANES, d * d)
    F, v = _found_strain(kernel, solid, d, pairs), kernel.read("unknowns", TILE, d, d)
    if conducts or solid.around:
        kernel.store("strains", TILE, F)
    (e,) = kernel.read("unknowns", TILE, 1, 2 * d)
    S = kernel.read("prestress", PLANES, d * d) if prestressed else ()
    if prestressed and not solid.coupled:
        e = e - dot(S, add_unit(-1.0, F[: d * d])) / solid.m0
        kernel.store("unknowns", TILE, (e,), 2 * d)
    T = solid.temperature(v, e, F)
    tractions = product(A, transpose(solid.stress_at(F, T)))
    if prestressed:
        tractions = add(tractions, product(A, transpose(S)))
    if conducts:
        kernel.store("temperatures", TILE, (T,))
    kernel.store("tractions", TILE, tractions)
    return kernel


def _conduct(solid: Any, d: int) -> Kernel:
    kernel = Kernel("solid_conduct", "A^k . h with grad T = 1/J0 sum_k A^k D_k T.")
    solid = kernel.parameters(solid)
    A, (J0,) = kernel.read("metrics", PLANES, d * d), kernel.read("metrics", PLANES, 1, d * d)
    gradient = scale(1.0 / J0, apply(transpose(A), kernel.read("slopes", ROWS, d)))
    F = kernel.read("strains", TILE, len(solid.unstrained((0.0,) * d)))
    h = solid.heat_flux(F, gradient)
    kernel.store("heats", TILE, apply(A, h))
    return kernel


def _accelerate(solid: Any, d: int, pairs: int, number: int, kind: str) -> Kernel:
    """Store the rates that follow from D°_k t^k, D_k v and, with conduction, D°_k A^k . h."""
    says = "(v, Div P/m0 + b, Div (P^T v + h)/m0 + b . v), or what follows from these rates."
    kernel = Kernel(f"solid_{kind}" + "_inside" * (pairs > 0), says)
    conducts, solid = solid.kappa > 0.0, kernel.parameters(solid)
    per_mass = 1.0 / (kernel.read("metrics", PLANES, 1, d * d)[0] * solid.m0)
    v, t = kernel.read("unknowns", TILE, d, d), kernel.read("tractions", TILE, d * d)
    force = column_sums(_slopes(kernel, pairs, "tractions", range(0, d * d, d), d, 0))
    power = dot(v, force) + dot(t, _slopes(kernel, pairs, "unknowns", (d,) * d, d, d * d))
    if conducts:
        power = power + total(_slopes(kernel, pairs, "heats", range(d), 1, 2 * d * d))
    acceleration = along(solid.force, per_mass, force)
    if solid.around:
        F = kernel.read("strains", TILE, len(solid.unstrained((0.0,) * d)))
        (e,) = kernel.read("unknowns", TILE, 1, 2 * d)
        (R,) = kernel.read("metrics", PLANES, 1, d * d + 1)
        acceleration = solid.with_hoop_force(acceleration, v, e, F, R)
    energy = per_mass * power + dot(solid.force, v)
    store(kernel, number, (*v, *acceleration, energy))
    return kernel
