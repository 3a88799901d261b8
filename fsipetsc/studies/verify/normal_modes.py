"""Small motions of gas and liquid with elastic solids: frequencies of the scheme's equations."""

from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.blocks.conditions import Clamped, NoSlip, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases import load_case
from fsipetsc.cases.common import at_rest, constant
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.options import defaults
from fsipetsc.stepping.solve import build_problem
from fsipetsc.studies.verdicts import Array, Compared, Measured, Solve, closures, of_order
from fsipetsc.studies.verify.data import reference
from fsipetsc.studies.wave_modes import linearise, radial_modes

#: density, speeds of P and S waves [SI]
METALS = {
    "steel": (7850.0, 5900.0, 3200.0),
    "aluminium": (2700.0, 6320.0, 3130.0),
    "tungsten": (19250.0, 5220.0, 2890.0),
}
SHELLS = {1: "cylinder", 2: "sphere"}
K = 2.0 * np.pi


def modes_of(name: str, order: int, h: float, n: int = 0, **given: Any) -> Array:
    """s of the slowest modes of a case [1/s], of angular number n."""
    case = load_case(name)
    opt = {**defaults(case), "fsi_order": order, "fsi_h": h, **given}
    return 1j * radial_modes(build_problem(case, opt, MPI.COMM_SELF), order, n)[:3]


def metal(name: str, pressure: float) -> Any:
    """An elastic solid, free of stress under a pressure [Pa]."""
    density, cp, cs = METALS[name]
    mu = density * cs**2
    lame = density * cp**2 - 2.0 * mu
    return ElasticSolid(mu, lame, 0.0, density, 1000.0, p_ref=pressure, heat="elastic")


def over_solid(
    order: int, h: float, fluid: Any, solid: Any, depth: float, state: tuple[float, float]
) -> Array:
    """s [1/s] of all modes of a fluid, 1 m high, over a solid; state: density and temperature. The
    fluid may be a solid, too.
    """
    (rho, T), cells = state, max(round(depth / h), {2: 2, 4: 8, 6: 12}[order])
    below = Layer("solid", solid, (-depth, 0.0), at_rest(T), cells=cells)
    two = isinstance(fluid, ElasticSolid)
    start = below.initial if two else constant(rho, 0.0, 0.0, T)
    above = Layer("fluid", fluid, (0.0, 1.0), start, cells=round(1.0 / h))
    lid = Clamped() if two else NoSlip() if fluid.mu > 0.0 else Slip()
    return linearise((below, above), (Clamped(), lid), order, round(1.0 / h), K)


def measure(solve: Solve, order: int, h: float) -> Measured:
    table = reference("normal_modes")

    def misfit(name: str, found: Array, rows: int = 1) -> Compared:
        pairs = zip(table[f"{name} real"][:rows], table[f"{name} imag"][:rows])
        known = [complex(*pair) for pair in pairs]
        near = (Compared(found[np.abs(found - s).argmin()], s) for s in known)
        return max(near, key=lambda one: one.error)

    found = modes_of("ring", order, h, 2, ring_pulse=0.0, ring_around=round(1.5 / h))
    errors = {"ring": misfit("ring", found, 3)}
    for kappa, name in SHELLS.items():
        fine = h / (5.0 if order < 6 else 2.5)  # errors of 6/3 are round-off else
        found = modes_of("shell", order, fine, shell_kappa=kappa, shell_charge=0.0)
        errors[name] = misfit(name, found, 3)
    gas = Fluid(0.01, 0.035 / 0.72, 1.4, 1.0)
    layer = ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, p_ref=1.0, heat="elastic")
    found = over_solid(order, h, gas, layer, 0.5, (1.0, 1.0))
    errors["viscous gas"] = misfit("viscous gas", found)
    for name in ("steel", "aluminium"):
        gamma, cv, p, rho = 4.4, 1000.0, 1e5, 1000.0
        p_inf = rho * 1480.0**2 / gamma - p
        T = (p + p_inf) / ((gamma - 1.0) * cv * rho)
        water = Fluid(0.0, 0.0, gamma, (gamma - 1.0) * cv, law=stiffened_gas(gamma, cv, p_inf))
        found = over_solid(order, h, water, metal(name, p), 1.0, (rho, T))
        errors[f"water over {name}"] = misfit(f"water over {name}", found)
    found = over_solid(order, h, metal("aluminium", 0.0), metal("tungsten", 0.0), 1.0, (0.0, 1.0))
    errors["tungsten under aluminium"] = misfit("tungsten under aluminium", found)
    return Measured(errors)


SOURCE = "verify/modes.py (determinants)"
QUICK = {4: (1 / 16, 1 / 24)}
FULL = {4: (1 / 16, 1 / 32), 6: (1 / 24, 1 / 32)}
WHY = "order s + 1, at least: closures are exact to degree s"
expected = of_order(closures)
