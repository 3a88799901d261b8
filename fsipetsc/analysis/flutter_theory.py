"""Linear theory of a clamped panel under a supersonic flow: what the case ``panel`` is compared with. No grid.

Lengths over the panel's, velocities over the speed of sound, densities over those of the flow. With beta^2 = M^2 - 1,

    m w_tt + D w_xxxx + p = 0,      D = M^2 / (lambda beta),      m = mass,

w(0) = w(1) = w_x(0) = w_x(1) = 0. The pressure p on the panel is

    quasi-steady    (M^2/beta) (w_x + (M^2 - 2)/(M^2 - 1) w_t / M)                       (lowest order in the frequency)
    potential       (1/beta) (M W + int_0^x W(xi) (s K + M K')(x - xi) dxi)    for w ~ exp(s t), W = M w_x + s w,
                    K(r) = exp(-sigma M r) I_0(sigma r),    sigma = s/beta^2             (all orders)

the latter from (d_t + M d_x)^2 phi = phi_xx + phi_yy by Laplace's transform along x. Without its w_t the first has flutter from
lambda = 636.57 on, whatever the mass (E. H. Dowell, Aeroelasticity of Plates and Shells, 1975). Galerkin's method; with a
thickness, shear and rotary inertia as Timoshenko has them.

A large motion stretches the panel (von Karman): D w_xxxx becomes D w_xxxx - (6 D / h^2) int_0^1 w_x^2 dx w_xx, h the
thickness over the length, and growth ends. The flow stays linear then, with the quasi-steady pressure (E. H. Dowell, Nonlinear
oscillations of a fluttering plate, AIAA J. 4 (1966) 1267-1275).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fsipetsc.analysis.flutter_motion import Motion
from fsipetsc.analysis.spectra import Complex, Real
from fsipetsc.errors import ComputationError

#: functions for the deflection, natural modes that are kept, points of the quadratures along the panel and up to a point
FUNCTIONS, MODES, POINTS, INNER = 16, 12, 48, 24
#: factor of the shear force
SHEAR = 5.0 / 6.0
#: lambda at which a thin clamped panel begins to flutter without damping, its frequency there over sqrt(D/m)
CRITICAL, FREQUENCY = 636.57, 52.0
#: modes of von Karman's panel, and samples in a period of its motion
FEW, SAMPLES = 6, 100


@dataclass(frozen=True)
class Panel:
    """Clamped panel: its natural modes by Galerkin's method, with stiffness, mass and length 1.

    squares (MODES,) of frequencies; x, weights (POINTS,) of the quadrature; w, w_x (MODES, POINTS); inner_w, inner_w_x
    (MODES, POINTS, INNER) at points between 0 and each x, inner_x and inner_weights (POINTS, INNER) of these. The w are
    normed: the integral of w^2 (and of what rotates) is 1.
    """

    squares: Real
    x: Real
    weights: Real
    w: Real
    w_x: Real
    inner_x: Real
    inner_weights: Real
    inner_w: Real
    inner_w_x: Real


def _gauss(n: int) -> tuple[Real, Real]:
    """Of the interval from 0 to 1."""
    x, weights = np.polynomial.legendre.leggauss(n)
    return 0.5 * (x + 1.0), 0.5 * weights


def _functions(x: Real, power: int, n: int) -> Real:
    """(3, n, ...): (x (1 - x))^power P_k and two derivatives."""
    legendre = np.polynomial.Legendre
    bubble = np.polynomial.Polynomial([0.0, 1.0, -1.0]).convert(kind=legendre, domain=[0, 1]) ** power
    basis = [bubble * legendre.basis(k, domain=[0, 1]) for k in range(n)]
    return np.array([[p.deriv(d)(x) if d else p(x) for p in basis] for d in range(3)])


@lru_cache(maxsize=8)
def panel(thickness: float = 0.0) -> Panel:
    """The modes of a panel of this thickness over its length; 0: Euler and Bernoulli's. Poisson's ratio 1/3 (lambda_e = 2
    mu_e), plane strain.
    """
    from scipy.linalg import eigh

    x, weights = _gauss(POINTS)
    nodes, inner = _gauss(INNER)
    if thickness == 0.0:
        w = _functions(x, 2, FUNCTIONS)
        stiffness, mass = _product(w[2], w[2], weights), _product(w[0], w[0], weights)
    else:
        w = _functions(x, 1, FUNCTIONS)
        shear = SHEAR * 4.0 / thickness**2  # kappa mu h / D with D = mu h^3 / 4
        zero = np.zeros((FUNCTIONS, FUNCTIONS))
        ww, wt, tt = (_product(a, b, weights) for a, b in ((w[1], w[1]), (w[1], w[0]), (w[0], w[0])))
        stiffness = np.block([[shear * ww, -shear * wt], [-shear * wt.T, shear * tt + ww]])
        mass = np.block([[tt, zero], [zero, thickness**2 / 12.0 * tt]])
    squares, vectors = eigh(stiffness, mass)
    modes = vectors[:FUNCTIONS, :MODES].T
    inner_x = x[:, None] * nodes
    inner_w = _functions(inner_x, 2 if thickness == 0.0 else 1, FUNCTIONS)
    return Panel(
        *(squares[:MODES], x, weights, modes @ w[0], modes @ w[1], inner_x, x[:, None] * inner),
        *(np.tensordot(modes, inner_w[d], 1) for d in range(2)),
    )


def _product(a: Real, b: Real, weights: Real) -> Real:
    return (a * weights) @ b.T


@dataclass(frozen=True)
class Flow:
    """A panel in a flow: Mach number, mass over the density of the flow and the length, thickness over the length."""

    mach: float
    mass: float
    thickness: float = 0.0

    @property
    def beta(self) -> float:
        return float(np.sqrt(self.mach**2 - 1.0))

    @property
    def damping(self) -> float:
        """Of the quasi-steady pressure, over the mass: twice the rate at which it damps."""
        M = self.mach
        return M / self.beta * (M * M - 2.0) / (M * M - 1.0) / self.mass

    def unit(self, dynamic: float) -> float:
        """sqrt(D / mass), unit of frequencies, at lambda = dynamic."""
        return float(np.sqrt(self.mach**2 / (dynamic * self.beta) / self.mass))

    def period(self, dynamic: float) -> float:
        """Of flutter at lambda = dynamic, about."""
        return 2.0 * np.pi / (FREQUENCY * self.unit(dynamic))

    def quasi_steady(self, dynamic: float, damped: bool = True) -> Complex:
        """s of the modes at lambda = dynamic, those of Im s >= 0, by frequency. damped: with the term of w_t."""
        modes, unit = panel(self.thickness), self.unit(dynamic)
        force = dynamic * _product(modes.w, modes.w_x, modes.weights)
        squares = np.linalg.eigvals(np.diag(modes.squares) + force).astype(complex) * unit**2
        half = 0.5 * self.damping if damped else 0.0
        root = np.sqrt(half**2 - squares)
        s = np.concatenate([-half + root, -half - root])
        s = s[s.imag >= 0.0]
        return s[np.argsort(s.imag + 1e-9 * s.real)]

    def potential(self, dynamic: float, start: complex | None = None) -> complex:
        """The s of the fastest growth by the theory of all orders, which is looked for from start, or the quasi-steady one, on.
        ComputationError if it is not found.
        """
        modes, unit = panel(self.thickness), self.unit(dynamic)
        found = []
        for s in [start] if start is not None else self.quasi_steady(dynamic)[:2]:
            for _ in range(100):
                forces = self._forces(s) / self.mass
                roots = np.sqrt(-np.linalg.eigvals(np.diag(modes.squares * unit**2) + forces))
                roots = np.concatenate([roots, -roots])
                new = roots[np.argmin(abs(roots - s))]
                s, change = new, abs(new - s)
                if change < 1e-10 * abs(s):
                    found.append(complex(s))
                    break
        if not found:
            raise ComputationError(f"no mode of the potential theory is found at M = {self.mach:g}, lambda = {dynamic:g}")
        return max(found, key=lambda s: s.real)

    def _forces(self, s: complex) -> Complex:
        """What the pressure of each mode does on each."""
        from scipy.special import ive

        modes, M = panel(self.thickness), self.mach
        sigma = s / self.beta**2
        r = modes.x[:, None] - modes.inner_x
        scale = np.exp(abs((sigma * r).real) - sigma * M * r)
        zero, one = scale * ive(0, sigma * r), scale * ive(1, sigma * r)
        kernel = modes.inner_weights * (s * zero + M * sigma * (one - M * zero))
        lagging = np.sum((M * modes.inner_w_x + s * modes.inner_w) * kernel, axis=2)
        p = (M * (M * modes.w_x + s * modes.w) + lagging) / self.beta
        return (modes.w * modes.weights) @ p.T

    def critical(self, theory: str = "quasi-steady", between: tuple[float, float] = (300.0, 1500.0)) -> tuple[float, complex]:
        """(lambda, s) where the growth of the fastest mode becomes positive; theory: quasi-steady, undamped or potential.

        ComputationError where it does not change its sign between these two.
        """
        def fastest(dynamic: float) -> complex:
            if theory == "potential":
                return self.potential(dynamic)
            s = self.quasi_steady(dynamic, damped=theory != "undamped")
            return complex(s[np.argmax(s.real)])

        low, high = between
        least = 1e-9 * self.unit(low)  # round-off of a mode that neither grows nor decays
        if fastest(low).real > least or fastest(high).real <= least:
            raise ComputationError(f"{theory} theory has no flutter between lambda = {low:g} and {high:g} at M = {self.mach:g}")
        while high - low > 1e-7 * high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if fastest(middle).real > least else (middle, high)
        return high, fastest(high)

    def onset(self, theory: str) -> tuple[float, complex]:
        """The same, NaN where there is none."""
        try:
            return self.critical(theory)
        except ComputationError:
            return float("nan"), complex("nan")


def von_karman(
    flow: Flow, dynamic: float, thickness: float, begin: float, end: float, push: float = 1e-3
) -> tuple[Motion, Real]:
    """(motion, x) by the theory at lambda = dynamic from the time begin to end, after a deflection of about push at 0."""
    from scipy.integrate import solve_ivp

    modes, unit = panel(flow.thickness), flow.unit(dynamic)
    w, w_x = modes.w[:FEW], modes.w_x[:FEW]
    stretched = _product(w_x, w_x, modes.weights)
    linear = np.diag(modes.squares[:FEW]) + dynamic * _product(w, w_x, modes.weights)

    def rates(t: float, y: Real) -> Real:
        q, velocity = y[:FEW], y[FEW:]
        tension = stretched @ q
        forces = linear @ q + 6.0 / thickness**2 * (q @ tension) * tension
        return np.concatenate([velocity, -(unit**2) * forces - flow.damping * velocity])

    start = np.zeros(2 * FEW)
    start[:2] = push
    t = np.arange(begin, end, flow.period(dynamic) / SAMPLES)
    y = solve_ivp(rates, (0.0, end), start, t_eval=t, rtol=1e-8, atol=1e-10).y
    return Motion(t, y[:FEW].T @ w, y[FEW:].T @ w), modes.x
