"""Motions of a panel under a supersonic flow: the modes of a run, and where one grows.

Lengths are over the panel's, velocities over the speed of sound, densities over that of the flow;
the stiffness is D = M^2 / (lambda sqrt(M^2 - 1)). A thin clamped panel without damping flutters
from lambda = 636.57 on, whatever its mass, a hinged one from 343.36 on (E. H. Dowell,
Aeroelasticity of Plates and Shells, 1975); verify/beams.py derives both.

A small motion that is seen is w(x, t) = Re sum_k a_k(x) exp(s_k t). Deflections and velocities of
all points make a vector, which a matrix A with the eigenvalues exp(s_k dt) takes from one time to
the next. A is found by least squares on the leading singular vectors of what was seen (P. J.
Schmid, Dynamic mode decomposition of numerical and experimental data, J. Fluid Mech. 656 (2010)),
so that modes of nearly one frequency are told apart by their shapes, in less than a period.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from fsipetsc.errors import ComputationError
from fsipetsc.output.reader import Run
from fsipetsc.studies.spectra import Complex, Real

#: singular values and amplitudes below these parts of the largest one are noise
NOISE, FAINT = 1e-5, 1e-3
#: what grows or decays by more than exp of this within the time is noise, too
STEEPEST = 12.0
#: singular vectors at most, two for each mode
RANK = 16


def unit_of(mach: float, mass: float, dynamic: float) -> float:
    """sqrt(D / mass), unit of frequencies, at lambda = dynamic; mass: over density and length."""
    return float(np.sqrt(mach**2 / (dynamic * np.sqrt(mach**2 - 1.0)) / mass))


def motion_of(run: Run, begin: float) -> tuple[Real, Real, Real]:
    """t (nt,), equal steps; deflection w and velocity v (nt, nx) of the middle row of the solid,
    from a time on."""
    solid = next(layer for layer in run.layers if layer.kind == "solid")
    t, row = run.time, len(solid.Y) // 2
    if len(t) > 2 and not np.isclose(t[-1] - t[-2], t[1] - t[0], rtol=1e-6):
        t = t[:-1]
    chosen = np.flatnonzero(t >= begin - 1e-9 * max(1.0, abs(begin)))
    w, v = (np.array([solid.frame(k)[name][row] for k in chosen]) for name in ("y", "v"))
    return t[chosen], w - solid.Y[row], v


def fit_modes(t: Real, w: Real, v: Real) -> tuple[Complex, float]:
    """(s of the modes that oscillate, Im s > 0, by frequency; part of the motion in no mode).

    The first two are those that meet in flutter. ComputationError where there are fewer.
    """
    parts = [part / max(float(np.abs(part).max()), 1e-300) for part in (w, v)]
    seen = np.concatenate(parts, axis=1).T
    U, sizes, Vt = np.linalg.svd(seen[:, :-1], full_matrices=False)
    r = min(RANK, int(np.sum(sizes > NOISE * sizes[0])), (len(t) - 1) // 2)
    U, sizes, Vt = U[:, :r], sizes[:r], Vt[:r]
    values, vectors = np.linalg.eig(U.T @ seen[:, 1:] @ (Vt.T / sizes))
    s = np.log(np.where(values == 0.0, 1e-300, values.astype(complex))) / (t[1] - t[0])
    lasting = np.abs(s.real) * (t[-1] - t[0]) < STEEPEST
    s, shapes = s[lasting], U @ vectors[:, lasting]
    times = np.exp(np.outer(s, t - 0.5 * (t[0] + t[-1])))
    # the amplitudes by least squares over all times at once
    normal = (shapes.conj().T @ shapes) * (times.conj() @ times.T)
    projected = np.einsum("xk,xt,kt->k", shapes.conj(), seen, times.conj())
    a = np.linalg.lstsq(normal, projected, rcond=1e-13)[0]
    misfit = float(np.linalg.norm(seen - (shapes * a @ times).real) / np.linalg.norm(seen))
    deflections = np.abs(a) * np.abs(shapes[: len(shapes) // 2]).max(axis=0)
    found = s[(s.imag > 0.0) & (deflections > FAINT * deflections.max(initial=0.0))]
    if len(found) < 2:
        raise ComputationError(f"{len(found)} modes oscillate in the motion of the panel, not two")
    return found[np.argsort(found.imag)], misfit


def crossing(
    mach: float, mass: float, dynamic: Sequence[float], pairs: Sequence[Sequence[complex]]
) -> tuple[float, complex]:
    """(lambda, s) where the growth of the faster of two modes becomes positive, from their s at
    some lambda; NaN if it does not change its sign between these.

    The growth has a kink where the frequencies meet, but over ``unit_of`` the coefficients of
    (s - s1)(s - s1*)(s - s2)(s - s2*) are smooth: parabolas are laid through them. These are over
    lambda^2, as the last coefficient is linear in it where pressure is steady. From two lambdas
    that are 17 % apart the onset is 0.1 to 0.2 % too low.
    """
    x = np.asarray(dynamic, float) ** 2
    scaled = [np.asarray(s) / unit_of(mach, mass, at) for s, at in zip(pairs, dynamic, strict=True)]
    found = np.array([np.poly(np.concatenate([pair, pair.conj()])).real for pair in scaled])
    centre = 0.5 * (x.min() + x.max())
    fits = np.polynomial.polynomial.polyfit(x - centre, found, min(len(x) - 1, 2))

    def fastest(at: float) -> complex:
        roots = np.roots(np.polynomial.polynomial.polyval(at * at - centre, fits))
        s = roots[np.argmax(roots.real)]
        return complex(s.real, abs(s.imag))

    fine = np.linspace(min(dynamic), max(dynamic), 401)
    first = int(np.argmax([fastest(at).real > 0.0 for at in fine]))
    if first == 0:
        return float("nan"), complex("nan+nanj")
    at = float(brentq(lambda at: fastest(at).real, fine[first - 1], fine[first]))
    return at, unit_of(mach, mass, at) * fastest(at)
