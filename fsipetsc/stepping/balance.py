"""What must not change: mass, momentum, energy, and the direction of entropy, held against the recorded series.

Mass of a gas layer behind a wall, total energy between two walls without body forces, momentum less the impulse of the
outer ends and body forces, and, between walls, the entropy less the accumulated heating of the solids by stress,
int int sigma u_X / T dX dt, which must not decrease. (The entropy alone is not monotone: sigma u_X heats the solid.)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from fsipetsc.problem import Problem


def drifts(laws: Mapping[str, Any], initial: Mapping[str, Any], series: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Name of an invariant that must hold -> its relative drift (nsteps,); series: complete, from the first step on.

    laws: which ones must hold (fsipetsc.problem.Problem.laws). Entropy counts only where it decreases. Momentum is relative
    to the impulse that has passed, of either sign, energy to itself; time integrals are trapezoidal sums over the steps.
    """
    result: dict[str, np.ndarray] = {}
    if not laws:
        return result
    for name, column in laws["masses"]:
        result[f"mass of '{name}'"] = series["mass"][:, column] / initial["mass"][column] - 1
    force = np.concatenate([[initial["force"]], series["force"]])
    impulse = _integral(series, force)
    scale = np.maximum(_integral(series, np.abs(force)), abs(initial["momentum"])) + np.finfo(float).tiny
    result["momentum"] = (series["momentum"] - initial["momentum"] - impulse) / scale
    if laws["energy"]:
        result["energy"] = series["energy"] / initial["energy"] - 1
        if "entropy" in series:
            heating = np.concatenate([[initial["heating"]], series["heating"]])
            produced = np.concatenate([[0.0], series["entropy"] - initial["entropy"] - _integral(series, heating)])
            lost = np.maximum.accumulate(produced)[1:] - produced[1:]
            result["entropy"] = lost / max(abs(initial["entropy"]), np.finfo(float).tiny)
    return result


def _integral(series: Mapping[str, np.ndarray], rate: np.ndarray) -> np.ndarray:
    """Integral up to the end of each step of a rate known at its ends."""
    return np.cumsum(0.5 * series["dt"] * (rate[1:] + rate[:-1]))


class Watch:
    """Keeps the series that the balances need and says which one is broken by more than a tolerance. On rank 0."""

    _NAMES = ("dt", "mass", "momentum", "force", "energy", "entropy", "heating")

    def __init__(self, problem: Problem, initial: Mapping[str, Any], tolerance: float) -> None:
        self._problem, self._initial, self._tolerance = problem, initial, tolerance
        self._blocks: list[dict[str, np.ndarray]] = []

    def look(self, block: np.ndarray) -> str | None:
        """What is wrong after some more steps, of which these are the records, or None."""
        self._blocks.append({name: np.array(block[name]) for name in self._NAMES if name in block.dtype.names})
        series = {name: np.concatenate([b[name] for b in self._blocks]) for name in self._blocks[0]}
        for name, drift in drifts(self._problem.laws, self._initial, series).items():
            worst = int(np.argmax(np.abs(drift)))
            if abs(drift[worst]) > self._tolerance:
                return f"{name} has drifted by {drift[worst]:.3g} (relative) in step {worst + 1}"
        return None
