"""Entries of `verify` about a gas alone."""

from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem, Dirichlet, Fluid, FluidLayer, Problem, Wall
from fsipetsc.blocks.conditions import Given
from fsipetsc.blocks.maps import rectangle
from fsipetsc.checks import Array
from fsipetsc.studies.verdicts import Compared, Curve, Expected, closures, kinked, round_off
from fsipetsc.studies.verify.entry import (
    Measured,
    Solve,
    entry,
    joined,
    largest,
    reference,
    root_mean_square,
    smooth,
)

#: of the vortex: where it is at first [m], velocity of the gas around it [m/s]
CENTRE, SPEED = (-0.3, -0.2), (0.5, 0.3)


def vortex_at(X: Array, Y: Array, t: float = 0.0) -> list[Array]:
    """Return rho, u, v, T by the formulas of the text."""
    x, y = X - CENTRE[0] - SPEED[0] * t, Y - CENTRE[1] - SPEED[1] * t
    bell = np.exp(1.0 - x * x - y * y)
    swirl, q = 0.4 * np.sqrt(bell), 1.0 - 0.16 / 7.0 * bell
    return [q**2.5, SPEED[0] - swirl * y, SPEED[1] + swirl * x, q]


def moved(X: Array, Y: Array, t: float) -> list[Array]:
    """Return places of the sides."""
    size = 0.3 * np.sin(2.0 * t)
    return [X + size * np.sin(np.pi * Y / 4 + 0.4), Y + size * np.sin(np.pi * X / 4)]


def vortex_blocks(n: int) -> Any:
    """Return four curved blocks, n cells along each side of the whole."""
    gas, found, faces = Fluid(0.0, 0.0, 1.4, 1.0), [], {}
    side = Given(values=lambda X, Y, t: vortex_at(*moved(X, Y, t), t), x=moved)
    for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)):

        def place(xi: Any, i: int = i, j: int = j) -> list[Array]:
            a, b = 4.0 * (xi[0] + i - 1.0), 4.0 * (xi[1] + j - 1.0)
            p, q = np.pi * a / 2.0, np.pi * b / 2.0
            bumps = np.sin(p) * np.sin(q + 0.5), np.sin(p + 0.3) * np.sin(q)
            return [a + 0.15 * bumps[0], b + 0.15 * bumps[1]]

        found.append(Block(f"{i}{j}", gas, place, (n // 2, n // 2), vortex_at))
        faces |= {(f"{i}{j}", 0, i): side, (f"{i}{j}", 1, j): side}
    return BlockProblem(tuple(found), faces, units="none")


@entry(
    source="verify/gas.py (momentum along the radius)",
    why="order s + 1; with 2/1 that of the dissipation, which takes first differences",
    full={**{k: (1 / 4, 1 / 8, 1 / 16) for k in (2, 4, 6)}, 8: (1 / 8, 1 / 16, 1 / 32)},
    quick={4: (1 / 4, 1 / 8)},
)
def vortex(solve: Solve, order: int, h: float) -> Measured:
    """An isentropic vortex on blocks that move."""
    table = reference("gas")
    short = np.isfinite(table["r"])
    columns = {name: table[f"vortex {name}"][short] for name in ("rho", "u", "p")}
    of_r = {name: smooth(table["r"][short], column) for name, column in columns.items()}
    layers = solve(vortex_blocks(round(8.0 / h)), order, h, 1.0).layers
    frame = joined(layer.frame(-1) for layer in layers)
    z = frame["x"] + 1j * frame["y"] - complex(*CENTRE) - complex(*SPEED)
    r, ours = abs(z), frame["u"] + 1j * frame["v"] - complex(*SPEED)
    apart = {
        "rho": frame["rho"] - of_r["rho"](r),
        "velocity": ours - 1j * z / np.maximum(r, 1e-300) * of_r["u"](r),
        "p": frame["p"] - of_r["p"](r),
    }
    errors = {name: root_mean_square(v) for name, v in apart.items()}
    curve = Curve(("r", "p"), r, frame["p"], table["r"], table["vortex p"])
    return Measured(errors, Expected(closures(order) if order > 2 else 1.0), curve)


def run_tube(solve: Solve, end: float, start: Any, left: Any, order: int, h: float) -> Any:
    """The last frame of a gas between a left end and a wall as far from the middle."""
    layer = FluidLayer("gas", Fluid(0.0, 0.0, 1.4, 1.0), (left.x, -left.x), start)
    problem = Problem((layer,), left, Wall(-left.x), units="none")
    return solve(problem, order, h, end, fsi_shock=1.4, fsi_dissipation=2.0).layers[0].frame(-1)


@entry(
    source="verify/gas.py (Riemann's problem; fitted shock, Chebyshev collocation)",
    why="shocks, and what they leave behind, have the order 1 in the mean, contacts p/(p + 1)",
    full={order: (1 / 100, 1 / 200, 1 / 400) for order in (2, 4, 6)},
    quick={4: (1 / 200, 1 / 400)},
)
def shock_tubes(solve: Solve, order: int, h: float) -> Measured:
    """Sod's shock tube, of whose density the contact is worst; Shu and Osher's problem."""
    table = reference("gas")

    def sod(x: Array) -> list[Array]:
        right = 0.5 * (1.0 + np.sign(np.round(x, 9)))
        rho, p = 1.0 - 0.875 * right, 1.0 - 0.9 * right
        return [rho, 0.0 * x, p / rho]

    ours, errors = run_tube(solve, 0.2, sod, Wall(-0.5), order, h), {}
    for name in ("rho", "u", "p"):
        exact = np.interp(ours["x"], table["X"], table[f"sod {name}"])  # at points of the table
        errors[f"Sod, {name}"] = np.abs(ours[name] - exact).mean()
    state = 3.857143, 2.629369, 10.33333 / 3.857143

    def wavy(x: Array) -> list[Array]:
        still = 1.0 + 0.2 * np.sin(5.0 * x)
        ahead = still, 0.0 * x, 1.0 / still
        return [np.where(x < -4.0, value, v) for value, v in zip(state, ahead)]

    ours = run_tube(solve, 1.8, wavy, Dirichlet(-5.0, lambda t: state), order, 5.0 * h)
    known = np.isfinite(table["x"])
    x, exact = table["x"][known], table["shu_osher rho"][known]
    errors["Shu-Osher, rho"] = np.abs(np.interp(x, ours["x"], ours["rho"]) - exact).mean()
    expected = dict.fromkeys(errors, Expected(1.0)) | {"Sod, rho": Expected(kinked(order))}
    curve = Curve(("x", "density, Shu-Osher"), ours["x"], ours["rho"], x, exact)
    return Measured(errors, expected, curve)


#: of Taylor and Green's vortex: period [m], options of runs
PERIOD = 2.0 * np.pi
CONSERVING = {"fsi_convection": "entropy", "fsi_dissipation": -1.0}


def cube(n: int, warm: float, mu: float = 0.0) -> Any:
    """Taylor and Green's vortex, n nodes along each axis; warm: R T at first; mu: viscosity."""

    def start(x: Array, y: Array, z: Array) -> list[Array]:
        p = (np.cos(2 * x) + np.cos(2 * y)) * (np.cos(2 * z) + 2.0) / 16.0
        u, v = np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z)
        return [1.0 + p / warm, u, v, 0.0 * x, warm + 0.0 * x]

    space, gas = rectangle((0.0, 0.0, 0.0), (PERIOD,) * 3), Fluid(mu, 3.5 * mu / 0.71, 1.4, 1.0)
    return BlockProblem((Block("gas", gas, space, (n,) * 3, start, periodic=(True,) * 3),), {})


@entry(
    source="verify/taylor_green.py (Fourier series, constant density); conservation laws",
    why="order p, of RK4 4; errors: the Mach number squared; of what is kept round-off of 2000"
    " steps, of all energy over the kinetic one",
    full={
        **dict.fromkeys((2, 6), (PERIOD / 16, PERIOD / 32)),
        4: (PERIOD / 16, PERIOD / 32, PERIOD / 48),
    },
    quick={6: (PERIOD / 16, PERIOD / 32)},
)
def taylor_green(solve: Solve, order: int, h: float) -> Measured:
    """Without viscosity: orders inside, down to compressibility; round-off of what is kept."""
    n, rounded = round(PERIOD / h), round_off(2000)
    run = solve(cube(n, 100 / 1.4), order, h, 5.0, **CONSERVING)
    series = {k: run.series[k].ravel() for k in ("mass", "energy", "entropy")}
    sizes = {"mass": series["mass"][0], "energy": np.pi**3, "entropy": series["mass"][0]}
    errors = {f"{k} kept": largest(v - v[0]) / sizes[k] for k, v in series.items()}
    # density 1, temperature 100/1.4, cv 2.5, in the volume 8 pi^3, over pi^3
    of_all = {"mass": Expected(error=rounded), "entropy": Expected(4.0, rounded)}
    of_all["energy"] = Expected(error=rounded * (8 * 2.5 * 100 / 1.4))
    table = reference("taylor_green")
    frame = solve(cube(n, 2500 / 1.4), order, h, 1.0, **CONSERVING).layers[0].frame(-1)
    ours = {name: frame[name][n // 16, n // 8, :: n // 16] for name in "xuvw"}
    errors |= {name: largest(ours[name] - table[name]) for name in "uvw"}
    expected = dict.fromkeys("uvw", Expected(order, 0.02**2))
    expected |= {f"{k} kept": known for k, known in of_all.items()}
    labels = "x", "w at y = π/4, z = π/8, t = 1"
    return Measured(errors, expected, Curve(labels, ours["x"], ours["w"], table["x"], table["w"]))


@entry(
    source="verify/oblique.py (conservation laws across both shocks)",
    why="behind captured shocks errors have the order 1",
    full={k: (1 / 16, 1 / 32, 1 / 64) for k in (2, 4, 6)},
    quick={4: (1 / 16, 1 / 32)},
)
def oblique(solve: Solve, order: int, h: float) -> Measured:
    """Regular reflection of an oblique shock from a rigid wall."""
    table = reference("oblique")
    frame = solve("oblique", order, h, 4.0, oblique_wall="rigid").layers[0].frame(-1)
    x, y, p = frame["x"], frame["y"], frame["p"]
    falls, rises = np.tan(table["angle"][1:])
    behind = y < (x - 1.0 / falls) * rises
    exact = np.where(behind, table["p"][2], np.where(y > 1.0 - x * falls, *table["p"][1::-1]))
    wall = np.abs(y) < 1e-9
    plateau = wall & (x > 2.4) & (x < 2.8)
    errors = {
        "p, mean of errors": np.abs(p - exact).mean() / table["p"][0],
        "p on the wall": Compared(p[plateau].mean(), table["p"][2]),
    }
    curve = Curve(("x", "p on the wall"), x[wall], p[wall], x[wall], exact[wall])
    return Measured(errors, Expected(1.0), curve)


#: energy that is lost -> steps of 0.5 in time
SPANS = {"energy lost, 0 < t < 5": slice(10), "energy lost, 4.5 < t < 5.5": slice(9, 11)}


@entry(
    source="spectral_Re1600_512.gdiag (workshop on high-order CFD methods, case C3.5)",
    why="order p; these grids are far from what turbulence needs",
    full={4: (PERIOD / 16, PERIOD / 32)},
    quick={},
)
def taylor_green_1600(solve: Solve, order: int, h: float) -> Measured:
    """At Re = 1600, on its way to turbulence."""
    table, problem = reference("taylor_green_1600"), cube(round(PERIOD / h), 100 / 1.4, 1 / 1600)
    run = solve(problem, order, h, 5.5, **CONSERVING, fsi_output_dt=0.5)
    frames = map(run.layers[0].frame, range(run.nframes))
    E = [0.5 * (f["rho"] * sum(f[v] ** 2 for v in "uvw")).mean() for f in frames]
    ours, exact = -np.diff(E), -np.diff(table["E"])
    errors = {name: Compared(ours[at].sum(), exact[at].sum()) for name, at in SPANS.items()}
    t = table["t"][1:] - 0.25
    curve = Curve(("t", "dissipation"), t, 2.0 * ours, t, 2.0 * exact)
    return Measured(errors, Expected(order), curve)


def front(x: Array, p: Array, level: float) -> float:
    """Return where p first reaches a level, from the left."""
    k = int(np.argmax(p > level))
    return float(x[k - 1] + (level - p[k - 1]) / (p[k] - p[k - 1]) * (x[k] - x[k - 1]))


def triple_point(x: Array, y: Array, p: Array) -> tuple[float, float]:
    """Where the two lines through the front meet; x of columns, y of rows, p of both.

    The front is where a tenth of the jump is reached: behind the foot of the λ there is a fifth.
    """
    right = x > 0.2
    high = p[int(np.argmin(abs(y - 0.4)))][right]
    level = high[0] + 0.1 * (high.max() - high[0])
    places = np.array([front(x[right], row[right], level) for row in p])
    above, foot = (y > 0.2) & (y < 0.4), (y > 0.04) & (y < 0.1)
    (a, b), (c, d) = (np.polyfit(y[rows], places[rows], 1) for rows in (above, foot))
    height = (d - b) / (a - c)
    return float(a * height + b), float(height)


def top(f: Array) -> float:
    """Return where the parabola through values at -1, 0, 1 is highest."""
    return float(0.5 * (f[0] - f[2]) / (f[0] - 2.0 * f[1] + f[2]))


def main_vortex(x: Array, y: Array, flow: Array) -> tuple[float, float]:
    """Its centre, where most mass flows back below it; flow: rho u, rows along x."""
    back = np.zeros_like(flow)
    back[1:] = -np.cumsum(0.5 * np.diff(y)[:, None] * (flow[1:] + flow[:-1]), axis=0)
    back[:, (x < 0.6) | (x > 0.9)] = 0.0
    back[y > 0.2] = 0.0
    j, i = np.unravel_index(back.argmax(), back.shape)
    h, along, up = x[1] - x[0], back[j, i - 1 : i + 2], back[j - 1 : j + 2, i]
    return float(x[i] + h * top(along)), float(y[j] + h * top(up))


@entry(
    source="verify/viscous_tube.py (finite volumes); triple point: Daru and Tenaud 2001, quoted",
    why="the triple point is quoted to about 0.01; vortex and density: the difference of the"
    " reference from its own coarser grid",
    full={4: (1 / 100, 1 / 200, 1 / 400), 6: (1 / 100, 1 / 200)},
    quick={},
)
def viscous_tube(solve: Solve, order: int, h: float) -> Measured:
    """A shock comes back through the boundary layer that it has left."""
    run = solve("viscous_tube", order, h, 1.0, fsi_shock=0.0, fsi_dissipation=1.0)
    last = run.layers[0].frame(-1)
    rho, p, x, y = last["rho"], last["p"], last["x"][0], last["y"][:, 0]
    table, errors = reference("viscous_tube"), {}
    places = {
        "triple point": triple_point(x, y, p),
        "main vortex": main_vortex(x, y, rho * last["u"]),
    }
    for name, place in places.items():
        for axis, value in zip("xy", place):
            exact = table[f"{name} {axis}"][0]
            errors[f"{axis} of the {name}"] = Compared(value, exact, size=1.0)
    apart = np.interp(table["x"], x, rho[0]) - table["rho"]
    errors["density at the wall"] = np.abs(apart).mean() / table["rho"].mean()
    # vortex and density of the reference on its coarser grid, over those on the finer one
    allowed = dict.fromkeys(errors, 0.01) | {"density at the wall": 0.08}
    allowed |= {"x of the main vortex": 0.0176, "y of the main vortex": 0.0224}
    expected = {name: Expected(error=error) for name, error in allowed.items()}
    curve = Curve(("x", "density at the wall"), x, rho[0], table["x"], table["rho"])
    return Measured(errors, expected, curve)
