"""What sweeps of gases and of solids have in common.

Nodes are swept in tiles: ranges along the first axis, and along the second one of three. The layers
of a tile along the last axis are taken one after the other, in stages: a layer is loaded, and what
its nodes need of it is found, when rates that need them are next. Arrays keep few rows, in a ring
of layers, which fit into the fastest memory. What two tiles need is found twice by the same
operations: rates do not depend on tiles, nor on how a block is cut.

Where nothing else adds to the rates k of nodes, their sweep makes the next stage at once, and k
needs no memory. The classical Runge-Kutta method from the solution y has the stages

    y1 = y + dt/2 k(y),   y2 = y + dt/2 k(y1),   y3 = y + dt k(y2)

and, as y_1 - y is dt/2 k(y) and so on, the solution

    y + 1/3 ((y1 - y) + 2 (y2 - y) + (y3 - y)) + dt/6 k(y3)

Conditions may change the stages of the other nodes: `advance` of fsipetsc.scheme.plan makes these
after all is added, with a sum that is kept from stage to stage.
"""

from itertools import product
from types import SimpleNamespace

import numpy as np

from fsipetsc.equations.vectors import add, along, sub
from fsipetsc.kernels.kernel import OWNED, ROWS, Kernel, floats_of
from fsipetsc.kernels.loops import each, either, pick, when, whole, zeros
from fsipetsc.operators.sbp import Patch
from fsipetsc.operators.slopes import axis_of, kinds, parts

#: what is stored: k, the next stage, the solution
RATES, STAGE, LAST = range(3)
SAYS = "The rates.", "The next stage, from rates.", "The next solution, from rates."


def ends_of(dof):
    """The kernels, by kind, that store what becomes of the rates k of a row."""
    kernels = tuple(Kernel(f"store_{kind}", says) for kind, says in enumerate(SAYS))
    for kind, kernel in enumerate(kernels):
        new = k = kernel.read("k", ROWS, dof)
        if kind == STAGE:
            new = along(kernel.read("y", OWNED, dof), kernel.number("a"), k)
        elif kind == LAST:
            y = kernel.read("out", OWNED, dof)  # the solution, which becomes the next one
            one, two, three = (sub(kernel.read(n, OWNED, dof), y) for n in ("y1", "y2", "y3"))
            change = along(add(one, three), 2.0, two)
            new = along(along(y, 1.0 / 3.0, change), kernel.number("a"), k)
        kernel.store("out", OWNED, new)
    return kernels


def order(S, ranges):
    """(n, 2) stages and layers in the order in which a sweep takes them, each as late as may be.

    ranges: of the layers of each stage. Before a layer a stage needs all from the stage before it
    that have pairs with this layer, by the weights S of pairs along the last axis.
    """
    ahead = [int(np.flatnonzero(of_layer).max(initial=0)) for of_layer in S.T]
    found, begun = [], [begin for begin, _ in ranges]

    def take(stage, last):
        while begun[stage] <= min(last, ranges[stage][1] - 1):
            layer = begun[stage]
            if stage > 0:
                take(stage - 1, layer + ahead[layer])
            found.append((stage, layer))
            begun[stage] += 1

    take(len(ranges) - 1, ranges[-1][1])
    return np.array(found, np.int64)


def pieces(begin, count, most, multiple):
    """Ends of pieces, about equal, of at most ``most`` nodes; a multiple of some number in each."""
    size = -(-count // -(-count // most))
    size += -size % multiple
    ends = range(begin, begin + count, size)
    return [(a, min(a + size, begin + count)) for a in ends]


def reached(bands, box):
    """Return the box of all nodes that have pairs with those of a box, and of these."""
    found = []
    for (S, _), (begin, end) in zip(bands, box, strict=True):
        m, i = np.nonzero(S)
        l = np.minimum(i + m, S.shape[1] - 1)
        met = (begin <= i) & (i < end) | (begin <= l) & (l < end)
        found.append((min([begin, *i[met]]), max([end - 1, *l[met]]) + 1))
    return found


def in_order(of_axes, d):
    """Return three numbers in the order first axis, second one of three, last one."""
    return (of_axes[0], of_axes[2], of_axes[1]) if d == 2 else tuple(of_axes)


class Sweep(SimpleNamespace):
    """The sweeps of a part of a block: their data, beside the record of the part, and what is
    recorded of a tile. Nodes have numbers x, y, z along the first axis, the second one of three,
    and the last one, in the ghosted array. Methods take n nodes of a row from x on.

    p: parameters of the kernels. boxes: (tiles, stages, 3, 2) first node and first beyond of what
    the stages do, the last of them with the tile's own nodes; ranges: of each stage the layers in
    its box, which are those of all tiles. axes: the neighbours of the nodes
    (fsipetsc.operators.slopes); inside: three pairs, first node and first beyond of those inside of
    a block, None of axes that are not there. layers, depth: so many layers of so many rows are
    kept. tile: by name, (rows, numbers, ROW) what a row has of its nodes; margin: room in it before
    and after those of the tile. k: (dof, ROW) rates of the row at work.
    """

    def __init__(self, equations, d, kernels, bands, patch, most, reaches, kept):
        """kernels: with numbers, name -> how many a row has of each node. bands: of the ghosted
        nodes along three axes. most: nodes of a tile along the first axis, and rows. reaches: how
        often a stage needs what is around its nodes; kept: so many reaches of layers.
        """
        bands, patch = in_order(bands, d), Patch(*(in_order(of_axes, d) for of_axes in patch))
        self.kernels, self.p, boxes = kernels, np.array([*floats_of(equations), 0.0]), []
        for own in product(*map(pieces, patch.first, patch.own, (*most, patch.own[2]), (8, 1, 1))):
            stages = [own]
            for _ in range(reaches):
                stages.append(reached(bands, stages[-1]))
            boxes.append(stages[::-1])
        margin = reaches * max(band.reach for band in bands)
        self.margin = margin + -margin % 8  # whole vectors
        self.boxes, self.width = np.array(boxes), most[0] + 2 * self.margin
        self.depth = int((self.boxes[:, 0, 1, 1] - self.boxes[:, 0, 1, 0]).max())
        self.layers = kept * bands[2].reach + 1
        rows, ring = (np.arange(len(band.weight)) for band in bands[1:])
        places = None, rows, ring % self.layers * self.depth
        axes = [axis_of(band, kernels.stencil, at) for band, at in zip(bands, places, strict=True)]
        there = in_order(range(3), d)[:d]
        self.inside = tuple(axes[k].inside if k in there else None for k in range(3))
        self.axes, count = in_order(axes, d)[:d], self.layers * self.depth
        rows_of = {name: zeros((count, n, self.width)) for name, n in kernels.numbers.items()}
        self.tile = SimpleNamespace(**rows_of)
        self.k = zeros((kernels.dof, self.width))
        self.ranges = self.boxes[0, :, 2].tolist()

    def begin(self, part, found, y, q, f, **planes):
        """Record what follows for a part. found: see fsipetsc.scheme.plan. y: planes of the
        owned nodes of a state, q: of all with the halo, f: of what is found. planes: what kernels
        take of all nodes beside metrics.
        """
        self.part, self.found, self.d = part, found, part.d
        self.own, self.sizes, self.first = (in_order(of_axes, self.d) for of_axes in part.patch)
        self.end = [first + n for first, n in zip(self.first, self.own, strict=True)]
        self.N, self.M = part.metrics.shape[1], part.masses.shape[0]
        self.y, self.q, self.f = y, q, f
        self.planes = {"metrics": part.metrics, **planes}

    def take(self, steps, stages):
        """Take the stages of all tiles, in the order of ``steps``: of each one what is done with a
        row of nodes, its box, and the box whose first row is the first one.
        """
        boxes, last = self.boxes, len(stages) - 1
        for t in each(boxes.shape[0]):
            self.x0, self.y0 = boxes[t, stages[last][1], 0, 0], boxes[t, 0, 1, 0]
            self.first_row = boxes[t, stages[last][1], 1, 0]
            for s in each(steps.shape[0]):
                stage, z = steps[s, 0], steps[s, 1]
                for number, (do, box, first) in enumerate(stages):
                    with when(stage == number):
                        x = boxes[t, box, 0, 0]
                        for y in each(boxes[t, first, 1, 0], boxes[t, box, 1, 1]):
                            do(x, boxes[t, box, 0, 1] - x, y, z)

    def row(self, rows, x, y, z, first=0):
        """What an array of rows has of the nodes from one on."""
        number = z % self.layers * self.depth + (y - self.y0)
        return rows[number, first, x - self.x0 + self.margin :]

    def given(self, x, y, z):
        """What kernels take of the nodes from one on."""
        found = {name: self.row(rows, x, y, z) for name, rows in vars(self.tile).items()}
        at, own = self.ghosted_at(x, y, z), self.own_at(x, y, z)
        found |= {name: planes[0, at:] for name, planes in self.planes.items()}
        for k, i in enumerate(in_order((x, y, z), self.d)[: self.d]):
            found |= self.axes[k].given(k, i)
        found |= {"k": self.k[0, x - self.x0 + self.margin :], "out": self.f[0, own:]}
        return {**found, "N": self.N, "M": self.M, "p": self.p}

    def ghosted_at(self, x, y, z):
        """The number of a node in ghosted arrays."""
        return (z * self.sizes[1] + y) * self.sizes[0] + x

    def own_at(self, x, y, z):
        """Its number among the owned nodes."""
        row = (z - self.first[2]) * self.own[1] + (y - self.first[1])
        return row * self.own[0] + (x - self.first[0])

    def load(self, x, n, y, z):
        """Take the unknowns of a row of nodes, those of owned nodes from y."""
        ends = zip(self.first, self.end, strict=True)
        for begin, count, own in parts(x, x + n, y, z, ends):
            place, other = self.own_at(begin, y, z), self.ghosted_at(begin, y, z)
            q = either(own, self.y[0, place:], self.q[0, other:])
            given = self.given(begin, y, z) | {"q": q, "N": pick(own, self.M, self.N)}
            self.kernels.load(count, **given)

    def run(self, kernels, x, n, y, z):
        """Run a kernel on a row: that of any nodes or, if there are two, of nodes inside."""
        every = kinds(x, n, y, z, self.inside) if len(kernels) == 2 else ((x, n, 0),)
        for begin, count, kind in every:
            kernels[kind](count, **self.given(begin, y, z))

    def store(self, x, n, y, z):
        """Store the rates k of a row of owned nodes, or what follows where nothing is added."""
        found, kind = self.found, whole(self.found.stage[0])
        worlds = {"y": found.y, **dict(zip(("y1", "y2", "y3"), found.stages, strict=True))}
        for begin, count, free in parts(x, x + n, y, z, self.part.free, kind != RATES):
            own, wanted = self.part.begin + self.own_at(begin, y, z), pick(free, kind, RATES)
            given = {name: world[own:] for name, world in worlds.items()}
            for number, kernel in enumerate(self.kernels.ends):
                with when(wanted == number):
                    kernel(count, a=found.stage[1], **given, **self.given(begin, y, z))
