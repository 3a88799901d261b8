"""What sweeps of gases and of solids have in common.

Nodes are swept in tiles: ranges along the first axis, and along the second one of three. The layers
of a tile along the last axis are taken one after the other, and arrays keep few of them, in a ring.

Where nothing else adds to the rates k of nodes, their sweep makes the next stage at once, and k
needs no memory. The classical Runge-Kutta method from the solution y has the stages

    y1 = y + dt/2 k(y),   y2 = y + dt/2 k(y1),   y3 = y + dt k(y2)

and, as y_1 - y is dt/2 k(y) and so on, without a sum that is kept from stage to stage, the solution

    y + 1/3 ((y1 - y) + 2 (y2 - y) + (y3 - y)) + dt/6 k(y3)

With the other nodes, whose stages conditions may change, ``advance`` of
fsipetsc.scheme.plan does the same after all is added, with such a sum.
"""

import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.equations.vectors import add, along, sub
from fsipetsc.kernels.kernel import OWNED, Kernel, c_source, unit
from fsipetsc.kernels.loops import each, either, pick, when, whole

#: what is stored: k, the next stage, the solution
RATES, STAGE, LAST = range(3)
KINDS = "rates", "next", "last"


def store(kernel: Kernel, kind: int, k: Sequence[Any]) -> None:
    """Let a kernel store what becomes of the rates k of its nodes."""
    if kind == RATES:
        kernel.store("next", OWNED, k)
        return
    a = kernel.number("a")
    if kind == STAGE:
        kernel.store("next", OWNED, along(kernel.read("y", OWNED, len(k)), a, k))
        return
    y = kernel.read("next", OWNED, len(k))  # the solution, which becomes the next one
    one, two, three = (sub(kernel.read(n, OWNED, len(k)), y) for n in ("y1", "y2", "y3"))
    change = along(add(one, three), 2.0, two)
    kernel.store("next", OWNED, along(along(y, 1.0 / 3.0, change), a, k))


def kept(make: Callable[..., Any]) -> Callable[..., Any]:
    """Let a function that makes kernels make those of the same laws once. What a case brings may
    change from run to run, and its kernels are made anew.
    """
    known = lru_cache(32)(lambda said, *given: make(*given))  # said: 1 is another text than 1.0
    return lambda *given: known(repr(given), *given) if _is_ours(given) else make(*given)


def _is_ours(value: Any) -> bool:
    """Whether laws are numbers and tuples of classes that stand in the package."""
    kind = type(value)
    if not kind.__module__.startswith(("builtins", "fsipetsc.")):
        return False
    stands = vars(sys.modules[kind.__module__]).get(kind.__name__) is kind
    return stands and (not isinstance(value, tuple) or all(map(_is_ours, value)))


def text_of(kernels: Any, d: int, row: int, order: int) -> str:
    """The C code that sweeps of a block in d dimensions need. kernels: a record that has kernels,
    tuples of them, and other data. row: how many numbers a row of a tile has room for. order: of
    the operators.
    """
    nested = (one if isinstance(one, tuple) else (one,) for one in vars(kernels).values())
    every = [kernel for some in nested for kernel in some if isinstance(kernel, Kernel)]
    texts, pairs = [kernel.text for kernel in every], f"#define PAIRS {order // 2}"
    if d == 3:
        texts = [pairs, *texts, c_source("fsipetsc.blocks", "cube.c")]
    return unit(f"#define ROW {row}\n", *texts)


def order(S: Any, ranges: Sequence[tuple[int, int]]) -> NDArray[np.int64]:
    """(n, 2) stages and layers in the order in which a sweep takes them, each as late as may be.

    ranges: of the layers of each stage. Before a layer a stage needs all from the stage before it
    that have pairs with this layer, by the weights S of pairs along the last axis.
    """
    ahead = [int(np.flatnonzero(of_layer).max(initial=0)) for of_layer in S.T]
    found, begun = [], [begin for begin, _ in ranges]

    def take(stage: int, last: int) -> None:
        while begun[stage] <= min(last, ranges[stage][1] - 1):
            layer = begun[stage]
            if stage > 0:
                take(stage - 1, layer + ahead[layer])
            found.append((stage, layer))
            begun[stage] += 1

    take(len(ranges) - 1, ranges[-1][1])
    return np.array(found, np.int64)


def pieces(begin: int, count: int, most: int, multiple: int = 1) -> list[tuple[int, int]]:
    """Ends of pieces, about equal, of at most ``most`` nodes; a multiple of some number in each."""
    size = -(-count // -(-count // most))
    size += -size % multiple
    ends = range(begin, begin + count, size)
    return [(a, min(a + size, begin + count)) for a in ends]


def in_order(of_axes: Any, d: int) -> Any:
    """Return three numbers in the order first axis, second one of three, last one."""
    return (of_axes[0], of_axes[2], of_axes[1]) if d == 2 else tuple(of_axes)


class Sweep(SimpleNamespace):
    """What sweeps know of the nodes of a part, by their numbers x, y, z along the first axis, the
    second one of three, and the last one.
    """

    def begin(self, part: Any, found: Any, y: Any, q: Any, f: Any) -> None:
        """Record what follows for a part. found: see fsipetsc.scheme.plan. y: planes of the
        owned nodes of a state, q: of all with the halo, f: of what is found.
        """
        self.part, self.found, self.d = part, found, len(part.like)
        self.own, self.sizes, self.first = (in_order(of_axes, self.d) for of_axes in part.patch)
        self.end = [first + n for first, n in zip(self.first, self.own, strict=True)]
        self.N, self.M = part.metrics.shape[1], part.masses.shape[0]
        self.y, self.q, self.f = y, q, f

    def ghosted_at(self, x: Any, y: Any, z: Any) -> Any:
        """The number of a node in ghosted arrays."""
        return (z * self.sizes[1] + y) * self.sizes[0] + x

    def own_at(self, x: Any, y: Any, z: Any) -> Any:
        """Its number among the owned nodes."""
        row = (z - self.first[2]) * self.own[1] + (y - self.first[1])
        return row * self.own[0] + (x - self.first[0])

    def loaded(self, x: Any, to: Any, y: Any, z: Any) -> Any:
        """Yield parts of a row of nodes x … to - 1: where they begin, how many they are, and the
        unknowns of the first one, how far their planes are apart. Owned nodes are read from y.
        """
        ends = zip(self.first, self.end, strict=True)
        for begin, n, own in parts(x, to, y, z, ends):
            place, other = self.own_at(begin, y, z), self.ghosted_at(begin, y, z)
            q = either(own, self.y[0, place:], self.q[0, other:])
            yield begin, n, q, pick(own, self.M, self.N)

    def stored(self, x: Any, to: Any, y: Any, z: Any) -> Any:
        """Yield parts of a row of owned nodes: where they begin, how many they are, and what is
        stored of them.
        """
        kind = whole(self.found.stage[0])
        for begin, n, free in parts(x, to, y, z, self.part.free, kind != RATES):
            yield begin, n, pick(free, kind, RATES)

    def run(self, kernels: Any, kind: Any, n: Any, own: Any, **given: Any) -> None:
        """Run the kernel of a kind of what is stored, from the owned node ``own`` on."""
        worlds = {"y": self.found.y}
        worlds |= dict(zip(("y1", "y2", "y3"), self.found.stages, strict=True))
        given |= {name: world[self.part.begin + own :] for name, world in worlds.items()}
        for number, kernel in enumerate(kernels):
            with when(kind == number):
                kernel(n, next=self.f[0, own:], M=self.M, a=self.found.stage[1], **given)


def parts(x: Any, to: Any, y: Any, z: Any, ends: Any, may_be: Any = None) -> Any:
    """Yield the parts of a row of nodes x … to - 1 that are within a box, and before and after it:
    first node, how many, whether they are within. ends: first node and first beyond along each
    axis, or None where all are within. may_be: a condition on all, too.
    """
    (begin, end), *across = ends
    for at, of_axis in zip((y, z), across, strict=True):
        if of_axis is not None:
            within = (at >= of_axis[0]) & (at < of_axis[1])
            may_be = within if may_be is None else may_be & within
    a = np.minimum(np.maximum(begin, x), to)
    a = a if may_be is None else pick(may_be, a, to)
    b = np.maximum(np.minimum(end, to), a)
    for part in each(3):
        first = pick(part == 0, x, pick(part == 1, a, b))
        n = pick(part == 0, a, pick(part == 1, b, to)) - first
        with when(n > 0):
            yield first, n, part == 1
