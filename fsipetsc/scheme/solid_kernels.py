"""The kernels of a solid block's rates: what is read at a node, which formula it goes through,
where it is stored. fsipetsc/scheme/solid.c calls them.

A tile's arrays have planes, ``step`` apart: unknowns D, v, e, strains F with hoop stretches,
tractions t^k = P A^k, temperatures, and heat fluxes A^k . h. A row has the derivatives of these.
Metrics are read where the block has them: A^1 … A^d, J0, around an axis R.
"""

from typing import Any

from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    apply_transposed,
    column_sums,
    product_transposed,
    transposed_product,
)
from fsipetsc.equations.vectors import add, along, dot, scale, total
from fsipetsc.kernels.kernel import OWNED, PLANES, Kernel, Layout

#: planes of a tile, and of the derivatives of a row
TILE = Layout("step", given=True)
ROW = Layout("WIDTH")


def solid_kernels(solid: Any, d: int, prestressed: bool) -> list[Kernel]:
    """All kernels of a solid in d dimensions."""
    made = [_take(d), _strain(solid, d), _pull(solid, d, prestressed), _accelerate(solid, d)]
    return [*made, _conduct(solid, d)] if solid.kappa > 0.0 else made


def _take(d: int) -> Kernel:
    kernel = Kernel("solid_take", "The unknowns of a row.")
    kernel.store("unknowns", TILE, kernel.read("q", PLANES, 2 * d + 1))
    return kernel


def _strain(solid: Any, d: int) -> Kernel:
    kernel = Kernel("solid_strain", "F = 1 + 1/J0 sum_k D_k D A^k, with the stretch of hoops.")
    solid = kernel.parameters(solid)
    A, (J0,) = kernel.read("metrics", PLANES, d * d), kernel.read("metrics", PLANES, 1, d * d)
    gradient = scale(1.0 / J0, transposed_product(kernel.read("slopes", ROW, d * d), A))
    D = kernel.read("unknowns", TILE, d) if solid.around else ()
    R = kernel.read("metrics", PLANES, 1, d * d + 1)[0] if solid.around else 0.0
    kernel.store("strains", TILE, solid.with_hoops(add_unit(1.0, gradient), D, R))
    return kernel


def _strain_of(kernel: Kernel, solid: Any, d: int) -> Any:
    return kernel.read("strains", TILE, len(solid.unstrained((0.0,) * d)))


def _pull(solid: Any, d: int, prestressed: bool) -> Kernel:
    """A prestress S adds to P, and its energy S : (F - 1)/m0 is no part of what T follows from."""
    kernel = Kernel("solid_pull", "T, and the tractions t^k = (P + S) A^k with a prestress S.")
    solid, A = kernel.parameters(solid), kernel.read("metrics", PLANES, d * d)
    F, v = _strain_of(kernel, solid, d), kernel.read("unknowns", TILE, d, d)
    (e,) = kernel.read("unknowns", TILE, 1, 2 * d)
    S = kernel.read("prestress", PLANES, d * d) if prestressed else ()
    if prestressed and not solid.coupled:
        e = e - dot(S, add_unit(-1.0, F[: d * d])) / solid.m0
        kernel.store("unknowns", TILE, (e,), 2 * d)
    T = solid.temperature(v, e, F)
    tractions = product_transposed(A, solid.stress_at(F, T))
    if prestressed:
        tractions = add(tractions, product_transposed(A, S))
    kernel.store("temperatures", TILE, (T,))
    kernel.store("tractions", TILE, tractions)
    return kernel


def _conduct(solid: Any, d: int) -> Kernel:
    kernel = Kernel("solid_conduct", "A^k . h with grad T = 1/J0 sum_k A^k D_k T.")
    solid = kernel.parameters(solid)
    A, (J0,) = kernel.read("metrics", PLANES, d * d), kernel.read("metrics", PLANES, 1, d * d)
    gradient = scale(1.0 / J0, apply_transposed(A, kernel.read("slopes", ROW, d)))
    h = solid.heat_flux(_strain_of(kernel, solid, d), gradient)
    kernel.store("heats", TILE, apply(A, h))
    return kernel


def _accelerate(solid: Any, d: int) -> Kernel:
    """From D°_k t^k, D_k v and, with conduction, D°_k A^k . h."""
    kernel = Kernel("solid_accelerate", "(v, Div P/m0 + b, Div (P^T v + h)/m0 + b . v).")
    conducts, solid = solid.kappa > 0.0, kernel.parameters(solid)
    per_mass = 1.0 / (kernel.read("metrics", PLANES, 1, d * d)[0] * solid.m0)
    v, t = kernel.read("unknowns", TILE, d, d), kernel.read("tractions", TILE, d * d)
    force = column_sums(kernel.read("slopes", ROW, d * d))
    power = dot(v, force) + dot(t, kernel.read("slopes", ROW, d * d, d * d))
    if conducts:
        power = power + total(kernel.read("slopes", ROW, d, 2 * d * d))
    acceleration = along(solid.force, per_mass, force)
    if solid.around:
        (e,), F = kernel.read("unknowns", TILE, 1, 2 * d), _strain_of(kernel, solid, d)
        (R,) = kernel.read("metrics", PLANES, 1, d * d + 1)
        acceleration = solid.with_hoop_force(acceleration, v, e, F, R)
    energy = per_mass * power + dot(solid.force, v)
    kernel.store("rates", OWNED, (*v, *acceleration, energy))
    return kernel
