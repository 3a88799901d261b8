"""What the linearised problem says about stability: energy growth, spectrum, and the largest step of RK4.

Energy. With w the vector of Linear, w = P w, the energy changes by d/dt |w|^2 / 2 = w^T P L w. Its largest value
for |w| = 1 is the largest eigenvalue of the symmetric part of Z^T P L Z, Z an orthonormal basis of the range of P:
the growth rate of |w|, 0 or less where the estimate holds.

Spectrum. A mode grows like exp(Re lambda t), lambda an eigenvalue of P L P. The classical Runge-Kutta method with a
projection per stage multiplies it by R(dt lambda), R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24; the step limit is the
largest dt with |R| <= 1 for all modes (one that grows counts with its frequency alone).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, identity, lil_matrix

from fsipetsc.analysis.stability_linear import Linear, assemble
from fsipetsc.analysis.stability_state import Constant

Array = NDArray[np.float64]
#: growth, relative to the largest |lambda|, that counts as round-off: of the energy, of a mode (an eigenvalue of a
#: matrix that is not normal is less certain)
ENERGY_TOLERANCE, MODE_TOLERANCE = 1e-10, 1e-9
#: part of the step limit of the uncoupled layers that a treatment of the interface must leave
STEP_KEPT = 0.95
#: unknowns from which SLEPc, if it is there, computes the few eigenvalues that are needed
MANY = 2000
_SEARCH = {"modulus": (16, 1e-6, 300), "symmetric": (1, 0.1 * ENERGY_TOLERANCE, 1000), "rightmost": (1, 1e-10, 30)}
_SCAN = np.linspace(0.01, 3.2, 640)


@dataclass(frozen=True)
class Result:
    """Numbers of one problem; rates in 1/s, steps in s. The first four are without the heating by c T^ - p^."""

    order: int
    coupling: str
    density_ratio: float
    stiffness_ratio: float
    energy_growth: float
    mode_growth: float
    radius: float
    step: float
    step_alone: float
    heated_energy_growth: float
    heated_mode_growth: float

    @property
    def estimate(self) -> bool:
        """The energy never grows, to round-off."""
        return self.energy_growth <= ENERGY_TOLERANCE * self.radius

    @property
    def stable(self) -> bool:
        """No mode grows."""
        return self.mode_growth <= MODE_TOLERANCE * self.radius

    @property
    def heated_stable(self) -> bool:
        """No mode grows with the heating either."""
        return self.heated_mode_growth <= MODE_TOLERANCE * self.radius

    @property
    def step_kept(self) -> bool:
        """The interface costs no time step to speak of."""
        return self.step >= STEP_KEPT * self.step_alone

    @property
    def step_ratio(self) -> float:
        """Step limit over that of the uncoupled layers."""
        return self.step / self.step_alone

    def keeps(self, promise: str) -> bool:
        """What is promised holds. "modes": no mode grows and the step is kept; "estimate": the energy too."""
        return self.stable and self.step_kept and (self.estimate or promise != "estimate")


def measure(state: Constant, order: int, n: int, h: float, coupling: str, narrow: bool = False) -> Result:
    """All numbers for n points of spacing h [m] in each layer, and D twice or narrow second derivatives."""
    problem = assemble(state, order, n, h, coupling, narrow)
    basis = range_basis(problem)
    growth, modes, extreme = _growths(problem, basis, False)
    heated = _growths(problem, basis, True)[:2] if state.excess != 0.0 else (growth, modes)
    return Result(
        order,
        coupling,
        state.solid.m0 / state.rho,
        state.solid.K / state.p,
        growth,
        modes,
        float(np.abs(extreme).max()),
        step_limit(extreme),
        step_alone(problem),
        *heated,
    )


def range_basis(problem: Linear) -> csr_matrix:
    """Orthonormal basis, (6n, m), of the disturbances that meet all conditions."""
    P = problem.projection
    changed = csr_matrix(P - identity(P.shape[0])).tocoo()
    touched = np.unique(np.concatenate([changed.row[changed.data != 0], changed.col[changed.data != 0]]))
    others = np.setdiff1d(np.arange(P.shape[0]), touched)
    left, sizes, _ = np.linalg.svd(P[touched][:, touched].toarray())
    left = left[:, sizes > 1e-9 * sizes[0]]
    basis = lil_matrix((P.shape[0], len(others) + left.shape[1]))
    basis[others, np.arange(len(others))] = 1.0
    basis[np.ix_(touched, len(others) + np.arange(left.shape[1]))] = left
    return csr_matrix(basis)


def _growths(problem: Linear, basis: csr_matrix, heating: bool) -> tuple[float, float, NDArray[np.complex128]]:
    """(largest growth rate of the energy, of a mode, the eigenvalues or those of largest modulus)."""
    A = csr_matrix(basis.T @ problem.operator(heating) @ basis)
    symmetric = csr_matrix((A + A.T) / 2)
    extreme = eigenvalues(A, "modulus")
    growth = float(eigenvalues(symmetric, "symmetric").real.max())
    if extreme.size == A.shape[0]:
        return growth, float(extreme.real.max()), extreme
    if growth <= ENERGY_TOLERANCE * np.abs(extreme).max():
        return growth, growth, extreme  # no mode grows faster than the energy can
    return growth, float(eigenvalues(A, "rightmost").real.max()), extreme


def step_alone(problem: Linear) -> float:
    """Step limit of the two layers with u = 0 and T = 0 at the interface too: what it is without coupling."""
    half = 3 * problem.n
    A = csr_matrix(problem.layers @ problem.raw @ problem.layers)
    return min(step_limit(eigenvalues(layer, "modulus")) for layer in (A[:half, :half], A[half:, half:]))


def step_limit(spectrum: NDArray[np.complex128]) -> float:
    """The largest dt [s] for which RK4 amplifies none of these modes."""
    spectrum = np.minimum(spectrum.real, 0.0) + 1j * spectrum.imag
    modulus = np.abs(spectrum)
    kept = modulus > 0.1 * modulus.max()  # |R| > 1 begins at |z| = 2.6 or more: slower ones do not count
    spectrum, modulus = spectrum[kept], modulus[kept]
    directions = spectrum / modulus
    above = amplification(directions[:, None] * _SCAN) > 1.0 + 1e-12
    first = np.where(above.any(axis=1), above.argmax(axis=1), len(_SCAN) - 1)
    low, high = np.where(first > 0, _SCAN[first - 1], 0.0), _SCAN[first]
    for _ in range(40):
        middle = (low + high) / 2
        outside = amplification(directions * middle) > 1.0 + 1e-12
        low, high = np.where(outside, low, middle), np.where(outside, middle, high)
    return float((low / modulus).min())


def amplification(z: NDArray[np.complex128]) -> Array:
    """|R(z)| of the classical Runge-Kutta method."""
    return np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4))))


def eigenvalues(A: csr_matrix, which: str) -> NDArray[np.complex128]:
    """All eigenvalues of A, or only those of largest "modulus", the "rightmost", or the largest of a "symmetric" A:
    few if A is large and SLEPc is there and finds them soon."""
    if A.shape[0] > MANY:
        found = few_eigenvalues(A, which)
        if found is not None:
            return found
    dense = A.toarray()
    return np.linalg.eigvalsh(dense).astype(complex) if which == "symmetric" else np.linalg.eigvals(dense)


def few_eigenvalues(A: csr_matrix, which: str) -> NDArray[np.complex128] | None:
    """The same by SLEPc, on this rank; None if it is not installed or does not find them soon."""
    try:
        import slepc4py
    except ModuleNotFoundError:
        return None
    slepc4py.init([])
    from petsc4py import PETSc
    from slepc4py import SLEPc

    kind, end = SLEPc.EPS.ProblemType, SLEPc.EPS.Which
    # how many, to which part of the norm of A, and for how long
    count, tolerance, restarts = _SEARCH[which]
    layout = (A.indptr.astype(PETSc.IntType), A.indices.astype(PETSc.IntType), A.data)
    matrix = PETSc.Mat().createAIJ(A.shape, csr=layout, comm=PETSc.COMM_SELF)
    solver = SLEPc.EPS().create(comm=PETSc.COMM_SELF)
    solver.setOperators(matrix)
    solver.setProblemType(kind.HEP if which == "symmetric" else kind.NHEP)
    solver.setWhichEigenpairs(end.LARGEST_MAGNITUDE if which == "modulus" else end.LARGEST_REAL)
    solver.setDimensions(count, 120)
    solver.setTolerances(tolerance, restarts)
    solver.setConvergenceTest(SLEPc.EPS.Conv.NORM)
    solver.solve()
    found = [solver.getEigenvalue(i) for i in range(solver.getConverged())]
    solver.destroy()
    matrix.destroy()
    return np.array(found, complex) if len(found) >= count else None
