"""Rates of the nodes of a solid block, without fluxes through its faces. Equations are those of
fsipetsc.equations.elasticity, derivatives D_k along an axis and D°_k, without the flux through its
ends, those of fsipetsc.operators.slopes. With the tractions t^k = P A^k the rates are

    D_t = v,    J0 m0 v_t = sum_k D°_k t^k,
    J0 m0 e_t = v . sum_k D°_k t^k + sum_k t^k . D_k v.

The power is, pair by pair, S_il (t_i . v_l + t_l . v_i)/2 with the weights S_il of
fsipetsc.operators.sbp: nothing is lost or won.

F, T and t^k of a node are found from displacements, and rates from them; between them there is
conduction. The kernels are at the end.
"""

from functools import partial
from types import SimpleNamespace

from fsipetsc.equations.tensors import add_unit, apply, column_sums, product, transpose
from fsipetsc.equations.vectors import add, along, dot, scale, total
from fsipetsc.kernels.kernel import OWNED, PLANES, ROWS, Kernel
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.operators.slopes import Stencil, slope
from fsipetsc.scheme.sweep import Sweep, ends_of, in_order, order

#: most nodes of a tile along the first axis, and most rows, for d = 1, 2, 3
TILES = ((1024, 1), (128, 1), (64, 32))


class SolidSweep(Sweep):
    """The sweeps of a part of a block. steps, to_strains: (n, 2) stages and layers
    (fsipetsc.scheme.sweep.order) of rates and of strains. A row has unknowns, strains F, tractions
    t^k, temperatures T and heats A^k . h of its nodes.
    """

    def __init__(self, solid, d, kernels, bands, patch):
        reaches = 2 + len(kernels.conduct)
        super().__init__(solid, d, kernels, bands, patch, TILES[d - 1], reaches, reaches + 1)
        S = in_order(bands, d)[2].S
        self.steps = order(S, self.ranges)
        self.to_strains = order(S, (self.ranges[0], self.ranges[-1]))

    def sweep(self, part, found, y, q, f):
        """Store the rates of the owned nodes, or what becomes of them (fsipetsc.scheme.sweep), in
        f; y, q: planes of owned nodes, of all with a halo of 2 interior reaches, 3 with conduction.
        """
        kernels = self.kernels
        prestress = {} if part.prestress is None else {"prestress": part.prestress}
        self.begin(part, found, y, q, f, inverses=part.inverses, **prestress)
        heats = [partial(self.run, kernels.conduct)] * len(kernels.conduct)
        every = enumerate((self.load, partial(self.run, kernels.pulls), *heats, self.find_rates))
        self.take(self.steps, [(do, box, box) for box, do in every])

    def sweep_strains(self, part, y, q, F):
        """Fill planes F of the owned nodes; y, q: of their unknowns, and with one reach more."""
        own, kernels = 2 + len(self.kernels.conduct), self.kernels.strains
        self.begin(part, None, y, q, F, inverses=part.inverses)
        self.take(self.to_strains, ((self.load, 0, 0), (partial(self.run, kernels), own, own)))

    def find_rates(self, x, n, y, z):
        self.run(self.kernels.rates, x, n, y, z)
        self.store(x, n, y, z)


def solid_kernels(solid, d, order, prestressed):
    """All kernels of a solid in d dimensions; order: of the operators. strains, pulls, rates:
    those of any nodes, and of those inside of a block. conduct: one, or none without conduction.
    """
    stencil = Stencil(order // 2, OPERATORS[order].reach)
    both = stencil.both
    return SimpleNamespace(
        stencil=stencil,
        load=_load(d),
        strains=tuple(_strain(solid, d, of) for of in both),
        pulls=tuple(_pull(solid, d, of, prestressed) for of in both),
        rates=tuple(_accelerate(solid, d, of) for of in both),
        conduct=(_conduct(solid, d, both[0]),) * (solid.kappa > 0.0),
        ends=ends_of(2 * d + 1),
        dof=2 * d + 1,
        numbers=numbers_of(d) | {"strains": solid.strains(d)},
    )


def numbers_of(d):
    """How many numbers a row has of each node, by name, without F."""
    return {"unknowns": 2 * d + 1, "tractions": d * d, "temperatures": 1, "heats": d}


def _slopes(kernel, stencil, f, first, count, free=False):
    """D_k of so many planes of f for each axis k, which begin at its number of ``first``."""
    apart, every = f" * {numbers_of(len(first))[f]} * ROW", enumerate(first)
    return total(slope(kernel, f, ROWS, k, stencil, count, at, free, apart) for k, at in every)


def _load(d):
    kernel = Kernel("solid_load", "The unknowns of the nodes of a row.")
    kernel.store("unknowns", ROWS, kernel.read("q", PLANES, 2 * d + 1))
    return kernel


def _strain(solid, d, stencil):
    says = "F = 1 + 1/J0 sum_k D_k D A^k, with the stretch of hoops."
    kernel = stencil.kernel("solid_strain", says)
    solid = kernel.parameters(solid)
    kernel.store("out", OWNED, _found_strain(kernel, solid, d, stencil))
    return kernel


def _found_strain(kernel, solid, d, stencil):
    A, (per_J0,) = kernel.read("metrics", PLANES, d * d), kernel.read("inverses", PLANES, 1)
    D_D = _slopes(kernel, stencil, "unknowns", (0,) * d, d)
    gradient = scale(per_J0, product(transpose(D_D), A))
    D = kernel.read("unknowns", ROWS, d) if solid.around else ()
    R = kernel.read("metrics", PLANES, 1, d * d + 1)[0] if solid.around else 0.0
    return solid.with_hoops(add_unit(1.0, gradient), D, R)


def _pull(solid, d, stencil, prestressed):
    """Add a prestress S to P, and take its energy S : (F - 1)/m0 from that of which T is made."""
    says = "F, T, and the tractions t^k = (P + S) A^k with a prestress S."
    kernel, conducts = stencil.kernel("solid_pull", says), solid.kappa > 0.0
    solid, A = kernel.parameters(solid), kernel.read("metrics", PLANES, d * d)
    F, v = _found_strain(kernel, solid, d, stencil), kernel.read("unknowns", ROWS, d, d)
    if conducts or solid.around:
        kernel.store("strains", ROWS, F)
    (e,) = kernel.read("unknowns", ROWS, 1, 2 * d)
    S = kernel.read("prestress", PLANES, d * d) if prestressed else ()
    if prestressed and not solid.coupled:
        e = e - dot(S, add_unit(-1.0, F[: d * d])) / solid.m0
        kernel.store("unknowns", ROWS, (e,), 2 * d)
    T = solid.temperature(v, e, F)
    tractions = product(A, transpose(solid.stress_at(F, T)))
    if prestressed:
        tractions = add(tractions, product(A, transpose(S)))
    if conducts:
        kernel.store("temperatures", ROWS, (T,))
    kernel.store("tractions", ROWS, tractions)
    return kernel


def _conduct(solid, d, stencil):
    kernel = Kernel("solid_conduct", "A^k . h with grad T = 1/J0 sum_k A^k D_k T.")
    solid = kernel.parameters(solid)
    A, (per_J0,) = kernel.read("metrics", PLANES, d * d), kernel.read("inverses", PLANES, 1)
    D_T = _slopes(kernel, stencil, "temperatures", (0,) * d, 1)
    gradient = scale(per_J0, apply(transpose(A), D_T))
    F = kernel.read("strains", ROWS, solid.strains(d))
    kernel.store("heats", ROWS, apply(A, solid.heat_flux(F, gradient)))
    return kernel


def _accelerate(solid, d, stencil):
    says = "The rates v, Div P/m0 + b, Div (P^T v + h)/m0 + b . v."
    kernel = stencil.kernel("solid_rates", says)
    conducts, solid = solid.kappa > 0.0, kernel.parameters(solid)
    (per_mass,) = kernel.read("inverses", PLANES, 1, 1)
    v, t = kernel.read("unknowns", ROWS, d, d), kernel.read("tractions", ROWS, d * d)
    force = column_sums(_slopes(kernel, stencil, "tractions", range(0, d * d, d), d, True))
    power = dot(v, force) + dot(t, _slopes(kernel, stencil, "unknowns", (d,) * d, d))
    if conducts:
        power = power + total(_slopes(kernel, stencil, "heats", range(d), 1, True))
    acceleration = along(solid.force, per_mass, force)
    if solid.around:
        F = kernel.read("strains", ROWS, solid.strains(d))
        (e,) = kernel.read("unknowns", ROWS, 1, 2 * d)
        (R,) = kernel.read("metrics", PLANES, 1, d * d + 1)
        acceleration = solid.with_hoop_force(acceleration, v, e, F, R)
    energy = per_mass * power + dot(solid.force, v)
    kernel.store("k", ROWS, (*v, *acceleration, energy))
    return kernel
