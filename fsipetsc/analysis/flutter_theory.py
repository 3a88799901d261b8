"""Linear theory of a clamped panel under a supersonic flow, by Galerkin's method, without a grid.

Lengths are over the panel's, velocities over the speed of sound, densities over that of the flow.
With beta^2 = M^2 - 1 and the pressure p of quasi-steady flow, of lowest order in the frequency,

    m w_tt + D w_xxxx + p = 0,    w = w_x = 0 at x = 0 and 1,    D = M^2 / (lambda beta),
    p = (M^2/beta) (w_x + (M^2 - 2)/(M^2 - 1) w_t / M).

Without the term w_t flutter begins at lambda = 636.57, whatever the mass m (E. H. Dowell,
Aeroelasticity of Plates and Shells, 1975). A panel with a thickness has shear and rotary inertia,
as Timoshenko has them, Poisson's ratio 1/3 (lambda_e = 2 mu_e) and plane strain.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fsipetsc.analysis.spectra import Complex, Real, bisect

#: functions for the deflection, natural modes that are kept, points of the quadrature
FUNCTIONS, MODES, POINTS = 16, 12, 48
#: factor of the shear force
SHEAR = 5.0 / 6.0
#: lambda at which a thin panel flutters without damping, its frequency there over sqrt(D/m)
CRITICAL, FREQUENCY = 636.57, 52.0
#: where the onset is looked for
BETWEEN = 300.0, 1500.0


@lru_cache(maxsize=8)
def panel(thickness: float = 0.0) -> tuple[Real, Real]:
    """(squares of the frequencies (MODES,), integrals of w_i w_j,x (MODES, MODES)) of the modes.

    Stiffness, mass and length are 1, the thickness is over the length; 0: Euler and Bernoulli's.
    """
    from scipy.linalg import eigh

    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    legendre = np.polynomial.Legendre
    bubble = np.polynomial.Polynomial([0.0, 1.0, -1.0]).convert(kind=legendre, domain=[0, 1])
    bubble = bubble if thickness else bubble**2  # thick panels are held by w and the rotation alone
    basis = [bubble * legendre.basis(k, domain=[0, 1]) for k in range(FUNCTIONS)]
    w, w_x, w_xx = (
        np.array([(p.deriv(n) if n else p)(0.5 * (nodes + 1.0)) for p in basis]) for n in range(3)
    )

    def integrals(a: Real, b: Real) -> Real:
        return (a * 0.5 * weights) @ b.T

    if thickness == 0.0:
        stiffness, mass = integrals(w_xx, w_xx), integrals(w, w)
    else:
        shear = SHEAR * 4.0 / thickness**2  # kappa mu h / D with D = mu h^3 / 4
        across, bent = -shear * integrals(w_x, w), shear * integrals(w, w) + integrals(w_x, w_x)
        stiffness = np.block([[shear * integrals(w_x, w_x), across], [across.T, bent]])
        mass = np.kron(np.diag([1.0, thickness**2 / 12.0]), integrals(w, w))
    squares, vectors = eigh(stiffness, mass)
    modes = vectors[:FUNCTIONS, :MODES].T
    return squares[:MODES], modes @ integrals(w, w_x) @ modes.T


@dataclass(frozen=True)
class Flow:
    """A panel in a flow: Mach number, mass over density and length, thickness over length."""

    mach: float
    mass: float
    thickness: float = 0.0

    def unit(self, dynamic: float) -> float:
        """sqrt(D / mass), unit of frequencies, at lambda = dynamic."""
        beta = np.sqrt(self.mach**2 - 1.0)
        return float(np.sqrt(self.mach**2 / (dynamic * beta) / self.mass))

    def period(self, dynamic: float) -> float:
        """Of flutter at lambda = dynamic, about."""
        return 2.0 * np.pi / (FREQUENCY * self.unit(dynamic))

    def modes(self, dynamic: float, damped: bool = True) -> Complex:
        """s of the modes at lambda = dynamic with Im s >= 0, by frequency. damped: with w_t."""
        squares, forces = panel(self.thickness)
        M, unit = self.mach, self.unit(dynamic)
        damping = (M * M - 2.0) / (M * M - 1.0) ** 1.5 * M / self.mass if damped else 0.0
        values = np.linalg.eigvals(np.diag(squares) + dynamic * forces).astype(complex) * unit**2
        root = np.sqrt(0.25 * damping**2 - values)
        s = np.concatenate([root, -root]) - 0.5 * damping
        s = s[s.imag >= 0.0]
        return s[np.argsort(s.imag + 1e-9 * s.real)]

    def onset(self, damped: bool = True) -> tuple[float, complex]:
        """(lambda, s) where the fastest mode begins to grow; NaN where none does."""
        low, high = BETWEEN
        least = 1e-9 * self.unit(low)  # round-off of a mode that neither grows nor decays

        def fastest(dynamic: float) -> complex:
            s = self.modes(dynamic, damped)
            return complex(s[np.argmax(s.real)])

        if fastest(low).real > least or fastest(high).real <= least:
            return float("nan"), complex("nan")
        found = bisect(lambda at: fastest(at).real > least, low, high, halvings=40)
        return found, fastest(found)
