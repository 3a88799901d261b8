"""A manufactured solution in one, two or three dimensions: gas under a solid, on blocks that move.

The interface moves and bends. The wall below the gas has a given temperature, the uppermost points
of the solid are given. The blocks are periodic along the other axes; with -box_periodic false all
unknowns are given at the sides. What the equations lack is their forcing; what traction and heat
flux lack at the interface is supplied.

The last axis goes across the two, 0 < eta < 1 in the gas and 1 < eta < 2 in the solid; the other
axes, p and q, go along them. With r = 1 in three dimensions and r = 0 else

    displacement of the solid  D = (.06 sin(2 pi p + t) cos(eta + 2t) (1 + .2 r sin 2 pi q),
                                    .05 sin(2 pi q - t) cos(2 pi p + 2t) sin(eta + t),
                                    .08 cos(2 pi p - t) sin(1.5 eta + t) (1 + .2 r sin 2 pi q))
    grid of the gas            x = X + eta D(p, q, 1, t),  with the velocity w = eta D_t(p, q, 1, t)
    velocity of the gas        u = w + eta (1 - eta) (.6 sin(2 pi p - t),
                                                      .4 sin(2 pi q + t),
                                                      .5 cos(2 pi p + 2t) (1 + .2 r sin 2 pi q))
    temperature of both        T = 1 + .15 sin(2 pi p + t) cos(2 eta - t) (1 + .2 r sin 2 pi q)
    density of the gas         rho = 1 + .2 cos(2 pi p - t) sin(2 eta + t) (1 + .2 r sin 2 pi q)

Two dimensions are the plane q = 0 of it, one dimension is the line p = 1/8, q = 0, each without the
components of vectors that point out of it.

Formulas run once on symbols, of which all derivatives follow (fsipetsc.kernels.symbols); what they
are at places comes from the record. Places are (*X, t), d arrays of one shape and a time.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from fsipetsc import BlockProblem, Option
from fsipetsc.blocks.conditions import Given, NoSlip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import Opt, gas_of, materials, stack
from fsipetsc.equations import elementary
from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    apply_transposed,
    cofactor,
    columns,
    determinant,
    product_transposed,
    rows,
    trace,
    transpose,
)
from fsipetsc.equations.vectors import add, along, dot, scale, sub
from fsipetsc.kernels.symbols import Record, derivatives, replay
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = (
    Option("box_dimension", int, 2, "", "number of dimensions", (1, 2, 3)),
    Option("box_periodic", bool, True, "", "periodic along the layers; else sides are given"),
    *materials(fluid_mu=0.02, fluid_kappa=0.03, solid_kappa=0.05),
    *materials(solid_law=("neo-hookean", "log", "svk", "linear")),
)
DEFAULTS = {"fsi_h": 1 / 16, "ts_max_time": 0.25, "fsi_output_dt": 0.05}

Numbers = Sequence[Any]

#: axes of the three-dimensional solution that a problem in d dimensions has
AXES = {1: (2,), 2: (0, 2), 3: (0, 1, 2)}
#: (p, q) where a problem does not have these axes
ELSEWHERE = (0.125, 0.0)
TURN = 2.0 * np.pi

#: what laws take of numpy that has other bits on other processors
SAME_BITS = {"log": elementary.log, "log1p": lambda x: elementary.log(1.0 + x)}


def recorded(count: int, formula: Callable[..., Numbers]) -> Callable[..., list[Any]]:
    """A function of so many arrays of one shape, and of numbers, by a formula that runs once."""
    record = Record()
    given = [record.given(f"x{k}") for k in range(count)]
    wanted = [record.constant(number) for number in formula(*given)]

    def called(*where: Any) -> list[Any]:
        found = replay(wanted, dict(zip(given, where, strict=True)), SAME_BITS)
        return [value + 0.0 * where[0] for value in found]

    return called


def gradient(f: Numbers, X: Numbers) -> Numbers:
    """Return df_i/dX_k, a tensor of vectors f."""
    by_axis = [derivatives(f, x) for x in X]
    return tuple(changes[i] for i in range(len(f)) for changes in by_axis)


class State(NamedTuple):
    """Conserved quantities U per reference volume, their fluxes along each axis, and what else
    changes them.
    """

    U: Numbers
    flux: Sequence[Numbers]
    source: Numbers


class Solution:
    """The exact solution in d dimensions, of a gas and a solid without units: viscosity, both
    conductivities and the law of the solid are options.

    Functions of (*X, t): exact_gas (rho, u_1 … u_d, T) and exact_solid (v_1 … v_d, T, x_1 … x_d);
    force_gas, what drives (rho, rho u_1 … rho u_d, e) per volume at a point of the grid, and
    force_solid (v_1 … v_d, T, x_1 … x_d); temperature.
    """

    def __init__(self, d: int, opt: Opt) -> None:
        self.d, self.fluid = d, gas_of(opt)
        self.body = ElasticSolid(1.0, 2.0, opt["solid_kappa"], 2.0, 1.5, law=opt["solid_law"])
        self.exact_gas = recorded(d + 1, self.gas_fields)
        self.exact_solid = recorded(d + 1, self.solid_fields)
        self.temperature = recorded(d + 1, lambda *where: (self.T(*where),))
        self.force_gas = recorded(d + 1, self._force_on_gas)
        self.force_solid = recorded(d + 1, self._force_on_solid)
        self.jump = recorded(2 * d + 1, self._jump)

    # -- the fields

    def _along(self, where: Numbers) -> tuple[Any, Any, Any]:
        """Return p, q and 1 + .2 r sin 2 pi q."""
        p, q = (*where[:-2], *ELSEWHERE[self.d - 1 :])
        return p, q, 1.0 + 0.2 * np.sin(TURN * q) if self.d == 3 else 1.0

    def _axes(self, *vector: Any) -> Numbers:
        return tuple(vector[axis] for axis in AXES[self.d])

    def displacement(self, *where: Any) -> Numbers:
        (p, q, ripple), (eta, t) = self._along(where), where[-2:]
        return self._axes(
            0.06 * np.sin(TURN * p + t) * np.cos(eta + 2.0 * t) * ripple,
            0.05 * np.sin(TURN * q - t) * np.cos(TURN * p + 2.0 * t) * np.sin(eta + t),
            0.08 * np.cos(TURN * p - t) * np.sin(1.5 * eta + t) * ripple,
        )

    def T(self, *where: Any) -> Any:
        (p, _, ripple), (eta, t) = self._along(where), where[-2:]
        return 1.0 + 0.15 * np.sin(TURN * p + t) * np.cos(2.0 * eta - t) * ripple

    def rho(self, *where: Any) -> Any:
        (p, _, ripple), (eta, t) = self._along(where), where[-2:]
        return 1.0 + 0.2 * np.cos(TURN * p - t) * np.sin(2.0 * eta + t) * ripple

    def moved(self, *where: Any) -> Numbers:
        """Return the displacement x - X of the gas's grid."""
        *along_layers, eta, t = where
        return scale(eta, self.displacement(*along_layers, 1.0, t))

    def drift(self, *where: Any) -> Numbers:
        """Return u - w, which is 0 at the interface."""
        (p, q, ripple), (eta, t) = self._along(where), where[-2:]
        drift = self._axes(
            0.6 * np.sin(TURN * p - t),
            0.4 * np.sin(TURN * q + t),
            0.5 * np.cos(TURN * p + 2.0 * t) * ripple,
        )
        return scale(eta * (1.0 - eta), drift)

    def gas_fields(self, *where: Any) -> Numbers:
        """Return (rho, u_1 … u_d, T)."""
        w = derivatives(self.moved(*where), where[-1])
        return (self.rho(*where), *add(w, self.drift(*where)), self.T(*where))

    def solid_fields(self, *where: Any) -> Numbers:
        """Return (v_1 … v_d, T, x_1 … x_d)."""
        D = self.displacement(*where)
        return (*derivatives(D, where[-1]), self.T(*where), *add(where[:-1], D))

    # -- the gas

    def gas(self, *where: Any) -> tuple[State, Any]:
        """J (1, rho, rho u, e) and, along each axis with its metric vector a = det(x_X) grad xi,

            a . (-w, rho (u - w), rho u (u - w) + p - tau, e (u - w) + p u - tau u - kappa grad T)

        with tau = mu (grad u + (grad u)^T - 2/3 div u); and J.
        """
        (*X, t), fluid = where, self.fluid
        rho, *u, T = self.gas_fields(*where)
        past, moved = self.drift(*where), self.moved(*where)
        x_X, w = add_unit(1.0, gradient(moved, X)), derivatives(moved, t)
        a, J = cofactor(x_X), determinant(x_X)
        grad_u = scale(1.0 / J, product_transposed(gradient(u, X), a))
        grad_T = scale(1.0 / J, apply(a, gradient((T,), X)))
        tau = scale(fluid.mu, add(grad_u, transpose(grad_u)))
        tau = add_unit(-2.0 / 3.0 * fluid.mu * trace(grad_u), tau)
        e = rho * (fluid.cv * T + 0.5 * dot(u, u))
        force = add_unit(rho * fluid.R * T, scale(-1.0, tau))
        heat = along(apply(force, u), -fluid.kappa, grad_T)
        # -w is the flux of J, a volume that the grid sweeps over
        pushes = (along(f, rho * u_i, past) for f, u_i in zip(rows(force), u, strict=True))
        fluxes = scale(-1.0, w), scale(rho, past), *pushes, along(heat, e, past)
        flux = [tuple(dot(f, a_k) for f in fluxes) for a_k in columns(a)]
        return State(scale(J, (1.0, rho, *scale(rho, u), e)), flux, (0.0,) * len(fluxes)), J

    def _force_on_gas(self, *where: Any) -> Numbers:
        state, J = self.gas(*where)
        return scale(1.0 / J, lack(state, where)[1:])

    # -- the solid

    def solid(self, *where: Any) -> State:
        """m0 (v, alpha T), fluxes -(P, kappa_e J F^-1 F^-T grad T), and the work P : v_X."""
        (*X, t), body = where, self.body
        D, T = self.displacement(*where), self.T(*where)
        v, F = derivatives(D, t), add_unit(1.0, gradient(D, X))
        P, c = body.solid_law.stress(F), cofactor(F)
        scaled = scale(body.kappa_e / determinant(F), apply(c, gradient((T,), X)))
        heat, work = apply_transposed(c, scaled), dot(P, gradient(v, X))
        flux = [scale(-1.0, (*t_k, h_k)) for t_k, h_k in zip(columns(P), heat, strict=True)]
        return State(scale(body.m0, (*v, body.alpha * T)), flux, (*(0.0 for _ in v), work))

    def _force_on_solid(self, *where: Any) -> Numbers:
        *rates, heat = scale(1.0 / self.body.m0, lack(self.solid(*where), where))
        return (*rates, heat / self.body.alpha, *(0.0 for _ in rates))

    # -- both

    def supplied(self, *where: Any) -> list[Any]:
        """(g_1 … g_d, g_q) at (*X, t) of the interface: traction and heat per reference area that
        the solid gets beside what the gas gives it.
        """
        *beside, eta, t = where
        normal = (*(0.0 * eta for _ in beside), 1.0 + 0.0 * eta)
        return self.jump(*beside, 1.0 + 0.0 * eta, t, *normal)

    def _jump(self, *given: Any) -> Numbers:
        """The same with the normal from gas to solid, after places and time."""
        where, normal = given[: self.d + 1], given[self.d + 1 :]
        u = derivatives(self.displacement(*where), where[-1])
        fluxes = self.gas(*where)[0].flux, self.solid(*where).flux
        below, above = ([dot(normal, of_axes) for of_axes in zip(*flux)] for flux in fluxes)
        traction = below[2:-1]  # no mass goes through
        return *sub(above[:-1], traction), above[-1] - (below[-1] - dot(traction, u))


def lack(state: State, where: Numbers) -> Numbers:
    """U_t + sum over the axes of the derivatives of fluxes - source."""
    *X, t = where
    rates = derivatives(state.U, t)
    for flux, x in zip(state.flux, X, strict=True):
        rates = add(rates, derivatives(flux, x))
    return sub(rates, state.source)


def build(opt: Opt) -> BlockProblem:
    """The gas between eta = 0 and 1, the solid between 1 and 2."""
    d = opt["box_dimension"]
    exact = Solution(d, opt)

    def layer(name, material, low, of, forcing):
        sides = None if opt["box_periodic"] or d == 1 else Given(of)
        start = lambda *X: of(*X, 0.0)  # noqa: E731
        more = {"sides": sides, "forcing": forcing, "exact": of}
        return Layer(name, material, (low, low + 1.0), start, **more)

    return stack(
        opt,
        layer("gas", exact.fluid, 0.0, exact.exact_gas, exact.force_gas),
        layer("solid", exact.body, 1.0, exact.exact_solid, exact.force_solid),
        lower=NoSlip(T=lambda *where: exact.temperature(*where)[0]),
        upper=Given(exact.exact_solid),
        along=((0.0, 1.0),) * (d - 1),
        jumps=exact.supplied,
    )
