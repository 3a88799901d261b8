"""Light and heavy, soft and stiff solids between two gases: which couplings and grids are stable,
and what linear theory says.

A sound pulse in one of two closed gases around an elastic solid, of an amplitude at which all is
linear. A run counts as stable if it comes to its end and no velocity in its second half is larger
than in its first. Called by scripts/soak: ratios.py [ORDER ...] [COUPLING ...].
"""

from __future__ import annotations

import os
import sys
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np

os.environ.setdefault("OMP_NUM_THREADS", "1")

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
#: of the pulse
CELLS, END, PULSE = 32, 10.0, 1e-4
#: steps at most, over those of a Courant number of 1
SHORTEST = 8
GAS = Fluid(0.01, 0.03, 1.4, 1.0)


def problem(mass: float, stiffness: float) -> Problem:
    """Gas | solid | gas between walls; the solid's heat capacity is the same for all."""
    solid = Solid(K=stiffness, kappa_e=0.02, m0=mass, alpha=2.5 / mass)

    def pulse(X: np.ndarray) -> list[np.ndarray]:
        p = 1.0 + PULSE * np.exp(-(((X - 0.5) / 0.12) ** 2))
        rho = p ** (1.0 / GAS.gamma)
        return [rho, 0.0 * X, p / rho]

    def rest(X: np.ndarray) -> list[np.ndarray]:
        return [0.0 * X, 0.0 * X - 1.0, 0.0 * X + 1.0, X]

    return Problem(
        (
            FluidLayer("left", GAS, (0.0, 1.0), pulse),
            SolidLayer("solid", solid, (1.0, 2.0), rest),
            FluidLayer("right", GAS, (2.0, 3.0), lambda X: [0.0 * X + 1.0, 0.0 * X, 0.0 * X + 1.0]),
        ),
        Wall(0.0),
        Wall(3.0),
        units="none",
    )


def run(mass: float, stiffness: float, coupling: str, order: int) -> tuple[bool, str]:
    """Whether it is stable, and if not, how fast the velocity has grown or when the run ended."""
    case = SimpleNamespace(
        NAME="ratios",
        SUMMARY="",
        OPTIONS=(),
        DEFAULTS={},
        build=lambda opt: problem(mass, stiffness),
    )
    words = f"-fsi_h {1 / CELLS} -fsi_order {order} -fsi_coupling {coupling} -ts_max_time {END}"
    fastest = (
        2.0 + ((stiffness + 1.0) / mass) ** 0.5
    )  # waves, if all stays small; steps shorter by far end the run
    words += f" -ts_max_steps {int(SHORTEST * END * CELLS * fastest)}"
    seen: list[tuple[float, float]] = []

    def watch(state: Any, t: float) -> None:
        seen.append((t, max(float(np.nanmax(np.abs(u))) for u in velocities(state))))

    times = np.linspace(0.0, END, 101)[1:]
    try:
        opt = read_options(case, given_options(words.split()))
        integrated(case, opt, start_mpi(), times, watch)
    except FsiError:
        return False, f"ends at {seen[-1][0] if seen else 0.0:.1f}"
    if seen[-1][0] < END:
        return False, f"at {seen[-1][0]:.2g} after {SHORTEST} times the steps: they shrink"
    t, largest = np.array(seen).T
    first, second = largest[t <= END / 2].max(), largest[t > END / 2].max()
    if second <= first:
        return True, ""
    rate = np.polyfit(t[t > END / 2], np.log(largest[t > END / 2]), 1)[0]
    return False, f"{rate:+.1g}/s"


def velocities(state: Any) -> list[np.ndarray]:
    """Of the points of each layer."""
    layers = state.problem.layers
    blocks = getattr(state, "fields", None)
    found = state.save() if blocks is None else {k: blocks(k) for k in range(len(layers))}
    return [found[k][:, 1 if layer.kind == "fluid" else 0] for k, layer in enumerate(layers)]


def theory(mass: float, stiffness: float, coupling: str, order: int) -> str:
    """What `python -m fsipetsc stability` says of one interface: nothing, that the scheme has a
    growing mode, the equations, or that the step is too long."""
    from fsipetsc.analysis.stability_linear import Constant, measure

    rest = Constant(GAS, Solid(K=stiffness, kappa_e=0.02, m0=mass, alpha=2.5 / mass), 1.0, 1.0)
    found = measure(rest, order, CELLS + 1, 1 / CELLS, coupling)
    if not found.stable:
        return "mode"
    return (
        "" if found.step_kept and found.heated_stable else "step" if not found.step_kept else "heat"
    )


def main(orders: list[int], couplings: list[str]) -> None:
    start_petsc([], start_mpi())
    print("| order, coupling | stable | not stable: m0/ρ, K/p (how fast; linear theory there) |")
    print("|---|---|---|")
    for order, coupling in product(orders, couplings):
        faults = []
        for mass, stiffness in product(MASSES, STIFFNESSES):
            stable, how = run(mass, stiffness, coupling, order)
            if not stable:
                why = theory(mass, stiffness, coupling, order) or "nothing"
                faults.append(f"{mass:g}, {stiffness:g} ({how}; {why})")
        count = len(MASSES) * len(STIFFNESSES)
        print(
            f"| {order}, {coupling} | {count - len(faults)} of {count} | {'; '.join(faults)} |",
            flush=True,
        )


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    main(numbers or [4], [word for word in sys.argv[1:] if word in COUPLINGS] or list(COUPLINGS))
