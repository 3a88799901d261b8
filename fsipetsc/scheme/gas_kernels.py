"""The kernels of a gas block's rates: what is read at a node or a pair, which formula it goes
through, where it is stored.

A row of a tile has the primitive variables w of its nodes and, in viscous gases, J and the fluxes
a^k . f_v of each axis k. Metrics are read where the block has them: a^1 … a^d, the velocity of the
grid, around an axis A. On a grid that moves J has a two-point flux, too: - g, that of U = 1.
"""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations.gas import NEAR
from fsipetsc.equations.tensors import outer
from fsipetsc.equations.vectors import add, along, mean, scale, sub
from fsipetsc.kernels.kernel import PLANES, ROWS, Kernel, Layout
from fsipetsc.materials.stiffened_gas import PerfectGas, stiffened_gas
from fsipetsc.scheme.gas_force import with_force
from fsipetsc.scheme.sweep import KINDS, store

#: laws whose entropy the two-point flux of fsipetsc.equations.gas conserves
CONSERVED = PerfectGas, stiffened_gas


class Form(NamedTuple):
    """A form of convection: which flux two nodes exchange. entropy: one that conserves entropy,
    else the mean of the nodes' fluxes, which exists for any law; nothing is known of the entropy
    then. raises: whether a constant force acts on the gas, which comes from its potential, pair by
    pair (fsipetsc.scheme.gas_force); else it acts node by node.
    """

    entropy: bool
    raises: bool

    def flux(self, gas, l, r, a_l, a_r, g, near=False):
        """Return the flux of two nodes; near: their states are near one another."""
        if self.entropy:
            return gas.pair_flux(l, r, a_l, a_r, g, near)
        return gas.mean_flux(l, r, a_l, a_r, g)


def convection_of(option: str, gas: Any) -> Form:
    """Return the form that -fsi_convection asks for. auto: the entropy form where its flux
    conserves the entropy of the gas's law.
    """
    entropy = option != "divergence" and isinstance(gas.law, CONSERVED)
    return Form(entropy, entropy and any(gas.force))


def gas_kernels(gas: Any, d: int, form: Form, viscous: bool, moves: bool) -> SimpleNamespace:
    """All kernels of a gas in d dimensions. far: None where the form does not tell pairs apart;
    slope, viscous_fluxes: None without viscosity; raises: of the form. numbers, sums: what a row
    has of a node, and what is summed of it.
    """
    sums, kinds = d + 2 + d * form.raises, KINDS[:1] if form.raises else KINDS
    return SimpleNamespace(
        load=_load(gas, d, viscous),
        near=_pair(gas, d, form, viscous, moves, True),
        far=_pair(gas, d, form, viscous, moves, False) if form.entropy else None,
        stores=tuple(_store(d, sums, moves, number, kind) for number, kind in enumerate(kinds)),
        slope=_slope(gas, d) if viscous else None,
        viscous_fluxes=_viscous(gas, d) if viscous else None,
        viscous=viscous,
        raises=form.raises,
        numbers=d + 5 + viscous * (1 + d * (d + 1)),
        sums=sums + moves,
    )


def _load(gas: Any, d: int, viscous: bool) -> Kernel:
    kernel = Kernel("gas_load", "The primitive variables w of the nodes of a row, perhaps J.")
    q = kernel.read("q", PLANES, d + 3)
    kernel.store("w", ROWS, kernel.parameters(gas).primitive(q))
    if viscous:
        kernel.store("w", ROWS, q[:1], d + 5)
    return kernel


def _pair(gas: Any, d: int, form: Form, viscous: bool, moves: bool, near: bool) -> Kernel:
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
    of_row, (of_node,) = kernel.number("of_row"), kernel.read("of_node", ROWS, 1)
    if form.entropy:
        apart = gas.pair_distance(l, r) > NEAR
        of_node = np.where(apart, *((0.0, of_node) if near else (of_node, 0.0)))
        kernel.count(apart)
    g = 0.0
    if moves:
        grid = len(gas.of_grid((0.0,) * d))
        v_l, v_r = kernel.read("v_l", PLANES, grid), kernel.read("v_r", PLANES, grid)
        g = gas.volume_flux(a_l, v_l, a_r, v_r)
    F, rise, sums = form.flux(gas, l, r, a_l, a_r, g, near), 0.0, d + 2
    if form.raises:
        sums += d
        (low,), (high,) = kernel.read("potential_l", ROWS, 1), kernel.read("potential_r", ROWS, 1)
        rise = high - low
    both = with_force(gas, form, near, F, l, r, a_l, a_r, rise)
    if viscous:
        s = mean(kernel.read("s_l", ROWS, d + 1), kernel.read("s_r", ROWS, d + 1))
        both = tuple((F[0], *sub(F[1 : d + 2], s), *F[d + 2 :]) for F in both)
    if moves:
        both, sums = tuple((*F, -g) for F in both), sums + 1
    less, more = (scale(of_row * of_node, numbers) for numbers in both)
    low, high = (kernel.read(name, ROWS, sums) for name in ("low", "high"))
    kernel.store("low", ROWS, sub(low, less))
    kernel.store("high", ROWS, add(high, more))
    return kernel


def _store(d: int, sums: int, moves: bool, number: int, kind: str) -> Kernel:
    says = "J_t, the rates of J rho, J rho u, J E, the force, of a row, or what follows from them."
    kernel = Kernel(f"gas_{kind}", says)
    of_row, (of_node,) = kernel.number("of_row"), kernel.read("of_node", ROWS, 1)
    total = add(*(kernel.read(name, ROWS, sums + moves) for name in ("low", "high")))
    total = scale(of_row * of_node, total)
    store(kernel, number, (total[-1] if moves else 0.0, *total[: d + 2]))
    if sums > d + 2:
        kernel.store("supplied", Layout(f"{{c}} + {{i}} * {d + 1}"), (*total[d + 2 : sums], 0.0))
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
