"""A shock along an elastic half space, faster than its waves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fsipetsc.verify.entry import Bound, Curve, Entry, Measured, reference

TEXT = """
A plane shock in gas above runs along the face Y = 0 of an elastic half space with the speed 1,
faster than its waves. A P and an S wave follow in the solid; between fronts all is constant.

* gas: perfect, γ = 1.4, R = 1, ahead ρ = 0.1114827, u = v = 0, T = 0.09375, inviscid
* solid: linear elastic, density 1, λ = 0.1398307, μ = 0.07203351, at rest under the pressure ahead
* -0.5 < X < 1, -0.75 < Y < 0.75; the foot of the shock is at X = 0 at t = 0 and at X = 0.5 at the
  end, t = 0.5; exact data at first and on all sides; `h` is the spacing of both grids

The shock is tilted by φ and the solid's displacement gradient is a n_P n_P + b t_S n_S. Conditions
at the face: one normal velocity, and σ e_y = -(p - p₁) A. With A = cof(F) e_y, the **deformed**
face, which the scheme has, φ = -0.0577611, a = -0.2946876, b = 0.1254254. Published states (φ =
-0.0604705, a = -0.3079172, b = 0.1229946; these are the numbers of Banks et al., quoted) follow
when A is divided by its length: the direction is that of the deformed face, the area that of the
undeformed one. The published 0.06047047 rad is the tilt of the shock; the face is deflected by
0.15514 rad.

Errors: *gas*, *solid*: L1 norms of all unknowns together, over the area, which jumps bound to the
first order; *plateau*: of means behind the shock in 0.15 < X < 0.3, 0.05 < Y < 0.15, and in the
solid, between both waves and behind both, relative. The difference of both kinds of states is 5e-2
in the solid.
"""
#: (block, unknown, column of the reference, low and high X, low and high Y) of plateaus at t = 0.5
PLATEAUS = (
    ("gas", "rho", "rho", 0.15, 0.3, 0.05, 0.15),
    ("gas", "T", "T", 0.15, 0.3, 0.05, 0.15),
    ("half space", "v", "solid v", 0.0, 0.25, -0.06, 0.01),
    ("half space", "v", "solid v behind P", -0.02, 0.06, -0.25, -0.18),
)
#: largest errors of plateaus by h
PLATEAU = {1 / 40: 0.07, 1 / 80: 0.02}


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Norms, and means over plateaus."""
    table = reference("superseismic")
    with solve("superseismic", fsi_order=order, fsi_h=h) as run:
        errors = {
            "gas": run.errors["fluid"]["combined"],
            "solid": run.errors["solid"]["combined"],
        }
        for name, unknown, column, low, high, below, above in PLATEAUS:
            layer = next(layer for layer in run.layers if layer.name == name)
            X, Y = np.meshgrid(layer.X, layer.Y)
            inside = (X > low) & (X < high) & (Y > below) & (Y < above)
            mean, exact = layer.frame(-1)[unknown][inside].mean(), table[column][0]
            errors[f"plateau, {column}"] = abs(float(mean / exact) - 1.0)
            if column == "solid v":
                x, ours = layer.X, layer.frame(-1)[unknown][-1]
    steps, face = np.array([x[0], 0.5, 0.5, x[-1]]), table["solid v"][0] * np.array([1, 1, 0, 0])
    return Measured(errors, Curve(("X on the face", "v of the face"), x, ours, steps, face))


ENTRY = Entry(
    name="superseismic",
    title="Superseismic shock over an elastic half space",
    source="verify/superseismic.py, after Banks, Henshaw, Schwendeman (2012)",
    text=TEXT,
    levels={
        "quick": {4: (1 / 20, 1 / 40)},
        "full": {2: (1 / 20, 1 / 40), 4: (1 / 20, 1 / 40, 1 / 80)},
    },
    measure=measure,
    bounds={
        (name, order): bound
        for order in (2, 4)
        for name, bound in (
            ("gas", Bound(0.7)),
            ("solid", Bound(0.5)),
            *((f"plateau, {plateau[2]}", Bound(at=PLATEAU)) for plateau in PLATEAUS),
        )
    },
)
