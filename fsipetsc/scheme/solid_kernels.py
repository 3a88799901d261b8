"""The kernels of a solid block's rates: what is read at a node, which formula it goes through,
where it is stored.

A tile's arrays have planes, ``step`` apart: unknowns D, v, e, strains F with hoop stretches,
tractions t^k = P A^k, temperatures, and heat fluxes A^k . h. A row has the derivatives of these.
Metrics are read where the block has them: A^1 … A^d, J0, around an axis R.
"""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    column_sums,
    product,
    transpose,
)
from fsipetsc.equations.vectors import add, along, dot, scale, sub, total
from fsipetsc.kernels.kernel import PLANES, ROWS, SHARED, Kernel, Layout
from fsipetsc.scheme.sweep import KINDS, store

#: planes of a tile
TILE = Layout("{c} * step + {i}", "step")


def solid_kernels(solid: Any, d: int, order: int, prestressed: bool) -> SimpleNamespace:
    """All kernels of a solid in d dimensions; order: of the operators in the interior. _inside:
    those of nodes there, which have so many pairs of nodes on both sides. conduct: None without
    conduction.
    """
    pulls, stores = {}, {}
    for name, pairs in ("", 0), ("_inside", order // 2):
        slopes = Slopes(d, pairs, name)
        pulls[f"pull{name}"] = _pull(solid, d, slopes, prestressed)
        of_kinds = (_accelerate(solid, d, slopes, n, kind) for n, kind in enumerate(KINDS))
        stores[f"stores{name}"] = tuple(of_kinds)
    return SimpleNamespace(
        pairs=order // 2,
        take=_take(d),
        strain=_strain(solid, d),
        combine=_combine("first", False),
        add=_combine("add", True),
        **pulls,
        **stores,
        conduct=_conduct(solid, d) if solid.kappa > 0.0 else None,
    )


class Slopes(NamedTuple):
    """How kernels get derivatives D_k f: from rows that have them, if pairs is 0; in the interior
    from so many pairs of nodes on both sides, with weights w and distances far, axis by axis:

        D_k f = sum_m w_km (f_(i + m) - f_(i - m))

    name: what is added to the names of kernels.
    """

    d: int
    pairs: int
    name: str = ""

    def read(
        self, kernel: Kernel, f: str, first: Sequence[int], count: int, to: int
    ) -> tuple[Any, ...]:
        """D_k of so many planes of f for each axis k, which begin at its number of ``first``; to:
        where the rows have them.
        """
        if not self.pairs:
            return kernel.read("slopes", ROWS, self.d * count, to)
        found: tuple[Any, ...] = ()
        for k, plane in enumerate(first):
            D: tuple[Any, ...] = ()
            for number in range(k * self.pairs, (k + 1) * self.pairs):
                ahead, behind = (
                    kernel.read(f, TILE, count, plane, (far, number)) for far in ("far", "back")
                )
                (w,) = kernel.read("w", SHARED, 1, number)
                change = sub(ahead, behind)
                D = along(D, w, change) if D else scale(w, change)
            found += D
        return found


def _take(d: int) -> Kernel:
    kernel = Kernel("solid_take", "The unknowns of a row.")
    kernel.store("unknowns", TILE, kernel.read("q", PLANES, 2 * d + 1))
    return kernel


def _combine(name: str, adds: bool) -> Kernel:
    kernel = Kernel(
        f"solid_{name}", "w0 a + w1 b + w2 c + w3 d: terms of the derivatives of a row."
    )
    total = 0.0
    for w, f in zip(kernel.read("w", SHARED, 4), "abcd", strict=True):
        total = total + w * kernel.read(f, ROWS, 1)[0]
    (kernel.add if adds else kernel.store)("out", ROWS, (total,))
    return kernel


def _strain(solid: Any, d: int) -> Kernel:
    kernel = Kernel("solid_strain", "F = 1 + 1/J0 sum_k D_k D A^k, with the stretch of hoops.")
    solid = kernel.parameters(solid)
    kernel.store("strains", TILE, _found_strain(kernel, solid, d, Slopes(d, 0)))
    return kernel


def _found_strain(kernel: Kernel, solid: Any, d: int, slopes: Slopes) -> Any:
    A, (J0,) = kernel.read("metrics", PLANES, d * d), kernel.read("metrics", PLANES, 1, d * d)
    D_D = slopes.read(kernel, "unknowns", (0,) * d, d, 0)
    gradient = scale(1.0 / J0, product(transpose(D_D), A))
    D = kernel.read("unknowns", TILE, d) if solid.around else ()
    R = kernel.read("metrics", PLANES, 1, d * d + 1)[0] if solid.around else 0.0
    return solid.with_hoops(add_unit(1.0, gradient), D, R)


def _strain_of(kernel: Kernel, solid: Any, d: int) -> Any:
    return kernel.read("strains", TILE, len(solid.unstrained((0.0,) * d)))


def _pull(solid: Any, d: int, slopes: Slopes, prestressed: bool) -> Kernel:
    """Add a prestress S to P, and take its energy S : (F - 1)/m0 from that of which T is made."""
    says = "F, T, and the tractions t^k = (P + S) A^k with a prestress S."
    kernel, conducts = Kernel(f"solid_pull{slopes.name}", says), solid.kappa > 0.0
    solid, A = kernel.parameters(solid), kernel.read("metrics", PLANES, d * d)
    F, v = _found_strain(kernel, solid, d, slopes), kernel.read("unknowns", TILE, d, d)
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
    h = solid.heat_flux(_strain_of(kernel, solid, d), gradient)
    kernel.store("heats", TILE, apply(A, h))
    return kernel


def _accelerate(solid: Any, d: int, slopes: Slopes, number: int, kind: str) -> Kernel:
    """Store the rates that follow from D°_k t^k, D_k v and, with conduction, D°_k A^k . h."""
    says = "(v, Div P/m0 + b, Div (P^T v + h)/m0 + b . v), or what follows from these rates."
    kernel = Kernel(f"solid_{kind}{slopes.name}", says)
    conducts, solid = solid.kappa > 0.0, kernel.parameters(solid)
    per_mass = 1.0 / (kernel.read("metrics", PLANES, 1, d * d)[0] * solid.m0)
    v, t = kernel.read("unknowns", TILE, d, d), kernel.read("tractions", TILE, d * d)
    force = column_sums(slopes.read(kernel, "tractions", range(0, d * d, d), d, 0))
    power = dot(v, force) + dot(t, slopes.read(kernel, "unknowns", (d,) * d, d, d * d))
    if conducts:
        power = power + total(slopes.read(kernel, "heats", range(d), 1, 2 * d * d))
    acceleration = along(solid.force, per_mass, force)
    if solid.around:
        (e,), F = kernel.read("unknowns", TILE, 1, 2 * d), _strain_of(kernel, solid, d)
        (R,) = kernel.read("metrics", PLANES, 1, d * d + 1)
        acceleration = solid.with_hoop_force(acceleration, v, e, F, R)
    energy = per_mass * power + dot(solid.force, v)
    store(kernel, number, (*v, *acceleration, energy))
    return kernel
