"""What must not change: mass, momentum, energy, and the direction of entropy, held against the
recorded series.

Mass of a gas layer behind a wall, total energy between two walls without body forces, momentum less
the impulse of the outer ends and body forces, and, between walls, the entropy less the accumulated
heating of the solids by stress, int int sigma u_X / T dX dt, which must not decrease. (The entropy
alone is not monotone: sigma u_X heats the solid.) Of blocks all is counted that comes in through
faces and by body forces (fsipetsc.blockrun.scheme), so masses, all components of momentum and
energy are held for open edges, too; entropy as said, and where no solid is heated by stress.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

#: a momentum less than this part of sqrt(energy times mass) is none
LEAST = 1e-6
#: the same of each component in two dimensions, where the forces on two edges may be large and add
#: up to nothing
LEAST_COMPONENT = 1e-3
TINY = np.finfo(float).tiny


def drifts(
    invariants: Mapping[str, Any], initial: Mapping[str, Any], series: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Name of an invariant that must hold -> its relative drift (nsteps,); series: complete, from
    the first step on.

    invariants: which ones must hold (fsipetsc.problem.Problem.invariants). Entropy counts only
    where it decreases. Momentum is relative to the impulse that has passed, of either sign, energy
    to itself, entropy to itself or to the heat
    capacity, whatever is more; time integrals are trapezoidal sums over the steps.
    """
    return Drifts(invariants, initial).go_on(series)


class Drifts:
    """The drifts, piece by piece of the series: only sums are kept of what has gone before.
    Arguments as of ``drifts``.
    """

    def __init__(self, invariants: Mapping[str, Any], initial: Mapping[str, Any]) -> None:
        self._invariants, self._initial = invariants, initial
        self._rates = {name: initial.get(name, 0.0) for name in ("force", "heating")}  # last ones
        self._sums: dict[str, float] = {}
        masses = np.asarray(initial.get("mass", ())).tolist()
        energy = max(initial.get("energy", 0.0), 0.0)
        #: what round-off makes of a momentum that nothing has changed is nothing beside this
        self._momentum_of_all = np.sqrt(energy * (invariants.get("inertia", 0.0) + sum(masses)))
        gases = zip(invariants.get("cv", ()), masses)
        self._heat_capacity = invariants.get("heat_capacity", 0.0) + sum(c * m for c, m in gases)
        self._most = 0.0  # entropy produced

    def memory(self) -> dict[str, Any]:
        """What ``recall`` takes, as JSON has it."""
        rates, sums = (
            {name: float(value) for name, value in values.items()}
            for values in (self._rates, self._sums)
        )
        return {"rates": rates, "sums": sums, "most": float(self._most)}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on behind the steps of which ``memory`` tells."""
        self._rates, self._sums = dict(memory["rates"]), dict(memory["sums"])
        self._most = memory["most"]

    @np.errstate(all="ignore")  # a drift that is no number says so itself
    def go_on(self, series: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The drifts in the next steps: name -> (steps,)."""
        result: dict[str, np.ndarray] = {}
        invariants, initial = self._invariants, self._initial
        if not invariants or not len(series["dt"]):
            return result
        nothing = np.zeros(len(series["dt"]))
        for name, columns in invariants["masses"]:
            chosen, came = np.atleast_1d(columns), nothing  # of blocks of gas that are joined
            if "mass_in" in series:
                came = self._sum(f"into '{name}'", series["mass_in"][:, chosen].sum(axis=1))
            first = sum(initial["mass"][column] for column in chosen)
            result[f"mass of '{name}'"] = (series["mass"][:, chosen].sum(axis=1) - came) / first - 1
        if "force" in series:
            result["momentum"] = self._momentum(series, nothing)
        kept = invariants.get("momentum") or ""  # True in older results
        for axis in (x for x in "xyz" if f"impulse_{x}" in series and (kept is True or x in kept)):
            name, given = f"momentum_{axis}", series[f"impulse_{axis}"]
            passed = self._sum(f"{name}, given and taken", np.abs(given))
            least = max(abs(initial[name]), LEAST_COMPONENT * self._momentum_of_all, TINY)
            change = series[name] - initial[name] - self._sum(name, given)
            result[f"momentum along {axis}"] = change / np.maximum(passed, least)
        if invariants["energy"]:
            came = self._sum("energy", series["energy_in"]) if "energy_in" in series else 0.0
            result["energy"] = (series["energy"] - came) / initial["energy"] - 1
            if "heating" in series or invariants.get("entropy"):
                heated = nothing
                if "heating" in series:
                    heated = self._integral(series, "heated", self._joined(series, "heating"))
                produced = series["entropy"] - initial["entropy"] - heated
                most = np.maximum.accumulate(np.concatenate([[self._most], produced]))[1:]
                self._most = most[-1]
                scale = max(abs(initial["entropy"]), self._heat_capacity, TINY)
                result["entropy"] = (most - produced) / scale
        return result

    def _momentum(self, series: Mapping[str, np.ndarray], nothing: np.ndarray) -> np.ndarray:
        """The drift of momentum, less the impulse of ends and body forces."""
        first, force = self._initial["momentum"], self._joined(series, "force")
        given = series["impulse"] if "impulse" in series else nothing  # an older result
        impulse = self._integral(series, "impulse", force) + self._sum("given", given)
        passed = self._integral(series, "passed", np.abs(force))
        passed = passed + self._sum("given and taken", np.abs(given))
        scale = np.maximum(passed, max(abs(first), LEAST * self._momentum_of_all)) + TINY
        return (series["momentum"] - first - impulse) / scale

    def _sum(self, name: str, parts: np.ndarray) -> np.ndarray:
        """Sum from t = 0 to the end of each step of what belongs to a step."""
        sums = np.cumsum(np.concatenate([[self._sums.get(name, 0.0)], parts]))[1:]
        self._sums[name] = sums[-1]
        return sums

    def _joined(self, series: Mapping[str, np.ndarray], name: str) -> np.ndarray:
        """A rate at the ends of the steps, behind that at the beginning of the first one."""
        rate = np.concatenate([[self._rates[name]], series[name]])
        self._rates[name] = rate[-1]
        return rate

    def _integral(
        self, series: Mapping[str, np.ndarray], name: str, rate: np.ndarray
    ) -> np.ndarray:
        """Integral from t = 0 to the end of each step of a rate known at its ends."""
        return self._sum(name, 0.5 * series["dt"] * (rate[1:] + rate[:-1]))
