"""Limit cycles of the panel: of a result, and of von Karman's theory in quasi-steady flow.

A panel clamped at both ends is stretched where it bends: D w_xxxx becomes

    D w_xxxx - (6 D / h^2) int_0^1 w_x^2 dx  w_xx,

h the thickness over the length, and the growth of a motion ends. The flow stays linear in this theory, with the pressure of
fsipetsc.analysis.flutter_theory (E. H. Dowell, Nonlinear oscillations of a fluttering plate, AIAA J. 4 (1966) 1267-1275).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.analysis.flutter_fit import Motion, Real
from fsipetsc.analysis.flutter_theory import Flow, panel
from fsipetsc.errors import ComputationError, InputError

if TYPE_CHECKING:
    from fsipetsc.output.reader import Run

#: modes of the theory, and of its period how many samples
MODES, SAMPLES = 6, 100


def motion_of(run: Run) -> tuple[Motion, Real]:
    """(motion of the middle row of the solid, X of its points) of a result in two dimensions; its frames must be equally far
    apart, but for the last one. InputError.
    """
    solids = [layer for layer in run.layers if layer.kind == "solid"] if run.dimension == 2 else []
    if not solids:
        raise InputError(f"{run.path}: no result of a solid in two dimensions, such as panel")
    t = run.time
    if len(t) > 2 and not np.isclose(t[-1] - t[-2], t[1] - t[0], rtol=1e-6):
        t = t[:-1]
    if len(t) < 2 or not np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6):
        raise InputError(f"{run.path}: expected frames at equal distances in time, as -fsi_output_dt saves them")
    solid = solids[0]
    row = len(solid.Y) // 2
    frames = [solid.frame(k) for k in range(len(t))]
    w, v = (np.array([frame[name][row] for frame in frames]) for name in ("y", "v"))
    return Motion(t, w - solid.Y[row], v), solid.X


def von_karman(
    flow: Flow, dynamic: float, thickness: float, begin: float, end: float, push: float = 1e-3
) -> tuple[Motion, Real]:
    """(motion, x) by the theory at lambda = dynamic from the time begin to end, after a deflection of about push at 0."""
    from scipy.integrate import solve_ivp

    modes = panel(flow.thickness)
    w, w_x = modes.w[:MODES], modes.w_x[:MODES]
    stretched = (w_x * modes.weights) @ w_x.T
    unit = flow.unit(dynamic)
    linear = np.diag(modes.squares[:MODES]) + dynamic * (w * modes.weights) @ w_x.T

    def rates(t: float, y: Real) -> Real:
        q, velocity = y[:MODES], y[MODES:]
        tension = stretched @ q
        forces = linear @ q + 6.0 / thickness**2 * (q @ tension) * tension
        return np.concatenate([velocity, -(unit**2) * forces - flow.damping * velocity])

    start = np.zeros(2 * MODES)
    start[:2] = push
    t = np.arange(begin, end, 2.0 * np.pi / (52.0 * unit) / SAMPLES)
    y = solve_ivp(rates, (0.0, end), start, t_eval=t, rtol=1e-8, atol=1e-10).y
    return Motion(t, y[:MODES].T @ w, y[MODES:].T @ w), modes.x


@dataclass(frozen=True)
class LimitCycle:
    """Of the point of the largest deflection: its X; half the distance of the extremes and their mean [m], averages over the
    periods; the frequency [1/s] from the upward passages of the mean; how many periods these are, and by how much the heights
    of their maxima differ, relative: amplitudes swing about the last one for ten periods.
    """

    X: float
    amplitude: float
    mean: float
    frequency: float
    periods: int
    spread: float


def limit_cycle(motion: Motion, X: Real) -> LimitCycle:
    """Of the motion as it is given: the end of a run. X (nx,) of its points. ComputationError with less than two periods."""
    i = int(np.argmax(np.ptp(motion.w, axis=0)))
    w = motion.w[:, i]
    mean = 0.5 * (w.max() + w.min())
    at = np.flatnonzero((w[:-1] < mean) & (w[1:] >= mean))
    if len(at) < 3:
        raise ComputationError(f"{max(len(at) - 1, 0)} periods of the panel's motion are seen, where two should be")
    step = motion.t[1] - motion.t[0]
    passed = motion.t[at] + step * (mean - w[at]) / (w[at + 1] - w[at])
    tops = np.array([_height(w[a : b + 1]) for a, b in zip(at, at[1:], strict=False)])
    lows = np.array([_height(-w[a : b + 1]) for a, b in zip(at, at[1:], strict=False)])
    amplitude, centre = 0.5 * float(np.mean(tops + lows)), 0.5 * float(np.mean(tops - lows))
    periods = len(at) - 1
    frequency, spread = periods / float(passed[-1] - passed[0]), float(np.ptp(tops) / amplitude)
    return LimitCycle(float(X[i]), amplitude, centre, frequency, periods, spread)


def _height(w: Real) -> float:
    """The maximum, by a parabola through the largest value and its neighbours."""
    k = int(np.argmax(w))
    if not 0 < k < len(w) - 1:
        return float(w[k])
    a, b, c = w[k - 1 : k + 2]
    bend = a - 2.0 * b + c
    return float(b - (c - a) ** 2 / (8.0 * bend)) if bend < 0.0 else float(b)


def report(path: str) -> str:
    """What the second half of a result says, and the theory beside it, in lines. InputError, FileError; ComputationError where
    there are not two periods.
    """
    import fsipetsc

    with fsipetsc.open_run(path) as run:
        motion, X = motion_of(run)
        found = limit_cycle(motion.after(0.5 * motion.t[-1]), X)
        opt = run.options
    h = opt.get("panel_thickness", float("nan"))
    lines = [
        f"{path}: the last {found.periods} periods, at X = {found.X:.4g}, where the panel moves most",
        f"amplitude {found.amplitude:.5g} = {found.amplitude / h:.3g} thicknesses about {found.mean:.2g}; frequency "
        f"{found.frequency:.5g}; their maxima differ by {100 * found.spread:.2g} % of the amplitude",
    ]
    if run.case == "panel":
        flow = Flow(opt["panel_mach"], opt["panel_mass"], h)
        dynamic, period = opt["panel_lambda"], 2.0 * np.pi / (52.0 * flow.unit(opt["panel_lambda"]))
        if flow.quasi_steady(dynamic)[:2].real.max() > 0.0:
            theory = limit_cycle(*von_karman(flow, dynamic, h, 40.0 * period, 60.0 * period))
            lines.append(
                f"von Karman's panel in quasi-steady flow: amplitude {theory.amplitude:.5g} = {theory.amplitude / h:.3g} "
                f"thicknesses; frequency {theory.frequency:.5g}"
            )
    return "\n".join(lines)
