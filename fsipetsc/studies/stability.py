"""The command `python -m fsipetsc stability`: the paper's linear theory, checked.

It ends with status 3 where the interface treatment does not keep what it promises. `energy` and
`conservative` promise that the energy never grows (Theorem 4.1), that no mode grows and that the
step of the uncoupled layers is kept; the others promise the last two.
"""

from collections.abc import Sequence
from itertools import product

from fsipetsc.cases.common import materials
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.options import Option, read_table
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm
from fsipetsc.studies.stability_linear import Result, measure, of_options
from fsipetsc.studies.tables import csv_target, listed_in, printer, save_csv, shared, text_table

ORDERS = (2, 4, 6, 8)
THEORY = {
    "conservative": "the end points are one particle; mass, momentum and energy are kept",
    "energy": "orthogonal projection, all four conditions at once (Theorem 4.1)",
    "projection": "temperatures first, then u, sigma, rho (Theorem 4.2)",
    "traditional": "the solid moves the fluid, the fluid loads the solid",
}
_DENSITIES = "m0 over the density of the gas, instead of -solid_density; alpha m0 keeps its value"
_STIFFNESSES = "K over the pressure of the gas, instead of -solid_modulus"
_EOS = "pressure p = G rho epsilon that balances the gas, or none: sigma = -p of the gas"
_POWERS = tuple(10.0**k for k in range(-3, 4))
_ABOVE = {"check": "positive"}
SECTIONS: dict[str, tuple[Option, ...]] = {
    "Gas": (
        Option("fluid_rho", float, 1.0, "kg/m3", "density of the gas at rest", **_ABOVE),
        Option("fluid_T", float, 1.0, "K", "temperature, of the solid too", **_ABOVE),
        *materials(fluid_mu=0.01, fluid_kappa=0.03, fluid_gamma=1.4, fluid_R=1.0),
    ),
    "Solid": (
        *materials(solid_density=1.0, solid_modulus=1.0, solid_alpha=2.5, solid_kappa=0.02),
        Option("solid_eos", str, "ideal", "", _EOS, ("ideal", "elastic")),
    ),
    "Discretisation": (
        Option("fsi_coupling", str, "energy", "", "treatment of the interface", tuple(THEORY)),
        Option("fsi_viscous", str, "wide", "", "D twice, or narrow ones", ("wide", "narrow")),
        Option("fsi_orders", "ints", ORDERS, "", "interior orders", check=listed_in(ORDERS)),
        Option("fsi_h", float, 0.03125, "m", "grid spacing", **_ABOVE),
        Option("stability_points", int, 32, "", "points of each of the two layers", **_ABOVE),
    ),
    "Sweep": (
        Option("sweep", bool, False, "", "all combinations of the ratios below"),
        Option("density_ratios", "floats", _POWERS, "", _DENSITIES, **_ABOVE),
        Option("stiffness_ratios", "floats", _POWERS[1:-1], "", _STIFFNESSES, **_ABOVE),
    ),
    "Output": (
        Option("fsi_output", str, None, "", "table of a sweep, without suffix"),
        Option("fsi_quiet", bool, False, "", "print nothing but errors"),
    ),
}


def stability(arguments: list[str], comm: Comm) -> None:
    """Run the command; the ranks of comm share a sweep. Collective; InputError; ComputationError if
    a promise is not kept."""
    opt = read_table(SECTIONS, start_petsc(arguments, comm))
    for op in map(operator, opt["fsi_orders"]):
        least, points = max(4, op.min_points), opt["stability_points"]
        if points < least:
            raise InputError(f"-stability_points {points}: the {op.name} operator needs {least}")
    state, ratios = of_options(opt), product(opt["density_ratios"], opt["stiffness_ratios"])
    states = [state.swept(*both) for both in ratios] if opt["sweep"] else [state]
    coupling, narrow = opt["fsi_coupling"], opt["fsi_viscous"] == "narrow"
    how = opt["stability_points"], opt["fsi_h"], coupling, narrow
    name = opt["fsi_output"] or f"stability-{coupling}"
    path = csv_target(name) if opt["sweep"] else None
    tasks, say = list(product(opt["fsi_orders"], states)), printer(comm, opt)
    results = shared(comm, tasks, lambda task: measure(task[1], task[0], *how))
    say(f"stability of {coupling}: {THEORY[coupling]}\nsolid | gas at rest, linearised (4.2)")
    say(f"gas    p {state.p:g} Pa; solid  p {state.solid_pressure:g} Pa, sigma {state.stress:g} Pa")
    say(f"\n{table(results)}\n")
    if path is not None:
        save_csv(comm, path, results[0]._fields, results)
        say(f"saved {path}")
    judge(results)


def table(results: Sequence[Result]) -> str:
    """For each order in how many combinations all is well, and the worst."""
    head = ["order", "of", "no mode\ngrows", "growth\n[|lambda|]", "energy never\ngrows"]
    head += ["its growth\n[|lambda|]", "step\nkept", "least of\nuncoupled", "least RK4\nstep [s]"]
    rows = []
    for order in dict.fromkeys(r.order for r in results):
        own = [r for r in results if r.order == order]
        row = [operator(order).name, len(own)]
        row += [sum(r.stable for r in own), f"{max(r.growth for r in own):.1e}"]
        row += [sum(r.estimate for r in own), f"{max(r.energy for r in own):.1e}"]
        row += [sum(r.step_kept for r in own), f"{min(r.step_ratio for r in own):.4f}"]
        rows.append([*row, f"{min(r.step for r in own):.4g}"])
    return text_table(head, rows)


def judge(results: Sequence[Result]) -> None:
    """Raise ComputationError, which names the worst, if a result does not keep what its treatment
    promises."""
    promised = {"a mode grows": "stable", "the step is shorter": "step_kept"}
    if results[0].coupling in ("conservative", "energy"):
        promised["the energy grows"] = "estimate"
    counts = {what: sum(not getattr(r, name) for r in results) for what, name in promised.items()}
    broken = [r for r in results if not all(getattr(r, name) for name in promised.values())]
    if broken:
        worst = max(broken, key=lambda r: (not r.stable, -r.step_ratio if r.stable else r.growth))
        faults = ", ".join(f"{fault} in {count}" for fault, count in counts.items() if count)
        raise ComputationError(
            f"{worst.coupling} fails in {len(broken)} of {len(results)}: {faults}; the worst is "
            f"order {worst.order}, m0/rho = {worst.density_ratio:g}, K/p = "
            f"{worst.stiffness_ratio:g}: growth {worst.growth:.2g} |lambda|, step "
            f"{worst.step_ratio:.2g} of the uncoupled one"
        )
