"""The command `modes CASE`: small motions about a steady state, by the scheme's right-hand side;
beside them exact ones where references have them.

The conditions make P q of the unknowns q, and L q are the rates of that. What may be disturbed is
what P lets through, and P L acts on it: its eigenvalues are those of the modes.

``modes_near`` finds eigenvalues next to an expected one, of any blocks. ``column_modes`` finds all
where columns of blocks are alike: those along flat layers, those of a ring in the frame of radius
and angle; in one dimension there is one column. The derivatives of column m by unknown j of column
0, times exp(-i n phi), phi = 2 pi m / M, and added up over the M columns, are column j of a matrix
for what is proportional to exp(i n phi).
"""

from collections.abc import Iterable, Mapping
from itertools import product
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import orth
from scipy.optimize import brentq
from scipy.sparse.linalg import LinearOperator, eigs, splu

from fsipetsc.cases import load_case
from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.options import Option
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.trials import Study, reference

#: least disturbance, as a fraction of what there is; its multiples and their weights, of order 6.
#: So growth of energy is right to 3e-11 of the largest rate, also if p is a hundred times K
NUDGE = 2.0**-8
CENTRAL = (1, 3 / 4), (2, -3 / 20), (3, 1 / 60)
#: what moves by less than this part of the rate of a mode is at rest
AT_REST = 1e-9
OPTIONS = (
    Option("ring_angular", int, 2, "", "waves around a ring", check="nonnegative"),
    Option("modes_count", int, 10, "", "how many modes, slowest first", check="positive"),
    Option("modes_near", float, 1.0, "1/s", "next to it; ring, shell: unused", check="positive"),
)
#: case -> options that keep it in a steady state
STEADY = {
    "ring": {"ring_pulse": 0.0},
    "shell": {"shell_charge": 0.0, "fsi_shock": 0.0},
    "panel": {"panel_push": 0.0},
}
#: options of a case, whose others are those of STEADY or defaults, and the column of the reference
EXACT = (
    ({"ring_gas": True, "ring_angular": 2}, "ring"),
    ({"ring_gas": False, "ring_angular": 2}, "ring in vacuum"),
    ({"shell_gas": "centre", "shell_kappa": 1}, "cylinder"),
    ({"shell_gas": "centre", "shell_kappa": 2}, "sphere"),
)


def modes(arguments: list[str], comm: Comm) -> None:
    """Run the command. Collective, rank 0 computes; FileError; InputError, also if not steady."""
    case, name = together(comm, lambda: load_case(arguments[0])), arguments[0]
    study = Study(comm, arguments[1:], OPTIONS, "modes", case)
    from fsipetsc.stepping.run import build_problem  # with PETSc, which has been started now

    opt = {**study.opt, **STEADY.get(name, {})}
    order, count, n = opt["fsi_order"], opt["modes_count"], opt["ring_angular"] * (name == "ring")
    problem = build_problem(case, opt, comm)
    usual = {o.name: o.default for o in case.OPTIONS if o.name != "ring_around"}
    usual |= STEADY.get(name, {})
    columns = [column for own, column in EXACT if {**usual, **own}.items() <= opt.items()]
    known = [omega for of in columns for omega in reference("normal_modes")[f"{of} imag"]]

    def found() -> Any:
        if name in ("ring", "shell"):
            return radial_modes(problem, opt, n)[:count]
        omega = 1j * modes_near(problem, opt, -1j * opt["modes_near"], count)
        return omega[np.argsort(np.abs(omega))]

    rows, omegas = [], study.on_first(found)
    for i, omega in enumerate(omegas if comm.rank == 0 else (), 1):
        exact = min(known, key=lambda exact: abs(omega / exact - 1.0), default=np.inf)
        error = float(abs(omega / exact - 1.0))
        beside = (exact, error) if error < 0.03 else ("", "")  # else it is another mode
        rows.append((i, omega.real, omega.imag, *beside))
    of = f", angular number {n}" if name == "ring" else ""
    study.say(f"modes of {case.NAME}{of}, order {order}, h = {opt['fsi_h']:g}: exp(-i omega t)")
    study.table(("index", "omega_re", "omega_im", "exact", "error"), rows, ".12g")


def alone(problem: Any, opt: Mapping[str, Any]) -> Any:
    """The state at first, on this rank alone."""
    from mpi4py import MPI

    from fsipetsc.stepping.run import make_state

    state = make_state(problem, {"fsi_debug": False, **opt}, MPI.COMM_SELF)
    state.set_initial()
    return state


def derivatives(state: Any, directions: Iterable[tuple[Any, Any]]) -> list[Any]:
    """Sparse matrices L and P about the solution of a state, with a column for each direction of
    disturbance: numbers in the vector of unknowns, and their changes. Differences of order 6.
    """
    start, found = state.solution.array.copy(), ([], [])
    y, f = np.empty_like(start), np.empty_like(start)
    for at, change in directions:
        column = np.zeros((2, start.size))
        for (multiple, weight), sign in product(CENTRAL, (1, -1)):
            y[:] = start
            y[at] += sign * multiple * change
            state.right_hand_side(y, f)
            state.project(y)
            column += sign * weight * np.array([f, y])
        for columns, of in zip(found, column):
            columns.append(sparse.csc_matrix(of[:, None]))
    return [sparse.hstack(columns, "csc") for columns in found]


def step_limit(spectrum: Array) -> float:
    """The largest dt [s] for which RK4 amplifies none of these modes; one that grows counts with
    its frequency alone. Along each ray of Re z <= 0, z = dt lambda, |R| <= 1 up to one point.
    """
    radius = float(np.abs(spectrum).max())
    modes = (np.minimum(spectrum.real, 0.0) + 1j * spectrum.imag) / radius

    def excess(x: float) -> float:  # above round-off
        z = x * modes
        return float(np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))).max()) - 1 - 1e-12

    return float(brentq(excess, 0.0, 3.2)) / radius  # at |z| = 3.2 each mode is amplified


def radial_modes(problem: Any, opt: Mapping[str, Any], n: int = 0) -> Array:
    """Angular frequencies omega [1/s] of the modes of angular number n of rings at rest around the
    origin, periodic along axis 1, or of shells in one dimension (n = 0), that swing, as
    exp(-i omega t), and are not rough, the slowest first. InputError: too few columns for n.
    """
    values, blocks = column_modes(problem, opt, 1, n)
    steps = [np.diff(block, axis=0) for block in blocks]
    squares = [sum((np.abs(a) ** 2).sum(axis=(0, 1)) for a in of) for of in (steps, blocks)]
    # waves of 6 nodes have the same squares; central differences give what alternates from node to
    # node the frequency of a long wave
    smooth = squares[0] < squares[1]
    omega = 1j * values[smooth & (values.imag < -1e-6 * np.abs(values).max())]
    return omega[np.argsort(omega.real)]


def column_modes(
    problem: Any, opt: Mapping[str, Any], axis: int, n: int
) -> tuple[Array, list[Array]]:
    """Eigenvalues [1/s] of what is proportional to exp(-i n phi), and of each block the amplitudes
    of its unknowns over their scales, (rows, unknowns, eigenvalues).

    axis: of the blocks, along which all columns are alike: 0 for flat layers, 1 for rings.
    InputError where there are not enough columns for n.
    """
    d, parts, vectors = problem.dimension, [], []
    with alone(problem, opt) as state:
        layout, sizes = state.layout, scales(state)
        columns = layout.shapes[0][axis] if d > 1 else 1
        if 2 * n >= columns:
            known = f"-ring_around {columns} knows angular numbers from 0 to {(columns - 1) // 2}"
            raise InputError(f"-ring_angular {n}: {known}")
        for k, layer in enumerate(problem.layers):
            nodes = layout.owned(k, np.arange(len(sizes)))
            nodes = nodes.reshape(*layout.shapes[k][::-1], layout.dofs[k])
            parts.append(nodes[None] if d == 1 else nodes if axis else nodes.swapaxes(0, 1))
            begins = (1, 0, 1, 0, 0) if layer.kind == "solid" else (0, 0, 1, 0, 0)  # d = 2
            vectors += begins * parts[-1].shape[1]
        # of each column and unknown its number in the solution; all columns have the same sizes
        at = np.concatenate([part.reshape(columns, -1) for part in parts], axis=1)
        sizes = sizes[at[0]]
        found = derivatives(state, zip(at[0], NUDGE * sizes))
    matrices, first = [], np.flatnonzero(vectors)
    phi = 2.0 * np.pi * np.arange(columns)[:, None, None] / columns
    for matrix in found:
        of = matrix.tocsr()[at.ravel()].toarray().reshape(*at.shape, -1)
        if d > 1 and axis == 1:  # vectors along radius and angle
            a, b = of[:, first], of[:, first + 1]
            of[:, first] = np.cos(phi) * a + np.sin(phi) * b
            of[:, first + 1] = np.cos(phi) * b - np.sin(phi) * a
        matrices.append((np.exp(-1j * n * phi) * of).sum(axis=0) / (NUDGE * sizes[:, None]))
    rates, projection = matrices[0], matrices[1].real
    basis = orth(projection, rcond=1e-9)
    values, vectors = np.linalg.eig(basis.T @ (projection @ rates) @ basis)
    shapes = [part.shape[1:] for part in parts]
    amplitudes = np.split(basis @ vectors, np.cumsum([rows * dofs for rows, dofs in shapes])[:-1])
    return values, [of.reshape(*shape, -1) for of, shape in zip(amplitudes, shapes)]


def modes_near(problem: Any, opt: Mapping[str, Any], s: complex, count: int = 1) -> Array:
    """Eigenvalues [1/s] next to s != 0, but those of what is at rest and stays so: the largest of A
    (A - s)^-2, so many, or all but 2. InputError where the state is not steady or none are found.

    Two of A may be one of A (A - s)^-2, which gives mixtures of their vectors: those of A are found
    in the space of all vectors; of one more than is asked for, as the last may be such a mixture.
    """
    with alone(problem, opt) as state:
        n, f = state.layout.local_size - state.layout.auxiliary, np.empty_like(state.solution.array)
        nudges = NUDGE * scales(state)[:n]
        found = derivatives(state, enumerate(nudges))
        state.right_hand_side(state.solution.array.copy(), f)
    rates, projection = (sparse.diags(1.0 / nudges) @ of[:n] for of in found)
    if np.abs(NUDGE * f[:n] / nudges).max() > AT_REST * abs(rates).max():
        raise InputError("the blocks are not in a steady state at first")
    A = (projection @ rates).astype(complex).tocsc()
    try:
        solve = splu(A - s * sparse.eye(n, format="csc")).solve
        inverse = LinearOperator((n, n), lambda v: solve(A @ solve(v)), dtype=complex)
        vectors = eigs(inverse, min(count + 1, n - 2), v0=np.ones(n, complex))[1]
    except (RuntimeError, TypeError) as error:  # singular, without convergence, of 2 unknowns
        known = f"-modes_near {abs(s):g}, -modes_count {count}: no modes found ({error})"
        raise InputError(f"{known}; another frequency may help") from error
    basis = orth(vectors)
    values = np.linalg.eigvals(basis.conj().T @ (A @ basis))
    moving = values[np.abs(values) > AT_REST * np.abs(values).max()]
    return moving[np.argsort(-np.abs(moving / (moving - s) ** 2))][:count]


def scales(state: Any) -> Array:
    """Sizes of all unknowns of blocks at rest, those of a gas, and with its speed of sound; but all
    velocities have the size of the slowest speed, as they are the same on both sides of interfaces.
    """
    d, start = state.problem.dimension, state.solution.array
    sizes, velocities, slowest = np.ones_like(start), [], np.inf
    for k, block in enumerate(state.problem.layers):
        q, own = state.layout.owned(k, start), state.layout.owned(k, sizes)
        if block.kind == "fluid":
            rho, _, T, *_ = block.material.equations(d).primitive(tuple(q.T))
            c = np.sqrt(block.material.gas_law.sound_speed_squared(rho, T))
            own[:, 0], own[:, 1], own[:, -1] = q[:, 0], q[:, 1], q[:, 1] * c**2
            velocities.append((own[:, 2:-1], q[:, 1:2]))
        else:
            c = np.sqrt(block.material.K / block.material.m0)
            own[:, :d], own[:, -1] = state.h, np.abs(q[:, -1]) + c**2
            velocities.append((own[:, d:-1], 1.0))
        slowest = min(slowest, np.min(c))
    for velocity, mass in velocities:
        velocity[:] = slowest * mass
    return sizes
