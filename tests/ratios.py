"""Light and heavy, soft and stiff solids between gases: which couplings and grids are stable.

A sound pulse of small amplitude. Stable: the run ends, no velocity in its second half is larger
than in its first. scripts/soak calls ratios.py [ORDER ...] [COUPLING ...].
"""

import sys
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import fsipetsc
from fsipetsc import Fluid, FluidLayer, Problem, Solid, SolidLayer, Wall
from fsipetsc.errors import FsiError
from fsipetsc.studies.stability_linear import Constant

#: m0 over the density of the gas, K over its pressure
MASSES, STIFFNESSES = (1e-3, 1e-1, 1.0, 1e2, 1e4), (1e-2, 1.0, 1e2, 1e3)
COUPLINGS = "conservative", "energy", "projection", "traditional"
#: cells of a layer; the end, some six times of the sound through a gas and back; relative pressure
#: of the pulse; steps at most, over those of a Courant number of 1
CELLS, END, PULSE, SHORTEST = 32, 10.0, 1e-4, 8
GAS = Fluid(0.01, 0.03, 1.4, 1.0)


def sandwich(state: Constant, pulse: float = 0.0) -> Problem:
    """Gas | solid | gas between walls about a constant state, with a pulse in the first gas."""

    def gas(X):
        part = 1.0 + pulse * np.exp(-(((X - 0.5) / 0.12) ** 2)) * (X < 1.5)
        of_T = part ** (1.0 - 1.0 / state.gas.gamma)
        return [state.rho * part / of_T, 0.0 * X, state.T * of_T]

    def solid(X):
        one = np.ones(X.shape)
        return [0.0 * X, state.stress * one, state.T * one, 1.0 + state.stretch * (X - 1.0)]

    layers = (
        FluidLayer("left", state.gas, (0.0, 1.0), gas),
        SolidLayer("solid", state.solid, (1.0, 2.0), solid),
        FluidLayer("right", state.gas, (2.0, 3.0), gas),
    )
    return Problem(layers, Wall(0.0), Wall(2.0 + state.stretch), units="none")


def fault(mass: float, stiffness: float, coupling: str, order: int, output: Path) -> str:
    """How fast the velocity has grown or how the run ended; nothing of a stable one."""
    solid = Solid(K=stiffness, kappa_e=0.02, m0=mass, alpha=2.5 / mass)  # one heat capacity for all
    # waves, if all stays small; steps shorter by far end the run
    fastest = 2.0 + ((stiffness + 1.0) / mass) ** 0.5
    options = {"h": 1 / CELLS, "order": order, "coupling": coupling, "max_time": END}
    options |= {"output_dt": 0.01 * END, "max_steps": int(SHORTEST * END * CELLS * fastest)}
    case = sandwich(Constant(GAS, solid, 1.0, 1.0), PULSE)
    try:
        with fsipetsc.run(case, output=output, **options) as run:
            t, u = run.time, [layer["u"][:] for layer in run.layers]
    except FsiError as error:
        return f"ends: {error}"
    if t[-1] < END:
        return f"at {t[-1]:.2g} after {SHORTEST} times the steps: they shrink"
    late, largest = t > END / 2, np.max([np.nanmax(np.abs(v), axis=1) for v in u], axis=0)
    if largest[late].max() <= largest[~late].max():
        return ""
    return f"{np.polyfit(t[late], np.log(largest[late]), 1)[0]:+.1g}/s"


def main(orders: list[int], couplings: list[str]) -> None:
    print("| order, coupling | stable | not stable: m0/ρ, K/p (how fast) |")
    print("|---|---|---|")
    cases = list(product(MASSES, STIFFNESSES))
    with TemporaryDirectory() as folder:
        for order, coupling in product(orders, couplings):
            output = Path(folder) / "ratios.h5"
            faults = {case: fault(*case, coupling, order, output) for case in cases}
            listed = [f"{mass:g}, {K:g} ({why})" for (mass, K), why in faults.items() if why]
            stable = f"{len(cases) - len(listed)} of {len(cases)}"
            print(f"| {order}, {coupling} | {stable} | {'; '.join(listed)} |", flush=True)


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    main(numbers or [4], [word for word in sys.argv[1:] if word in COUPLINGS] or list(COUPLINGS))
