"""Light and heavy, soft and stiff solids between two gases: which couplings and grids are stable.

A sound pulse in one of two closed gases around an elastic solid, of an amplitude at which all is
linear. A run counts as stable if it comes to its end and no velocity in its second half is larger
than in its first. Called by scripts/soak: ratios.py [ORDER ...] [COUPLING ...].
"""

from __future__ import annotations

import sys
from itertools import product
from types import SimpleNamespace

import numpy as np
from helpers import integrated

from fsipetsc.boundaries import Wall
from fsipetsc.errors import FsiError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.options import given_options, read_options
from fsipetsc.problem import FluidLayer, Problem, SolidLayer
from fsipetsc.process.launch import start_mpi, start_petsc

#: m0 over the density of the gas, K over its pressure
MASSES, STIFFNESSES = (1e-3, 1e-1, 1.0, 1e2, 1e4), (1e-2, 1.0, 1e2, 1e3)
COUPLINGS = "conservative", "energy", "projection", "traditional"
#: cells of a layer; the end, some six times of the sound through a gas and back; relative pressure
#: of the pulse; steps at most, over those of a Courant number of 1
CELLS, END, PULSE, SHORTEST = 32, 10.0, 1e-4, 8
GAS = Fluid(0.01, 0.03, 1.4, 1.0)


def problem(mass: float, stiffness: float) -> Problem:
    """Gas | solid | gas between walls; the solid's heat capacity is the same for all."""
    solid = Solid(K=stiffness, kappa_e=0.02, m0=mass, alpha=2.5 / mass)

    def gas(X: np.ndarray) -> list[np.ndarray]:
        p = 1.0 + PULSE * np.exp(-(((X - 0.5) / 0.12) ** 2)) * (X < 1.5)
        rho = p ** (1.0 / GAS.gamma)
        return [rho, 0.0 * X, p / rho]

    def rest(X: np.ndarray) -> list[np.ndarray]:
        return [0.0 * X, 0.0 * X - 1.0, 0.0 * X + 1.0, X]

    layers = (
        FluidLayer("left", GAS, (0.0, 1.0), gas),
        SolidLayer("solid", solid, (1.0, 2.0), rest),
        FluidLayer("right", GAS, (2.0, 3.0), gas),
    )
    return Problem(layers, Wall(0.0), Wall(3.0), units="none")


def fault(mass: float, stiffness: float, coupling: str, order: int) -> str:
    """Of a run that is not stable: how fast the velocity has grown or when the run ended; else
    nothing."""
    of_case = {"NAME": "ratios", "SUMMARY": "", "OPTIONS": (), "DEFAULTS": {}}
    case = SimpleNamespace(**of_case, build=lambda opt: problem(mass, stiffness))
    words = f"-fsi_h {1 / CELLS} -fsi_order {order} -fsi_coupling {coupling} -ts_max_time {END}"
    # waves, if all stays small; steps shorter by far end the run
    fastest = 2.0 + ((stiffness + 1.0) / mass) ** 0.5
    words += f" -ts_max_steps {int(SHORTEST * END * CELLS * fastest)}"
    seen: list[tuple[float, float]] = [(0.0, 0.0)]

    def watch(state, t: float) -> None:
        number = range(3)
        found = state.save() if coupling != "conservative" else {k: state.fields(k) for k in number}
        speeds = [found[k][:, 0 if k == 1 else 1] for k in number]
        seen.append((t, max(float(np.nanmax(np.abs(u))) for u in speeds)))

    try:
        opt = read_options(case, given_options(words.split()))
        integrated(case, opt, start_mpi(), np.linspace(0.0, END, 101)[1:], watch)
    except FsiError:
        return f"ends at {seen[-1][0]:.1f}"
    t, largest = np.array(seen).T
    if t[-1] < END:
        return f"at {t[-1]:.2g} after {SHORTEST} times the steps: they shrink"
    late = t > END / 2
    if largest[late].max() <= largest[~late].max():
        return ""
    return f"{np.polyfit(t[late], np.log(largest[late]), 1)[0]:+.1g}/s"


def main(orders: list[int], couplings: list[str]) -> None:
    start_petsc([], start_mpi())
    print("| order, coupling | stable | not stable: m0/ρ, K/p (how fast) |")
    print("|---|---|---|")
    cases = list(product(MASSES, STIFFNESSES))
    for order, coupling in product(orders, couplings):
        faults = {case: why for case in cases if (why := fault(*case, coupling, order))}
        listed = "; ".join(f"{mass:g}, {K:g} ({why})" for (mass, K), why in faults.items())
        stable = f"{len(cases) - len(faults)} of {len(cases)}"
        print(f"| {order}, {coupling} | {stable} | {listed} |", flush=True)


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    main(numbers or [4], [word for word in sys.argv[1:] if word in COUPLINGS] or list(COUPLINGS))
