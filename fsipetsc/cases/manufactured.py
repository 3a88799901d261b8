"""Manufactured solutions: all unknowns are given, and the forcing is what the equations then lack.

Formulas run once on symbols, which gives their derivatives (fsipetsc.kernels.symbols); numbers come
from the record. They are functions of (*X, t): d arrays of coordinates, of one shape, and the time.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import zip_longest
from typing import Any

import numpy as np

from fsipetsc import BlockProblem, ElasticSolid, FluidLayer, Layer, Option, Problem, SolidLayer
from fsipetsc.blocks.conditions import Given, NoSlip
from fsipetsc.boundaries import Dirichlet
from fsipetsc.cases.common import Opt, case, gas_of, materials, solid_of, stack
from fsipetsc.cases.flows import disk_in_gas
from fsipetsc.checks import Array, Fields
from fsipetsc.equations import elementary, tensors
from fsipetsc.equations.vectors import add, along, dot, scale, sub
from fsipetsc.kernels.symbols import Record, derivatives, replay

Numbers = Sequence[Any]
TURN = 2.0 * np.pi


def recorded(count: int, formula: Callable[..., Numbers]) -> Callable[..., list[Any]]:
    """A function of so many arrays of one shape, and of numbers, by a formula that runs once. The
    numbers at the end, such as the time, are 0 where they are not given.
    """
    record = Record()
    given = [record.given(f"x{k}") for k in range(count)]
    values_of = replay([record.constant(number) for number in formula(*given)])

    def called(*where: Any) -> list[Any]:
        known = dict(zip_longest(given, where, fillvalue=0.0))
        # numpy's logarithms have other bits on other processors
        found = values_of(known, log=elementary.log, log1p=lambda x: elementary.log(1.0 + x))
        return [value + 0.0 * where[0] for value in found]

    return called


def gradient(f: Numbers, X: Numbers) -> Numbers:
    """Return df_i/dX_k, a tensor of vectors f."""
    by_axis = [derivatives(f, x) for x in X]
    return tuple(changes[i] for i in range(len(f)) for changes in by_axis)


def lack(U: Numbers, flux: Sequence[Numbers], where: Numbers) -> Numbers:
    """Return U_t + sum over the axes of the derivatives of fluxes."""
    *X, t = where
    rates = derivatives(U, t)
    for along_axis, x in zip(flux, X, strict=True):
        rates = add(rates, derivatives(along_axis, x))
    return rates


class Solution:
    """An exact solution in d dimensions of a gas and a solid. A subclass has functions of (*X, t):
    displacement of the solid, that of the gas's grid (moved), u less the velocity of this grid
    (drift), the temperature T of both, the density rho of the gas.

    From them follow exact_gas (rho, u_1 … u_d, T) and exact_solid (v_1 … v_d, T, x_1 … x_d);
    force_gas, what drives (rho, rho u_1 … rho u_d, e) per volume at a point of the grid, and
    force_solid (v_1 … v_d, T, x_1 … x_d). jump: of these and the normal from gas to solid, traction
    and heat per reference area that the solid gets at the interface beside what the gas gives it.
    """

    def __init__(self, d: int, opt: Opt) -> None:
        self.d, self.fluid, record = d, gas_of(opt), partial(recorded, d + 1)
        self.body = ElasticSolid(1.0, 2.0, opt["solid_kappa"], 2.0, 1.5, law=opt["solid_law"])
        self.exact_gas, self.exact_solid = record(self.gas_fields), record(self.solid_fields)
        self.force_gas, self.force_solid = record(self._on_gas), record(self._on_solid)
        self.jump = recorded(2 * d + 1, self._jump)

    def gas_fields(self, *where: Any) -> Numbers:
        w = derivatives(self.moved(*where), where[-1])
        return (self.rho(*where), *add(w, self.drift(*where)), self.T(*where))

    def solid_fields(self, *where: Any) -> Numbers:
        D = self.displacement(*where)
        return (*derivatives(D, where[-1]), self.T(*where), *add(where[:-1], D))

    def gas(self, *where: Any) -> tuple[Numbers, Sequence[Numbers], Any]:
        """J (1, rho, rho u, e); along each axis, with its metric vector a = det(x_X) grad xi,

            a . (-w, rho (u - w), rho u (u - w) + p - tau, e (u - w) + p u - tau u - kappa grad T)

        with tau = mu (grad u + (grad u)^T - 2/3 div u) and the grid's velocity w; and J.
        """
        (*X, t), fluid, (rho, *u, T) = where, self.fluid, self.gas_fields(*where)
        past, moved = self.drift(*where), self.moved(*where)
        x_X, w = tensors.add_unit(1.0, gradient(moved, X)), derivatives(moved, t)
        a, J = tensors.cofactor(x_X), tensors.determinant(x_X)
        grad_u = scale(1.0 / J, tensors.product(gradient(u, X), tensors.transpose(a)))
        grad_T = scale(1.0 / J, tensors.apply(a, gradient((T,), X)))
        tau = scale(fluid.mu, add(grad_u, tensors.transpose(grad_u)))
        tau = tensors.add_unit(-2.0 / 3.0 * fluid.mu * tensors.trace(grad_u), tau)
        e = rho * (fluid.cv * T + 0.5 * dot(u, u))
        force = tensors.add_unit(rho * fluid.R * T, scale(-1.0, tau))
        heat = along(tensors.apply(force, u), -fluid.kappa, grad_T)
        # -w is the flux of J, a volume that the grid sweeps over
        pushes = (along(f, rho * u_i, past) for f, u_i in zip(tensors.rows(force), u))
        fluxes = scale(-1.0, w), scale(rho, past), *pushes, along(heat, e, past)
        flux = [tuple(dot(f, a_k) for f in fluxes) for a_k in tensors.rows(tensors.transpose(a))]
        return scale(J, (1.0, rho, *scale(rho, u), e)), flux, J

    def solid(self, *where: Any) -> tuple[Numbers, Sequence[Numbers], Any]:
        """m0 (v, alpha T), fluxes -(P, kappa_e J F^-1 F^-T grad T), and the work P : v_X."""
        (*X, t), body = where, self.body
        D, T = self.displacement(*where), self.T(*where)
        v, F = derivatives(D, t), tensors.add_unit(1.0, gradient(D, X))
        P, c = body.solid_law.stress(F), tensors.cofactor(F)
        scaled = scale(body.kappa_e / tensors.determinant(F), tensors.apply(c, gradient((T,), X)))
        heat, work = tensors.apply(tensors.transpose(c), scaled), dot(P, gradient(v, X))
        tractions = tensors.rows(tensors.transpose(P))
        flux = [scale(-1.0, (*t_k, h_k)) for t_k, h_k in zip(tractions, heat)]
        return scale(body.m0, (*v, body.alpha * T)), flux, work

    def _on_gas(self, *where: Any) -> Numbers:
        U, flux, J = self.gas(*where)
        return scale(1.0 / J, lack(U, flux, where)[1:])

    def _on_solid(self, *where: Any) -> Numbers:
        U, flux, work = self.solid(*where)
        *rates, heat = lack(U, flux, where)
        m0, alpha = self.body.m0, self.body.alpha
        return (*scale(1.0 / m0, rates), 1.0 / m0 * (heat - work) / alpha, *(0.0 for _ in rates))

    def _jump(self, *given: Any) -> Numbers:
        where, normal = given[: self.d + 1], given[self.d + 1 :]
        u = derivatives(self.displacement(*where), where[-1])
        fluxes = self.gas(*where)[1], self.solid(*where)[1]
        below, above = ([dot(normal, of_axes) for of_axes in zip(*flux)] for flux in fluxes)
        traction = below[2:-1]  # no mass goes through
        return *sub(above[:-1], traction), above[-1] - (below[-1] - dot(traction, u))


class Flat(Solution):
    """The solution of box_mms, in the coordinates p, q, eta of its three-dimensional form."""

    def _space(self, where: Numbers) -> Numbers:
        """Return p, q, 1 + .2 sin 2 pi q, eta and t."""
        p, q = (*where[:-2], *(0.125, 0.0)[self.d - 1 :])
        return p, q, 1.0 + 0.2 * np.sin(TURN * q), *where[-2:]

    def _axes(self, *vector: Any) -> Numbers:
        return tuple(vector[axis] for axis in {1: (2,), 2: (0, 2), 3: (0, 1, 2)}[self.d])

    def displacement(self, *where: Any) -> Numbers:
        p, q, ripple, eta, t = self._space(where)
        return self._axes(
            0.06 * np.sin(TURN * p + t) * np.cos(eta + 2.0 * t) * ripple,
            0.05 * np.sin(TURN * q - t) * np.cos(TURN * p + 2.0 * t) * np.sin(eta + t),
            0.08 * np.cos(TURN * p - t) * np.sin(1.5 * eta + t) * ripple,
        )

    def moved(self, *where: Any) -> Numbers:
        *along_layers, eta, t = where
        return scale(eta, self.displacement(*along_layers, 1.0, t))

    def drift(self, *where: Any) -> Numbers:
        p, q, ripple, eta, t = self._space(where)
        u, v = 0.6 * np.sin(TURN * p - t), 0.4 * np.sin(TURN * q + t)
        drift = self._axes(u, v, 0.5 * np.cos(TURN * p + 2.0 * t) * ripple)
        return scale(eta * (1.0 - eta), drift)

    def T(self, *where: Any) -> Any:
        p, _, ripple, eta, t = self._space(where)
        return 1.0 + 0.15 * np.sin(TURN * p + t) * np.cos(2.0 * eta - t) * ripple

    def rho(self, *where: Any) -> Any:
        p, _, ripple, eta, t = self._space(where)
        return 1.0 + 0.2 * np.cos(TURN * p - t) * np.sin(2.0 * eta + t) * ripple


@case(
    {"fsi_h": 1 / 16, "ts_max_time": 0.25, "fsi_output_dt": 0.05},
    Option("box_dimension", int, 2, "", "number of dimensions", (1, 2, 3)),
    Option("box_periodic", bool, True, "", "periodic along the layers; else sides are given"),
    *materials(fluid_mu=0.02, fluid_kappa=0.03, solid_kappa=0.05),
    *materials(solid_law=("neo-hookean", "log", "svk", "linear")),
)
def box_mms(opt: Opt) -> BlockProblem:
    """A manufactured solution in one to three dimensions: gas under a solid, on moving blocks.

    The interface moves and bends; traction and heat flux get their jumps there. The last axis, eta,
    goes across the two, from 0 to 1 in the gas and on to 2 in the solid; the other axes, p and q,
    go along them. Two dimensions are the plane q = 0 of three, one dimension is the line p = 1/8,
    q = 0, each without the components of vectors that point out of it.
    """
    d = opt["box_dimension"]
    exact = Flat(d, opt)

    def layer(name, material, low, of, forcing):
        sides = None if opt["box_periodic"] or d == 1 else Given(of)
        return Layer(name, material, (low, low + 1.0), of, sides=sides, forcing=forcing, exact=of)

    def supplied(*where):  # the normal is that of the axis eta
        return exact.jump(*where, *[0.0] * (d - 1), 1.0)

    below = layer("gas", exact.fluid, 0.0, exact.exact_gas, exact.force_gas)
    above = layer("solid", exact.body, 1.0, exact.exact_solid, exact.force_solid)
    wall = NoSlip(T=lambda *where: exact.exact_gas(*where)[-1])
    ends = {"lower": wall, "upper": Given(exact.exact_solid), "along": ((0.0, 1.0),) * (d - 1)}
    return stack(opt, below, above, jumps=supplied, **ends)


#: half the side of the box of body_mms and of the block in the middle of its disk
BOX, HALF = 2.0, 0.45


class Disk(Solution):
    """The solution of body_mms. The gas's grid is blended between walls and body, so its nodes have
    other labels X at each time: X + D(X, t), where they are, is solved for X.
    """

    def __init__(self, opt: Opt) -> None:
        super().__init__(2, opt)
        self._newton = recorded(5, self._nearer)
        self.exact_gas, self.force_gas = map(self._at_nodes, (self.exact_gas, self.force_gas))

    def displacement(self, X: Any, Y: Any, t: Any) -> Numbers:
        return 0.06 * np.sin(1.9 * X + 0.7 * Y + t), 0.06 * np.cos(1.3 * X - 1.7 * Y + 2.0 * t)

    moved = displacement  # the labels of all gas

    def drift(self, X: Any, Y: Any, t: Any) -> Numbers:
        drift = 0.3 * np.sin(1.4 * X - 0.6 * Y - t), 0.2 * np.cos(0.9 * X + 1.5 * Y + 2.0 * t)
        return scale((X * X + Y * Y - 1.0) / (X * X + Y * Y + 1.0), drift)

    def T(self, X: Any, Y: Any, t: Any) -> Any:
        return 1.0 + 0.15 * np.sin(1.6 * X - 1.1 * Y + t)

    def rho(self, X: Any, Y: Any, t: Any) -> Any:
        return 1.0 + 0.2 * np.cos(1.2 * X + 1.7 * Y - t)

    def _nearer(self, X: Any, Y: Any, t: Any, x: Any, y: Any) -> Any:
        """A step of Newton's from the label (X, Y) to that of the place (x, y)."""
        D = self.displacement(X, Y, t)
        F, apart = tensors.add_unit(1.0, gradient(D, (X, Y))), sub(add((X, Y), D), (x, y))
        change = tensors.apply(tensors.transpose(tensors.cofactor(F)), apart)
        return along((X, Y), -1.0 / tensors.determinant(F), change)

    def _at_nodes(self, of_labels: Callable[..., Fields]) -> Callable[..., Fields]:
        """A function of the labels of gas as one of the nodes of its grid."""

        def called(X: Array, Y: Array, t: float = 0.0) -> Fields:
            found, x = (X, Y), self.grid(X, Y, t)[:2]
            for _ in range(5):  # to round-off
                found = self._newton(*found, t, *x)
            return of_labels(*found, t)

        return called

    def grid(self, X: Array, Y: Array, t: float) -> Fields:
        """Places and velocities of the grid: nodes stay at fixed parts of each ray."""
        R = np.sqrt(X * X + Y * Y)
        far = BOX * R / np.maximum(abs(X), abs(Y))
        s, ends = (R - 1.0) / (far - 1.0), (1.0 / R, far / R)
        inner, outer = (self.exact_solid(X * end, Y * end, t) for end in ends)
        u, v, _, x, y = add(scale(1.0 - s, inner), scale(s, outer))
        return x, y, u, v


@case(
    {"fsi_h": 1 / 16, "ts_max_time": 0.1, "fsi_output_dt": 0.1},
    *materials(fluid_mu=0.02, fluid_kappa=0.03, solid_kappa=0.05),
    *materials(solid_law=("svk", "neo-hookean", "log", "linear")),
)
def body_mms(opt: Opt) -> BlockProblem:
    """A manufactured solution around a disk, on curved, joined blocks that move, in two dimensions.

    The disk of five blocks is in a square box of gas of four. All unknowns are given on the outer
    walls, which move, too. -fsi_h is over the side of each block.
    """
    exact, n = Disk(opt), round(1.0 / opt["fsi_h"])
    walls = {"x": lambda *at: exact.grid(*at)[:2], "velocity": lambda *at: exact.grid(*at)[2:]}
    solid = exact.body, exact.exact_solid, exact.force_solid, exact.exact_solid
    gas = exact.fluid, exact.exact_gas, exact.force_gas, exact.exact_gas
    sides = [Given(exact.exact_gas, **walls)] * 4

    def to_box(q, xi):
        """From the circle to a side of the box along rays."""
        angle = np.pi / 4 * (2.0 * (xi[1] + q) - 1.0)
        ray = np.stack([np.cos(angle), np.sin(angle)])
        return tuple((1.0 - xi[0] + xi[0] * BOX / np.abs(ray).max(axis=0)) * ray)

    def supplied(X, Y, t):
        return exact.jump(X, Y, t, *scale(-1.0 / np.sqrt(X * X + Y * Y), (X, Y)))

    return replace(disk_in_gas(1.0, HALF, (n, n, n), solid, gas, to_box, sides), jumps=supplied)


@case(
    {"fsi_h": 0.0125, "fsi_coupling": "projection", "ts_max_time": 0.45, "fsi_output_dt": 0.05},
    *materials(fluid_mu=0.01, fluid_kappa=0.03, fluid_gamma=1.4, fluid_R=1.0),
    *materials(solid_modulus=10.0, solid_kappa=0.02, solid_density=2.0, solid_alpha=1.0),
)
def mms(opt: Opt) -> Problem:
    """A manufactured solution in fluid | solid | fluid: errors against the exact one (Sec. 5.1).

    The fields (5.1), (5.2) are given in the coordinate X of each layer's own grid; x is given in
    the solid alone. So the forcing of a fluid contains the exact velocity s of its frame, that at
    its interface point X_I, and the boundaries lie at X = X_I + x_boundary - x(X_I, t).
    """
    gas, solid = gas_of(opt), solid_of(opt)

    def in_gas(X, t=0.0):
        u = np.cos(2.0 * X + 0.47) * np.sin(t)
        return 1 + 0.5 * np.sin(2 * X) * np.cos(t), u, 10 + np.cos(2 * X) * np.sin(3 * t)

    def in_solid(X, t=0.0):
        """Return (u, sigma, T, x)."""
        g = 1 + X + 0.2 * np.sin(2 * np.pi * X)
        sigma, T = np.sin(t * t) * np.sin(2 * X), 5 + np.cos(t) * np.sin(3 * X)
        return t * g, sigma, T, X + 0.5 * t * t * g

    def on_gas(X_I, X, t):
        """What the exact solution leaves over in (4.20)."""
        rho, u, T = fields = in_gas(X, t)
        (rho_t, u_t, T_t), (rho_X, u_X, T_X) = (derivatives(fields, y) for y in (t, X))
        past, pushing = u - in_gas(X_I, t)[1], gas.R * rho * T - 4 / 3 * gas.mu * u_X
        pushed, conducted = derivatives((pushing, gas.kappa * T_X), X)
        mass = rho_t + rho_X * past + rho * u_X
        force = rho * (u_t + past * u_X) + pushed
        heat = rho * gas.cv * (T_t + past * T_X) + pushing * u_X - conducted
        return mass, mass * u + force, mass * (gas.cv * T + 0.5 * u * u) + u * force + heat

    def on_solid(X, t):
        """What the exact solution leaves over in (4.19), with p = 0."""
        fields = in_solid(X, t)
        (u_t, sigma_t, T_t, _), (u_X, sigma_X, T_X, x_X) = (derivatives(fields, y) for y in (t, X))
        conducted = derivatives([solid.kappa_e * T_X / x_X], X)[0]
        rates = u_t - sigma_X / solid.m0, sigma_t - solid.K / x_X * u_X
        return *rates, T_t - (fields[1] * u_X + conducted) / (solid.alpha * solid.m0), 0.0

    def left_over(X, t):
        """Of u_s = u_f, the stress, T_s = T_f and the heat-flux condition."""
        (rho, u, T), (v, sigma, T_s, x) = in_gas(X, t), in_solid(X, t)
        (u_X, T_X), (T_s_X, x_X) = derivatives((u, T), X), derivatives((T_s, x), X)
        stress = sigma + gas.R * rho * T - 4 / 3 * gas.mu * u_X
        return v - u, stress, T_s - T, solid.kappa_e / x_X * T_s_X - gas.kappa * T_X

    def fluid(name, X, X_I, x):  # x: the boundary
        end = Dirichlet(x, lambda t: in_gas(X_I + x - in_solid(X_I, t)[3], t))
        return FluidLayer(name, gas, X, in_gas, recorded(2, partial(on_gas, X_I)), in_gas), end

    left, begin = fluid("left", (0.25, 1.0), 1.0, 0.25)
    middle = SolidLayer("solid", solid, (1.0, 2.0), in_solid, recorded(2, on_solid), in_solid)
    right, end = fluid("right", (2.0, 4.0), 2.0, 4.0)
    jumps = recorded(2, lambda k, t: left_over(k + 1.0, t))
    return Problem((left, middle, right), begin, end, jumps=jumps, units="none")
