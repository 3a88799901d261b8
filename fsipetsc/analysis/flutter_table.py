"""The numbers of a flutter study: growth over dynamic pressure and Mach number, and where it begins; as text and CSV."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fsipetsc.analysis.flutter_fit import crossing
from fsipetsc.analysis.flutter_theory import Flow
from fsipetsc.errors import ComputationError, FileError


@dataclass(frozen=True)
class FlutterRun:
    """A run: Mach number, lambda, s of the two modes that meet [unit of velocity over the panel's length], misfit of the modes;
    steps and wall time [s]. failure: why there are none of these.
    """

    mach: float
    dynamic: float
    pair: tuple[complex, ...] = ()
    misfit: float = float("nan")
    steps: int = 0
    wall_time: float = 0.0
    failure: str = ""

    @property
    def fastest(self) -> complex:
        """The s of the two whose growth is larger."""
        return max(self.pair, key=lambda s: s.real, default=complex("nan"))


@dataclass(frozen=True)
class Onset:
    """Of a Mach number: lambda at which the growth becomes positive and the frequency there [cycles per unit of time], by the
    runs and by theories, NaN where there is none between the lambda of the runs; thick: with shear and rotary inertia.
    """

    mach: float
    found: float
    frequency: float
    quasi_steady: float
    potential: float
    thick: float
    thick_frequency: float


@dataclass(frozen=True)
class FlutterStudy:
    """Runs over Mach numbers and lambda for a mass and a thickness of the panel."""

    mass: float
    thickness: float
    runs: tuple[FlutterRun, ...]

    @property
    def machs(self) -> tuple[float, ...]:
        return tuple(sorted({run.mach for run in self.runs}))

    def of(self, mach: float) -> list[FlutterRun]:
        """The runs at a Mach number that went well, by lambda."""
        return sorted((run for run in self.runs if run.mach == mach and not run.failure), key=lambda run: run.dynamic)

    def unit(self, mach: float, dynamic: float) -> float:
        """sqrt(D/m) at lambda = dynamic."""
        return Flow(mach, self.mass).unit(dynamic)

    def thin(self, mach: float, dynamic: float) -> tuple[complex, complex]:
        """s of the two modes of a thin panel in quasi-steady flow, over the unit."""
        first, second = Flow(mach, self.mass).quasi_steady(dynamic)[:2] / self.unit(mach, dynamic)
        return complex(first), complex(second)

    def onset(self, mach: float) -> Onset:
        """Where flutter begins."""
        runs, thin = self.of(mach), Flow(mach, self.mass)
        thick = Flow(mach, self.mass, self.thickness)
        found = frequency = float("nan")
        if len(runs) > 1:
            dynamic = [run.dynamic for run in runs]
            found, s = crossing(dynamic, [thin.unit(d) for d in dynamic], [run.pair for run in runs])
            if found == found:
                frequency = s.imag * thin.unit(found) / (2.0 * np.pi)
        theories = (thin, "quasi-steady"), (thin, "potential"), (thick, "potential")
        first, second, third = (_critical(flow, theory) for flow, theory in theories)
        return Onset(mach, found, frequency, first[0], second[0], third[0], third[1].imag / (2.0 * np.pi))

    def table(self) -> str:
        """A line for each run, then one for each Mach number."""
        lines = [
            f"panel of mass {self.mass:g} and thickness {self.thickness:g}: growth and angular frequency of its modes",
            "",
            "   M    lambda     growth  frequency  second mode: growth  frequency   misfit   steps   wall s",
        ]
        for run in self.runs:
            start = f"{run.mach:>5g}{run.dynamic:>9g}"
            if run.failure:
                lines.append(f"{start}  failed: {run.failure}")
                continue
            other = min(run.pair, key=lambda s: s.real)
            lines.append(
                f"{start}{run.fastest.real:>11.5f}{run.fastest.imag:>11.5f}{other.real:>21.5f}{other.imag:>11.5f}"
                f"{run.misfit:>9.0e}{run.steps:>8}{run.wall_time:>9.1f}"
            )
        lines += [
            "",
            "onset of flutter: lambda, and frequency f in cycles per unit of time; theory with the mass and the flow's damping",
            "   M   lambda       f   of 636.57   quasi-steady   potential   potential, thick       f",
        ]
        for mach in self.machs:
            o = self.onset(mach)
            lines.append(
                f"{mach:>5g}{o.found:>9.1f}{o.frequency:>8.4f}{o.found / 636.57:>12.3f}"
                f"{o.quasi_steady:>15.1f}{o.potential:>12.1f}{o.thick:>19.1f}{o.thick_frequency:>8.4f}"
            )
        return "\n".join(lines)

    def save(self, path: Path) -> Path:
        """Write the runs as CSV. FileError."""
        try:
            with path.open("w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file, lineterminator="\n")
                pair = [f"{part}_{n}" for n in (1, 2) for part in ("growth", "frequency")]
                writer.writerow(["mach", "lambda", "growth", "frequency", *pair, "misfit", "steps", "wall_s", "failure"])
                for run in self.runs:
                    both = [f"{x:.8g}" for s in run.pair or (complex("nan"),) * 2 for x in (s.real, s.imag)]
                    fastest = f"{run.fastest.real:.8g}", f"{run.fastest.imag:.8g}"
                    cost = f"{run.misfit:.3g}", run.steps, f"{run.wall_time:.3g}"
                    writer.writerow([repr(run.mach), repr(run.dynamic), *fastest, *both, *cost, run.failure])
        except OSError as error:
            raise FileError(f"{path}: cannot write the table: {error.strerror or error}") from error
        return path


def _critical(flow: Flow, theory: str) -> tuple[float, complex]:
    try:
        return flow.critical(theory)
    except ComputationError:
        return float("nan"), complex("nan")
