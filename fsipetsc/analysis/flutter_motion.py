"""What a motion of a panel is made of: modes of a small one, limit cycles of a large one.

A small motion is w(x, t) = Re sum_k a_k(x) exp(s_k t). All points of the panel together, deflection and velocity, make a
vector; from one time to the next it is multiplied by a matrix A whose eigenvalues are exp(s_k dt). A is found by least
squares on the leading singular vectors of what was seen (P. J. Schmid, Dynamic mode decomposition of numerical and
experimental data, J. Fluid Mech. 656 (2010)), so that modes of nearly one frequency are told apart by their shapes, in less
than a period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.analysis.spectra import Complex, Real
from fsipetsc.errors import ComputationError, InputError

if TYPE_CHECKING:
    from fsipetsc.output.reader import Run

#: singular values and amplitudes below these parts of the largest one are noise
NOISE, FAINT = 1e-5, 1e-3
#: what grows or decays by more than exp of this within the time is noise, too
STEEPEST = 12.0
#: singular vectors at most, two for each mode
RANK = 16


@dataclass(frozen=True)
class Motion:
    """Of a panel: t (nt,), equal steps; deflection w and velocity v (nt, nx)."""

    t: Real
    w: Real
    v: Real

    def after(self, t: float) -> Motion:
        """From the time t on."""
        part = self.t >= t - 1e-9 * max(1.0, abs(t))
        return Motion(self.t[part], self.w[part], self.v[part])


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


def fit_modes(motion: Motion) -> tuple[Complex, float]:
    """(s of the modes that oscillate, Im s > 0, by frequency; what is not in the modes, relative to the motion). The first two
    are those that meet in flutter. ComputationError where there are fewer.
    """
    dt = float(motion.t[1] - motion.t[0])
    scales = [max(float(np.abs(part).max()), 1e-300) for part in (motion.w, motion.v)]
    seen = np.concatenate([motion.w / scales[0], motion.v / scales[1]], axis=1).T
    U, sizes, Vt = np.linalg.svd(seen[:, :-1], full_matrices=False)
    r = min(RANK, int(np.sum(sizes > NOISE * sizes[0])), (len(motion.t) - 1) // 2)
    U, sizes, Vt = U[:, :r], sizes[:r], Vt[:r]
    values, vectors = np.linalg.eig(U.T @ seen[:, 1:] @ (Vt.T / sizes))
    s = np.log(np.where(values == 0.0, 1e-300, values.astype(complex))) / dt
    lasting = np.abs(s.real) * (motion.t[-1] - motion.t[0]) < STEEPEST
    s, shapes = s[lasting], U @ vectors[:, lasting]
    times = np.exp(np.outer(s, motion.t - 0.5 * (motion.t[0] + motion.t[-1])))
    # the amplitudes by least squares over all times at once
    normal = (shapes.conj().T @ shapes) * (times.conj() @ times.T)
    a = np.linalg.lstsq(normal, np.einsum("xk,xt,kt->k", shapes.conj(), seen, times.conj()), rcond=1e-13)[0]
    misfit = float(np.linalg.norm(seen - (shapes * a @ times).real) / np.linalg.norm(seen))
    deflections = np.abs(a) * np.abs(shapes[: len(shapes) // 2]).max(axis=0)
    found = s[(s.imag > 0.0) & (deflections > FAINT * deflections.max(initial=0.0))]
    if len(found) < 2:
        raise ComputationError(f"{len(found)} modes oscillate in the motion of the panel, where two should")
    return found[np.argsort(found.imag)], misfit


def crossing(dynamic: Sequence[float], units: Sequence[float], pairs: Sequence[Sequence[complex]]) -> tuple[float, complex]:
    """(lambda, s over the unit) where the growth of the faster of two modes becomes positive, from their s at some lambda; NaN
    if it does not between these.

    units: of frequency, sqrt(D/m), at each. The growth itself has a kink where the frequencies meet, but the
    coefficients of (s - s1)(s - s1*)(s - s2)(s - s2*) are smooth in lambda: a parabola is laid through them.
    """
    order = np.argsort(dynamic)
    x = np.asarray(dynamic, float)[order]
    scaled = [np.asarray(pairs[i]) / units[i] for i in order]
    found = np.array([np.poly(np.concatenate([pair, pair.conj()])).real[1:] for pair in scaled])
    centre, half = 0.5 * (x[0] + x[-1]), 0.5 * (x[-1] - x[0])
    fits = np.polynomial.polynomial.polyfit((x - centre) / half, found, min(len(x) - 1, 2))

    def fastest(at: float) -> complex:
        roots = np.roots([1.0, *np.polynomial.polynomial.polyval((at - centre) / half, fits)])
        s = roots[np.argmax(roots.real)]
        return complex(s.real, abs(s.imag))

    fine = np.linspace(x[0], x[-1], 401)
    grows = np.array([fastest(at).real > 0.0 for at in fine])
    first = int(np.argmax(grows))
    if not grows.any() or first == 0:
        return float("nan"), complex("nan")
    low, high = fine[first - 1], fine[first]
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fastest(middle).real > 0.0 else (middle, high)
    return float(high), fastest(high)


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
    periods = len(at) - 1
    if periods < 2:
        raise ComputationError(f"{max(periods, 0)} periods of the panel's motion are seen, where two should be")
    passed = motion.t[at] + (motion.t[1] - motion.t[0]) * (mean - w[at]) / (w[at + 1] - w[at])
    tops, lows = (np.array([_height(sign * w[a : b + 1]) for a, b in zip(at, at[1:])]) for sign in (1, -1))
    amplitude, centre = 0.5 * float(np.mean(tops + lows)), 0.5 * float(np.mean(tops - lows))
    frequency = periods / float(passed[-1] - passed[0])
    return LimitCycle(float(X[i]), amplitude, centre, frequency, periods, float(np.ptp(tops) / amplitude))


def _height(w: Real) -> float:
    """The maximum, by a parabola through the largest value and its neighbours."""
    k = int(np.argmax(w))
    if not 0 < k < len(w) - 1:
        return float(w[k])
    a, b, c = w[k - 1 : k + 2]
    bend = a - 2.0 * b + c
    return float(b - (c - a) ** 2 / (8.0 * bend)) if bend < 0.0 else float(b)
