"""What must not change: mass, momentum, energy, and the direction of entropy, held against the
recorded series.

Of blocks all is counted that comes in through faces and by body forces:
masses, all components of momentum and energy are held for open edges, too; with the potential
energy of constant forces in the place of their work where no mass comes in and grids are at rest;
the entropy of gases where nothing comes in and solids take no heat from them. Of the paper's method
the mass of a gas layer behind a wall is held, and total energy between two walls without body
forces."""

from collections.abc import Mapping
from typing import Any

import numpy as np

#: a component of momentum less than this part of sqrt(energy times mass) is none: the forces on two
#: edges may be large and add up to nothing
LEAST_COMPONENT = 1e-3
TINY = np.finfo(float).tiny


class Drifts:
    """Relative drifts of the invariants that must hold, piece by piece of the series: ``memory``
    has the sums of what has gone before.

    invariants: which ones must hold (fsipetsc.blocks.block_problem.BlockProblem.invariants).
    initial: the integrals at t = 0. memory: of the steps before the first one. Entropy counts only
    where it decreases. Momentum is relative to the impulse that has passed, of either sign, energy
    to itself, entropy to itself or to the heat capacity, whatever is more.
    """

    def __init__(
        self,
        invariants: Mapping[str, Any],
        initial: Mapping[str, Any],
        memory: Mapping[str, float] | None = None,
    ) -> None:
        self._invariants, self._initial, self.memory = invariants, initial, dict(memory or {})
        mass = invariants.get("inertia", 0.0) + sum(np.asarray(initial.get("mass", ())).tolist())
        #: what round-off makes of a momentum that nothing has changed is nothing beside this
        self._momentum_of_all = np.sqrt(max(initial.get("energy", 0.0), 0.0) * mass)

    @np.errstate(all="ignore")  # a drift that is no number says so itself
    def go_on(self, series: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The drifts in the next steps, all columns of the series in them: name -> (steps,)."""
        result: dict[str, np.ndarray] = {}
        invariants, initial = self._invariants, self._initial
        if not invariants or not len(series["dt"]):
            return result
        for name, columns in invariants["masses"]:  # several of blocks of gas that are joined
            mass, came = series["mass"][:, columns].sum(axis=1), 0.0
            if "mass_in" in series:
                came = self._sum(f"into '{name}'", series["mass_in"][:, columns].sum(axis=1))
            first = sum(initial["mass"][column] for column in columns)
            result[f"mass of '{name}'"] = (mass - came) / first - 1
        for axis in invariants.get("momentum", ""):
            name, given = f"momentum_{axis}", series[f"impulse_{axis}"]
            passed = self._sum(f"{name}, given and taken", np.abs(given))
            least = max(abs(initial[name]), LEAST_COMPONENT * self._momentum_of_all, TINY)
            change = series[name] - initial[name] - self._sum(name, given)
            result[f"momentum along {axis}"] = change / np.maximum(passed, least)
        if invariants["energy"]:
            came = self._sum("energy", series["energy_in"]) if "energy_in" in series else 0.0
            result["energy"] = (series["energy"] - came) / initial["energy"] - 1
        if invariants.get("potential"):
            came = self._sum("energy without work", series["energy_in"] - series["force_work"])
            first = initial["energy"], initial["potential_energy"]
            change = series["energy"] - first[0] + (series["potential_energy"] - first[1]) - came
            result["energy with potential energy"] = change / max(map(abs, first))
        if invariants.get("entropy"):
            produced = series["entropy"] - initial["entropy"]
            before = self.memory.get("entropy produced", 0.0)
            most = np.maximum.accumulate(np.concatenate([[before], produced]))[1:]
            self.memory["entropy produced"] = float(most[-1])
            scale = max(abs(initial["entropy"]), invariants["heat_capacity"], TINY)
            result["entropy"] = (most - produced) / scale
        return result

    def _sum(self, name: str, parts: np.ndarray) -> np.ndarray:
        """Sum from t = 0 to the end of each step of what belongs to a step."""
        sums = np.cumsum(np.concatenate([[self.memory.get(name, 0.0)], parts]))[1:]
        self.memory[name] = float(sums[-1])
        return sums
