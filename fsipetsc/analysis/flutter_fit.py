"""Growth and frequency of the modes of a small motion of a panel, from what was seen of it.

The motion is w(x, t) = Re sum_k a_k(x) exp(s_k t). All points of the panel together, deflection and velocity, make a
vector; from one time to the next it is multiplied by a matrix A whose eigenvalues are exp(s_k dt). A is found by least
squares on the leading singular vectors of what was seen (P. J. Schmid, Dynamic mode decomposition of numerical and
experimental data, J. Fluid Mech. 656 (2010)), so that modes of nearly one frequency are told apart by their shapes, in less
than a period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fsipetsc.errors import ComputationError

Real = NDArray[np.float64]
#: singular values and amplitudes below these parts of the largest one are noise
NOISE, FAINT = 1e-5, 1e-3
#: what grows or decays by more than exp of this within the time is noise, too
STEEPEST = 12.0


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


@dataclass(frozen=True)
class Modes:
    """s (n,) of what oscillates, Im s > 0, and the amplitudes (n,) of its deflection in the middle of the time, the largest
    first. misfit: what is not in the modes, relative to the motion.
    """

    s: NDArray[np.complex128]
    amplitudes: Real
    misfit: float

    @property
    def pair(self) -> NDArray[np.complex128]:
        """(2,) s of the two modes of the lowest frequencies, by frequency: those that meet in flutter. ComputationError."""
        if len(self.s) < 2:
            raise ComputationError(f"{len(self.s)} modes are seen in the motion of the panel, where two should be")
        lowest = np.argsort(self.s.imag)[:2]
        return self.s[lowest]


def fit_modes(motion: Motion, rank: int = 16) -> Modes:
    """The modes of a small motion; rank: at most so many, twice for each that oscillates. ComputationError where there is
    none.
    """
    dt = float(motion.t[1] - motion.t[0])
    scales = [max(float(np.abs(part).max()), 1e-300) for part in (motion.w, motion.v)]
    seen = np.concatenate([motion.w / scales[0], motion.v / scales[1]], axis=1).T
    U, sizes, Vt = np.linalg.svd(seen[:, :-1], full_matrices=False)
    r = min(rank, int(np.sum(sizes > NOISE * sizes[0])), (len(motion.t) - 1) // 2)
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
    half = len(shapes) // 2
    sizes = scales[0] * np.abs(a) * np.abs(shapes[:half]).max(axis=0) * 2.0
    kept = (s.imag > 0.0) & (sizes > FAINT * sizes.max())
    if not kept.any():
        raise ComputationError("nothing oscillates in the motion of the panel")
    order = np.argsort(-sizes[kept])
    return Modes(s[kept][order], sizes[kept][order], misfit)


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
