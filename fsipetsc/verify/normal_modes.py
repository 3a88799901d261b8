"""Small motions of gas and liquid with elastic solids: frequencies of the scheme's equations."""

from __future__ import annotations

from typing import Any

import numpy as np

from fsipetsc.verify.entry import Array, Bound, Entry, Measured, Solve, reference

#: density, speeds of P and S waves [SI]
METALS = {"steel": (7850.0, 5900.0, 3200.0), "aluminium": (2700.0, 6320.0, 3130.0)}
K = 2.0 * np.pi


def ring(order: int, h: float) -> Array:
    """s of the slowest modes [1/s]."""
    from mpi4py import MPI

    from fsipetsc.analysis.wave_modes import radial_modes
    from fsipetsc.cases import load_case
    from fsipetsc.options import defaults
    from fsipetsc.stepping.solve import build_problem

    case = load_case("ring")
    opt = {**defaults(case), "fsi_order": order, "fsi_h": h, "ring_pulse": 0.0}
    return 1j * radial_modes(build_problem(case, opt, MPI.COMM_SELF), order, 2)[:3]


def over_solid(
    order: int, h: float, fluid: Any, solid: Any, depth: float, state: tuple[float, float]
) -> Array:
    """s [1/s] of all modes of a fluid, 1 m high, over a solid; state: density and temperature."""
    from fsipetsc.analysis.wave_modes import Stack, linearise
    from fsipetsc.blocks.conditions import Clamped, NoSlip, Slip
    from fsipetsc.blocks.layers import Layer

    rho, T = state
    least = {2: 2, 4: 8, 6: 12}[order]
    below = Layer(
        *("solid", solid, (-depth, 0.0), lambda X, Y: (0.0, 0.0, T, X, Y)),
        cells=max(round(depth / h), least),
    )
    above = Layer("fluid", fluid, (0.0, 1.0), lambda X, Y: (rho, 0.0, 0.0, T), cells=round(1.0 / h))
    stack = Stack((below, above), Clamped(), NoSlip() if fluid.mu > 0.0 else Slip())
    return linearise(stack, order, round(1.0 / h), K).modes()[0]


def measure(solve: Solve, order: int, h: float) -> Measured:
    """Relative errors."""
    from fsipetsc.materials.fluid import Fluid
    from fsipetsc.materials.solid import ElasticSolid
    from fsipetsc.materials.stiffened_gas import stiffened_gas

    table, errors = reference("normal_modes"), {}

    def misfit(name: str, row: int, found: Array) -> float:
        exact = table[f"{name} real"][row] + 1j * table[f"{name} imag"][row]
        return float(np.abs(found - exact).min() / abs(exact))

    found = ring(order, h)
    errors = {f"ring, mode {k + 1}": misfit("ring", k, found) for k in range(3)}
    gas = Fluid(0.01, 0.035 / 0.72, 1.4, 1.0)
    layer = ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, p_ref=1.0, heat="elastic")
    found = over_solid(order, h, gas, layer, 0.5, (1.0, 1.0))
    errors["viscous gas"] = misfit("viscous gas", 0, found)
    for name, (density, cp, cs) in METALS.items():
        gamma, cv, p, rho = 4.4, 1000.0, 1e5, 1000.0
        p_inf = rho * 1480.0**2 / gamma - p
        T = (p + p_inf) / ((gamma - 1.0) * cv * rho)
        water = Fluid(0.0, 0.0, gamma, (gamma - 1.0) * cv, law=stiffened_gas(gamma, cv, p_inf))
        mu = density * cs**2
        numbers = mu, density * cp**2 - 2.0 * mu, 0.0, density, 1000.0
        metal = ElasticSolid(*numbers, p_ref=p, heat="elastic")
        found = over_solid(order, h, water, metal, 1.0, (rho, T))
        errors[f"water over {name}"] = misfit(f"water over {name}", 0, found)
    return Measured(errors)


NAMES = [f"ring, mode {k}" for k in (1, 2, 3)]
NAMES += ["viscous gas", *(f"water over {metal}" for metal in METALS)]
ENTRY = Entry(
    source="verify/modes.py (determinants)",
    levels={"quick": {4: (1 / 16, 1 / 24)}, "full": {4: (1 / 16, 1 / 32), 6: (1 / 24, 1 / 32)}},
    measure=measure,
    bounds={(name, order): Bound(least) for name in NAMES for order, least in ((4, 3.0), (6, 4.5))},
)
