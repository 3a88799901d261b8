"""Rates of a block of gas, without fluxes through its faces:

    weight_i (J U)_t,i = - sum_k sum_l S_il (F^k(i, l) - {a^k . f_v})

and a constant force, summed pair by pair like the fluxes. On a grid that moves J has the flux - g,
that of U = 1; fsipetsc.scheme.gas_terms adds a^k . v of nodes at the end of an axis. The weight of
a node is the product of those along all axes; S_il of a pair along axis k is that of
fsipetsc.operators.sbp times the weights along the others. The fluxes: fsipetsc.equations.gas.

Around an axis (m = 1) or a centre (2) fluxes through the areas a^k = (b^k_1, A b^k_2), A = |r|^m,
leave out what acts around it. With S of fsipetsc.blocks.grid, the momentum along r gets

    (p - tau_o) S,    tau_o = mu (2 e/m - 2/3 (div + e)),    e = u_r S/J

where e is the sum of the rates of all hoops, and is part of the divergence div + e in tau, too.
Energy has no source. p S is sum_k D_k (a^k p) of a uniform p, so rest is kept; what p S does to the
entropy cancels what sum_k D_k a^k leaves of the fluxes; viscosity makes entropy at each node.

The flux of a pair is computed once and added to both of its nodes. At shocks a pair keeps the part
`keep`, 1 - alpha, of its flux (fsipetsc.scheme.dissipation). The sum of the lower node belongs to
the row at work; that of the upper node waits in a row of its own. Fluxes reach a node in an order
that does not depend on how a block is cut, nor does its rate. Kernels are at the end.
"""

from functools import partial
from types import SimpleNamespace

import numpy as np

from fsipetsc.equations.gas import NEAR, Primitive, named
from fsipetsc.equations.tensors import outer
from fsipetsc.equations.vectors import add, along, mean, scale, sub
from fsipetsc.kernels.kernel import PLANES, ROWS, Kernel
from fsipetsc.kernels.loops import each, when, zeros
from fsipetsc.operators.slopes import slope
from fsipetsc.scheme.sweep import Sweep, ends_of, in_order, order

#: most nodes of a tile along the first axis, and most rows, for d = 1, 2, 3
TILES = ((232, 1), (136, 1), (72, 8))
#: zeros between two nodes with pairs of one distance that make two spans of them
GAP = 16


def _spans(S, begin, end):
    """Spans of the pairs along a row of which a node is one of begin … end - 1: (n, 3) distance,
    first lower node and first beyond. A few pairs of weight 0 are taken along to save a span.
    """
    spans = []
    for k in range(1, len(S)):
        lower = np.flatnonzero(S[k, :end])
        lower = lower[lower >= begin - k]
        runs = np.split(lower, 1 + np.flatnonzero(np.diff(lower) > GAP))
        spans += [(k, run[0], run[-1] + 1) for run in runs if run.size]
    return np.array(spans, np.int64).reshape(-1, 3)


class GasSweep(Sweep):
    """The sweep of a part of a block. A row has the primitive variables w of its nodes, and sums of
    upper nodes of pairs; in a viscous gas J, too, p - tau_o around an axis, the entropy variables z
    whose derivatives are taken, and the fluxes s = a^k . f_v of each axis k.

    steps: (n, 2) stages and layers (fsipetsc.scheme.sweep.order). spans: see `_spans`. low: (sums,
    ROW) sums of lower nodes of the row at work. per_weight: 1 over the weights along the first
    axis. potential: (N,) Phi of the ghosted nodes, where a constant force acts pair by pair;
    supplied: (M, d + 1) the force on each owned node and room for a power, over the node's weight
    (fsipetsc.scheme.gas_terms); else (0, d + 1).
    """

    def __init__(self, gas, d, kernels, bands, patch, damping):
        stages_before = 1 + kernels.viscous
        super().__init__(gas, d, kernels, bands, patch, TILES[d - 1], *[stages_before] * 2)
        x, _, last = in_order(bands, d)
        *others, (begin, beyond), (_, end) = self.ranges
        self.steps = order(last.S, (*others, (begin, beyond), (begin, end)))
        self.spans = _spans(x.S, patch.first[0], patch.first[0] + patch.own[0])
        self.per_weight, self.low = 1.0 / x.weight, zeros((kernels.numbers["high"], self.width))
        self.damping, self.keep = damping, zeros((d, self.width))
        raised = int(kernels.raises)
        self.potential = np.zeros(raised * int(np.prod(patch.ghosted)))
        self.supplied = np.zeros((raised * int(np.prod(patch.own)), d + 1))

    def sweep(self, part, found, y, q, f):
        """Store the rates of the owned nodes, or what becomes of them (fsipetsc.scheme.sweep), in
        f, with dissipation; y, q: planes of the owned nodes, and of all with a halo.
        """
        if self.damping:
            self.damping.begin(part, q.T)
        if self.kernels.shocks:
            self.keep[:] = 1.0
        around = {"source": part.grid.source.reshape(1, part.X.shape[1])} if part.around else {}
        self.begin(part, found, y, q, f, **around)
        self.weight = in_order([part.weight[k] for k in range(3)], self.d)
        stages_before = 1 + self.kernels.viscous
        viscous = [(partial(self.run, self.kernels.fluxes), 1, 1)] * self.kernels.viscous
        rates = self.rates, stages_before, stages_before - 1
        self.take(self.steps, ((self.load, 0, 0), *viscous, rates))
        if self.damping:
            self.damping.add(part, f.T)

    def rates(self, x, n, y, z):
        """Add the fluxes of the pairs that begin in a row; store its rates if the tile has it."""
        self.low[:, self.margin : self.margin + n] = 0.0
        of_layer, of_tile = z >= self.first[2], y >= self.first_row
        if self.d == 3:
            with when(of_layer):
                self.across(1, x, n, y, z)
        with when(of_tile):
            if self.d > 1:
                self.across(2, x, n, y, z)
            with when(of_layer):
                self.along(x, n, y, z)
                self.close(x, n, y, z)

    def across(self, number, x, n, y, z):
        """Add the pairs of a row with rows farther on, of the same layer or of others."""
        axis, i, at_rest = (1, y, z) if number == 1 else (self.d - 1, z, y)
        first = self.first_row if number == 1 else self.first[2]
        beside, S = self.weight[3 - number][at_rest], self.part.S[axis]
        for k in each(1, np.minimum(self.part.axes[axis, 0] + 1, self.sizes[number] - i)):
            s = S[k, i]
            with when((s != 0.0) & (i + k >= first)):
                to = (x, y + k, z) if number == 1 else (x, y, z + k)
                self.pairs(axis, k, (x, y, z), to, s * beside, self.weight[0][x:], n)

    def along(self, x, n, y, z):
        row_weight = self.weight[1][y] * self.weight[2][z]
        for m in each(self.spans.shape[0]):
            k = self.spans[m, 0]
            begin = np.maximum(self.spans[m, 1], x - k)
            count = np.minimum(self.spans[m, 2], x + n) - begin
            with when(count > 0):
                ends = (begin, y, z), (begin + k, y, z)
                self.pairs(0, k, *ends, row_weight, self.part.S[0, k, begin:], count)

    def pairs(self, axis, k, lower, upper, row_weight, node_weight, n):
        """Add the fluxes of n pairs of nodes, k apart along an axis, from two nodes on."""
        metrics, d, kernels, tile = self.part.metrics, self.d, self.kernels, self.tile
        given = {"row_weight": row_weight, "node_weight": node_weight, "p": self.p, "N": self.N}
        given["low"] = self.low[0, lower[0] - self.x0 + self.margin :]
        given["high"] = self.row(tile.high, *upper)
        for side, at in (("l", lower), ("r", upper)):
            place = self.ghosted_at(*at)
            given[side] = self.row(tile.w, *at)
            if kernels.viscous:
                given[f"s_{side}"] = self.row(tile.s, *at, axis * (d + 1))
            given[f"a_{side}"] = metrics[axis * d, place:]
            given[f"v_{side}"] = metrics[d * d, place:]
            given[f"potential_{side}"] = self.potential[place:]
        if kernels.shocks:
            self.find_keep(axis, k, self.ghosted_at(*lower), n)
            given["keep"] = self.keep[axis, 0:]
        apart = kernels.near_pairs(n, **given)
        if kernels.far_pairs is not None:
            with when(apart > 0):
                kernels.far_pairs(n, **given)

    def find_keep(self, axis, k, place, n):
        """Find 1 - alpha of n pairs of nodes, k apart along an axis; 1 of unphysical states."""
        keep, alpha, stride = self.keep[axis], self.damping.alpha[axis], self.damping.strides[axis]
        with when(self.damping.shocks[axis] > 0.0):
            keep[:n] = 1.0
            for m in each(k + 1):
                for i in each(n, vector=True):
                    keep[i] = np.minimum(keep[i], 1.0 - alpha[place + m * stride + i])
            for i in each(n, vector=True):
                keep[i] = np.where(keep[i] < 1.0, keep[i], 1.0)

    def close(self, x, n, y, z):
        per_row_weight = 1.0 / (self.weight[1][y] * self.weight[2][z])
        given = {"per_row_weight": per_row_weight, "per_node_weight": self.per_weight[x:]}
        given["low"] = self.low[0, x - self.x0 + self.margin :]
        given["supplied"] = self.supplied[self.own_at(x, y, z) :]
        self.kernels.rates(n, **given, **self.given(x, y, z))
        self.store(x, n, y, z)


def gas_kernels(gas, d, form, viscous, moves, stencil, shocks=False):
    """All kernels of a gas in d dimensions; stencil: of nodes inside. far_pairs: None where the
    form does not tell pairs apart; fluxes: viscous ones of any nodes, and of those inside.
    """
    sums, of_w = d + 2 + d * form.raises, d + 5 + viscous * (1 + bool(gas.around))
    rows = {"w": of_w, "high": sums + moves, "z": viscous * (d + 1), "s": viscous * d * (d + 1)}
    at_pressure = columns_beside(d)[1] if viscous else Primitive._fields.index("p")
    return SimpleNamespace(
        stencil=stencil,
        load=_load(gas, d, viscous, sums + moves),
        near_pairs=_pair(gas, d, form, viscous, moves, shocks, True),
        far_pairs=_pair(gas, d, form, viscous, moves, shocks, False) if form.entropy else None,
        rates=_rates(gas, d, sums, moves, at_pressure),
        ends=ends_of(d + 3),
        dof=d + 3,
        fluxes=tuple(_viscous(gas, d, of) for of in stencil.both if viscous),
        viscous=viscous,
        shocks=shocks,
        raises=form.raises,
        numbers=rows,
    )


def columns_beside(d):
    """Where rows w of a viscous gas have, after its d + 5 variables, J and p - tau_o."""
    return d + 5, d + 6


def _load(gas, d, viscous, sums):
    says = "The primitive variables w of the nodes of a row, perhaps J and z; sums are 0."
    kernel = Kernel("gas_load", says)
    q, gas = kernel.read("q", PLANES, d + 3), kernel.parameters(gas)
    w = gas.primitive(q)
    kernel.store("w", ROWS, w)
    kernel.store("high", ROWS, (0.0,) * sums)
    if viscous:
        kernel.store("w", ROWS, q[:1], columns_beside(d)[0])
        kernel.store("z", ROWS, gas.entropy_variables(w))
    return kernel


def _pair(gas, d, form, viscous, moves, shocks, near):
    """The kernel of pairs of near nodes, which counts the other pairs, or the kernel of those. It
    adds what the lower node of a pair loses and the upper one gains, times the weight of the
    pair: that of the row, times that of the node. It is 0 of pairs that are not of the kernel's
    kind; those formulas are finite for ratios of states up to 1e28.
    """
    name, pairs = ("near", "pairs of near nodes") if near else ("far", "the other pairs of nodes")
    kernel = Kernel(f"gas_{name}", f"The fluxes of {pairs}, added to the sums of both.")
    gas = kernel.parameters(gas)
    l, r = kernel.read("l", ROWS, d + 5), kernel.read("r", ROWS, d + 5)
    a_l, a_r = kernel.read("a_l", PLANES, d), kernel.read("a_r", PLANES, d)
    row_weight, (node_weight,) = kernel.number("row_weight"), kernel.read("node_weight", ROWS, 1)
    if form.entropy:
        apart = gas.pair_distance(l, r) > NEAR
        node_weight = np.where(apart, *((0.0, node_weight) if near else (node_weight, 0.0)))
        kernel.count(apart)
    g = 0.0
    if moves:
        grid = gas.of_grid(d)
        v_l, v_r = kernel.read("v_l", PLANES, grid), kernel.read("v_r", PLANES, grid)
        g = gas.volume_flux(a_l, v_l, a_r, v_r)
    rise = 0.0
    if form.raises:
        (Phi_l,), (Phi_r,) = (kernel.read(f"potential_{side}", ROWS, 1) for side in "lr")
        rise = Phi_r - Phi_l
    both = form.pair(gas, l, r, a_l, a_r, g, rise, near)
    if shocks:
        (keep,) = kernel.read("keep", ROWS, 1)
        both = tuple(scale(keep, F) for F in both)
    if viscous:
        s = mean(kernel.read("s_l", ROWS, d + 1), kernel.read("s_r", ROWS, d + 1))
        both = tuple((F[0], *sub(F[1 : d + 2], s), *F[d + 2 :]) for F in both)
    if moves:
        both = tuple((*F, -g) for F in both)
    less, more = (scale(row_weight * node_weight, numbers) for numbers in both)
    low, high = (kernel.read(name, ROWS, len(less)) for name in ("low", "high"))
    kernel.store("low", ROWS, sub(low, less))
    kernel.store("high", ROWS, add(high, more))
    return kernel


def _rates(gas, d, sums, moves, at_pressure):
    """at_pressure: where w has p - tau_o, which acts around an axis."""
    kernel = Kernel("gas_rates", "J_t, the rates of J rho, J rho u, J E, the force, of a row.")
    per_row_weight = kernel.number("per_row_weight")
    (per_node_weight,) = kernel.read("per_node_weight", ROWS, 1)
    total = add(*(kernel.read(name, ROWS, sums + moves) for name in ("low", "high")))
    total = scale(per_row_weight * per_node_weight, total)
    mass, *momentum, energy = total[: d + 2]
    if gas.around:
        (push,) = kernel.read("w", ROWS, 1, at_pressure)
        (source,) = kernel.read("source", PLANES, 1)
        momentum[-1] = momentum[-1] + push * source
    kernel.store("k", ROWS, (total[-1] if moves else 0.0, mass, *momentum, energy))
    if sums > d + 2:
        kernel.store("supplied", f"{{c}} + {{i}} * {d + 1}", (*total[d + 2 : sums], 0.0))
    return kernel


def _viscous(gas, d, stencil):
    says = "The viscous fluxes a^k . f_v of all axes k of a row's nodes."
    kernel = stencil.kernel("gas_viscous", says)
    gas, w = kernel.parameters(gas), kernel.read("w", ROWS, d + 5)
    at_J, at_pressure = columns_beside(d)
    (J,) = kernel.read("w", ROWS, 1, at_J)
    areas = [kernel.read("metrics", PLANES, d, k * d) for k in range(d)]
    of_z = {"count": d + 1, "apart": f" * {d + 1} * ROW"}
    slopes = [slope(kernel, "z", ROWS, k, stencil, **of_z) for k in range(d)]
    scaled, inverse = outer(slopes[0][:-1], areas[0]), scale(slopes[0][-1], areas[0])
    for D_z, area in zip(slopes[1:], areas[1:], strict=True):
        scaled, inverse = add(scaled, outer(D_z[:-1], area)), along(inverse, D_z[-1], area)
    scaled, inverse = scale(1.0 / J, scaled), scale(1.0 / J, inverse)
    u_r = gas.velocity(w)[-1]
    e = u_r * kernel.read("source", PLANES, 1)[0] / J if gas.around else 0.0
    (stress, of_hoop), heat = gas.viscous_stress(w, scaled, inverse, e), gas.conduction(w, inverse)
    if gas.around:
        kernel.store("w", ROWS, (named(w).p - of_hoop,), at_pressure)
    for k, area in enumerate(areas):
        kernel.store("s", ROWS, gas.viscous_flux(w, stress, heat, area), k * (d + 1))
    return kernel
