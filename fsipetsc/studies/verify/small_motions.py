"""Entries of `verify` about small motions: frequencies and growth by the linearised scheme."""

from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc import Block, BlockProblem, Fluid
from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.blocks.conditions import Clamped, Free, Hinge, NoSlip, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.blocks.maps import rectangle
from fsipetsc.cases import load_case
from fsipetsc.cases.common import at_rest, constant
from fsipetsc.checks import Array
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.options import defaults
from fsipetsc.stepping.solve import build_problem
from fsipetsc.studies.flutter import CASE, crossing, modes_at
from fsipetsc.studies.linear import linearise, modes_near, radial_modes
from fsipetsc.studies.verdicts import Compared, Expected, closures
from fsipetsc.studies.verify.entry import Measured, Solve, entry, reference


def first_frequency(order: int, h: float, thickness: float, hinged: bool) -> float:
    """omega [1/s] of the slowest motion that bends a beam. InputError."""
    beam = ElasticSolid(1.0, 0.0, 0.0, 1.0, 1.0, law="linear", heat="elastic")
    where = rectangle((0.0, -0.5 * thickness), (1.0, 0.5 * thickness))
    cells = round(1 / h), round(0.6 / h)
    block = Block("beam", beam, where, cells, lambda X, Y: (0, 0, 1, X, Y))
    ends = Free() if hinged else Clamped()
    faces = {("beam", axis, side): Free() if axis else ends for axis in (0, 1) for side in (0, 1)}
    points = tuple(("beam", (x, 0.0), Hinge()) for x in (0.0, 1.0)) if hinged else ()
    problem = BlockProblem((block,), faces, points=points)
    thin = (np.pi**2 if hinged else 22.37) * np.sqrt(thickness**2 / 6.0)  # if it were thin
    with BlockState(MPI.COMM_SELF, problem, order) as state:
        # 2/1 has a second mode near it, which alternates from node to node
        return float(modes_near(state, 0.9j * thin)[0].imag)


@entry(
    source="verify/beams.py (Timoshenko; Euler and Bernoulli in the thin limit)",
    why="order s + 1; errors: what the theory leaves open, a shear coefficient of 5/6 or π²/12",
    full=dict.fromkeys((2, 4, 6), (1 / 20, 1 / 40)),
    quick={4: (1 / 20, 1 / 30)},
)
def beam(solve: Solve, order: int, h: float) -> Measured:
    """Free vibration in vacuum."""
    table, errors, expected = reference("beam"), {}, {}
    for ends, thickness in (("clamped", 0.05), ("hinged", 0.02)):
        name, row = f"{ends}, d = {thickness:g}", np.argmin(np.abs(table["d"] - thickness))
        known, other = table[ends][row], table[f"{ends} pi^2/12"][row]
        found = first_frequency(order, h, thickness, ends == "hinged") / np.sqrt(thickness**2 / 6.0)
        errors[name] = Compared(found, known)
        expected[name] = Expected(closures(order), abs(1.0 - other / known))
    return Measured(errors, expected)


#: density, speeds of P and S waves [SI]
METALS = {
    "steel": (7850.0, 5900.0, 3200.0),
    "aluminium": (2700.0, 6320.0, 3130.0),
    "tungsten": (19250.0, 5220.0, 2890.0),
}


def metal(name: str, pressure: float) -> Any:
    """Return an elastic solid, free of stress under a pressure [Pa]."""
    density, cp, cs = METALS[name]
    mu = density * cs**2
    lame = density * cp**2 - 2.0 * mu
    return ElasticSolid(mu, lame, 0.0, density, 1000.0, p_ref=pressure, heat="elastic")


def modes_of(name: str, order: int, h: float, n: int = 0, **given: Any) -> Array:
    """Return s of the slowest modes of a case [1/s], of angular number n."""
    case = load_case(name)
    opt = {**defaults(case), "fsi_order": order, "fsi_h": h, **given}
    return 1j * radial_modes(build_problem(case, opt, MPI.COMM_SELF), order, n)[:3]


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
    return linearise((below, above), (Clamped(), lid), order, round(1.0 / h), 2.0 * np.pi)


@entry(
    source="verify/modes.py (determinants)",
    why="order s + 1, at least: closures are exact to degree s",
    full={4: (1 / 16, 1 / 32), 6: (1 / 24, 1 / 32)},
    quick={4: (1 / 16, 1 / 24)},
)
def normal_modes(solve: Solve, order: int, h: float) -> Measured:
    """Gas and liquid with elastic solids."""
    table = reference("normal_modes")

    def misfit(name: str, found: Array, rows: int = 1) -> Compared:
        pairs = zip(table[f"{name} real"][:rows], table[f"{name} imag"][:rows])
        known = [complex(*pair) for pair in pairs]
        near = (Compared(found[np.abs(found - s).argmin()], s) for s in known)
        return max(near, key=lambda one: one.error)

    found = modes_of("ring", order, h, 2, ring_pulse=0.0, ring_around=round(1.5 / h))
    errors = {"ring": misfit("ring", found, 3)}
    for kappa, name in {1: "cylinder", 2: "sphere"}.items():
        fine = h / (5.0 if order < 6 else 2.5)  # errors of 6/3 are round-off else
        found = modes_of("shell", order, fine, shell_kappa=kappa, shell_charge=0.0)
        errors[name] = misfit(name, found, 3)
    gas = Fluid(0.01, 0.035 / 0.72, 1.4, 1.0)
    layer = ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, p_ref=1.0, heat="elastic")
    found = over_solid(order, h, gas, layer, 0.5, (1.0, 1.0))
    errors["viscous gas"] = misfit("viscous gas", found)
    gamma, cv, p, rho = 4.4, 1000.0, 1e5, 1000.0
    p_inf = rho * 1480.0**2 / gamma - p
    T = (p + p_inf) / ((gamma - 1.0) * cv * rho)
    water = Fluid(0.0, 0.0, gamma, (gamma - 1.0) * cv, law=stiffened_gas(gamma, cv, p_inf))
    for name in ("steel", "aluminium"):
        found = over_solid(order, h, water, metal(name, p), 1.0, (rho, T))
        errors[f"water over {name}"] = misfit(f"water over {name}", found)
    found = over_solid(order, h, metal("aluminium", 0.0), metal("tungsten", 0.0), 1.0, (0.0, 1.0))
    errors["tungsten under aluminium"] = misfit("tungsten under aluminium", found)
    return Measured(errors, Expected(closures(order)))


#: of frequencies, where stress in a clamped corner goes as r^(0.69 - 1)
CORNER_ORDER = 1.38
#: ends of a panel -> lambdas around the onset; without that in the middle it is 0.1 to 0.2 % low
LAMBDAS = {"clamped": (600.0, 650.0, 700.0), "hinged": (320.0, 350.0, 380.0)}


@entry(
    source="verify/beams.py (plane strain, linear flow; Dowell 1975 has 636.57 in the thin limit)",
    why="stress in a clamped corner goes as r^(0.69 - 1), so the order is 1.38; errors: what the"
    " thickness takes off the thin limit in theory",
    full={4: (1 / 24, 1 / 32, 1 / 48)},
    quick={4: (1 / 24,)},
)
def panel_flutter(solve: Solve, order: int, h: float) -> Measured:
    """The onset differs from the thin limit by the effect of the thickness."""
    table, errors, expected = reference("panel_flutter"), {}, {}
    row = np.argmin(np.abs(table["d"] - 0.04))
    opt = {**defaults(CASE), "fsi_order": order, "fsi_h": h, "panel_thickness": 0.04}
    for ends, lambdas in LAMBDAS.items():
        pairs = [modes_at({**opt, "panel_ends": ends}, 2.0, dynamic) for dynamic in lambdas]
        onset = crossing(2.0, opt["panel_mass"], lambdas, pairs)[0]
        thin, thick = table[f"{ends} lambda"][:2]
        of_theory, of_limit = f"{ends}, theory", f"{ends}, thin limit"
        errors[of_theory] = Compared(onset, table[f"{ends} theory"][row])
        errors[of_limit] = Compared(onset, thin)
        corner = CORNER_ORDER if ends == "clamped" else None
        expected[of_theory] = Expected(corner, 1.0 - thick / thin)
        expected[of_limit] = Expected(error=1.0 - thick / thin)
    return Measured(errors, expected)
