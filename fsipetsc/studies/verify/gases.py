"""Entries of `verify` about a gas alone."""

from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem, Dirichlet, Fluid, FluidLayer, Problem, Wall
from fsipetsc.blocks.conditions import Given
from fsipetsc.blocks.maps import rectangle
from fsipetsc.checks import Array
from fsipetsc.studies.trials import Compared, Trial, entry, joined, reference, round_off, smooth

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


@entry({4: (4, 8)}, {**dict.fromkeys((2, 4, 6), (4, 8, 16)), 8: (8, 16, 32)})
def vortex(trial: Trial) -> None:
    """An isentropic vortex on blocks that move. With 2/1 dissipation takes first differences."""
    table, order = reference("gas"), trial.closures if trial.order > 2 else 1.0
    some = np.isfinite(table["r"])
    r, *fields = (table[name][some] for name in ("r", "vortex rho", "vortex u", "vortex p"))
    of_r = {name: smooth(r, values) for name, values in zip(("rho", "u", "p"), fields)}
    layers = trial.solve(vortex_blocks(round(8.0 / trial.h)), 1.0).layers
    frame = joined(layer.frame(-1) for layer in layers)
    z = frame["x"] + 1j * frame["y"] - complex(*CENTRE) - complex(*SPEED)
    r, velocity = abs(z), frame["u"] + 1j * frame["v"] - complex(*SPEED)
    exact = 1j * z / np.maximum(r, 1e-300) * of_r["u"](r)
    errors = {"rho": frame["rho"] - of_r["rho"](r), "velocity": velocity - exact}
    for name, error in {**errors, "p": frame["p"] - of_r["p"](r)}.items():
        trial.check(name, error, order, power=2)


@entry({4: (200, 400)}, dict.fromkeys((2, 4, 6), (100, 200, 400)))
def shock_tubes(trial: Trial) -> None:
    """Sod's shock tube, of whose density the contact is worst; Shu and Osher's problem."""
    table, h, state = reference("gas"), trial.h, (3.857143, 2.629369, 10.33333 / 3.857143)

    def tube(h: float, end: float, start: Any, left: Any) -> Any:
        """The last frame of a gas between a left end and a wall as far from the middle."""
        layer = FluidLayer("gas", Fluid(0.0, 0.0, 1.4, 1.0), (left.x, -left.x), start)
        problem = Problem((layer,), left, Wall(-left.x), units="none")
        shocks = {"fsi_h": h, "fsi_shock": 1.4, "fsi_dissipation": 2.0}
        return trial.solve(problem, end, **shocks).layers[0].frame(-1)

    def sod(x: Array) -> list[Array]:
        right = 0.5 * (1.0 + np.sign(np.round(x, 9)))
        rho, p = 1.0 - 0.875 * right, 1.0 - 0.9 * right
        return [rho, 0.0 * x, p / rho]

    def wavy(x: Array) -> list[Array]:
        still = 1.0 + 0.2 * np.sin(5.0 * x)
        ahead = still, 0.0 * x, 1.0 / still
        return [np.where(x < -4.0, value, v) for value, v in zip(state, ahead)]

    ours = tube(h, 0.2, sod, Wall(-0.5))
    for name in ("rho", "u", "p"):
        exact = np.interp(ours["x"], table["X"], table[f"sod {name}"])  # at points of the table
        order = trial.kinked() if name == "rho" else 1.0
        trial.check(f"Sod, {name}", ours[name] - exact, order, power=1)
    ours = tube(5.0 * h, 1.8, wavy, Dirichlet(-5.0, lambda t: state))
    known = np.isfinite(table["x"])
    x, exact = table["x"][known], table["shu_osher rho"][known]
    apart = np.interp(x, ours["x"], ours["rho"]) - exact
    trial.check("Shu-Osher, rho", apart, order=1.0, power=1)


#: of Taylor and Green's vortex: period [m], options of runs
PERIOD = 2.0 * np.pi
CONSERVING = {"fsi_convection": "entropy", "fsi_dissipation": -1.0}


def cube(h: float, warm: float, mu: float = 0.0) -> Any:
    """Taylor and Green's vortex; warm: R T at first; mu: viscosity."""

    def start(x: Array, y: Array, z: Array) -> list[Array]:
        p = (np.cos(2 * x) + np.cos(2 * y)) * (np.cos(2 * z) + 2.0) / 16.0
        u, v = np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z)
        return [1.0 + p / warm, u, v, 0.0 * x, warm + 0.0 * x]

    space, gas = rectangle((0.0, 0.0, 0.0), (PERIOD,) * 3), Fluid(mu, 3.5 * mu / 0.71, 1.4, 1.0)
    cells = (round(PERIOD / h),) * 3
    return BlockProblem((Block("gas", gas, space, cells, start, periodic=(True,) * 3),), {})


@entry({6: (16, 32)}, {2: (16, 32), 6: (16, 32), 4: (16, 32, 48)}, length=PERIOD)
def taylor_green(trial: Trial) -> None:
    """Without viscosity: orders inside, down to compressibility; round-off of what is kept."""
    rounded, table = round_off(2000), reference("taylor_green")
    series = trial.solve(cube(trial.h, 100 / 1.4), 5.0, **CONSERVING).series
    mass = series["mass"].ravel()[0]
    # density 1, temperature 100/1.4, cv 2.5, in the volume 8 pi^3, over pi^3
    heat = rounded * (8 * 2.5 * 100 / 1.4)
    for name, size, *expected in (
        ("mass", mass, None, rounded),
        ("energy", np.pi**3, None, heat),
        ("entropy", mass, 4.0, rounded),
    ):
        values = series[name].ravel()
        trial.check(f"{name} kept", (values - values[0]) / size, *expected)
    run = trial.solve(cube(trial.h, 2500 / 1.4), 1.0, **CONSERVING)
    frame, n = run.layers[0].frame(-1), round(PERIOD / trial.h)
    for name in "uvw":
        ours = frame[name][n // 16, n // 8, :: n // 16]
        trial.check(name, ours - table[name], trial.order, 0.02**2)


@entry({4: (16, 32)}, dict.fromkeys((2, 4, 6), (16, 32, 64)))
def oblique(trial: Trial) -> None:
    """Regular reflection of an oblique shock from a rigid wall."""
    table = reference("oblique")
    frame = trial.solve("oblique", 4.0, oblique_wall="rigid").layers[0].frame(-1)
    x, y, p = frame["x"], frame["y"], frame["p"]
    falls, rises = np.tan(table["angle"][1:])
    behind = y < (x - 1.0 / falls) * rises
    exact = np.where(behind, table["p"][2], np.where(y > 1.0 - x * falls, *table["p"][1::-1]))
    plateau = p[(np.abs(y) < 1e-9) & (x > 2.4) & (x < 2.8)].mean()
    trial.check("p, mean of errors", (p - exact) / table["p"][0], order=1.0, power=1)
    trial.check("p on the wall", Compared(plateau, table["p"][2]), order=1.0)


#: energy that is lost -> steps of 0.5 in time
SPANS = {"energy lost, 0 < t < 5": slice(10), "energy lost, 4.5 < t < 5.5": slice(9, 11)}


@entry({}, {4: (16, 32)}, length=PERIOD)
def taylor_green_1600(trial: Trial) -> None:
    """At Re = 1600, on its way to turbulence."""
    table, problem = reference("taylor_green_1600"), cube(trial.h, 100 / 1.4, 1 / 1600)
    run = trial.solve(problem, 5.5, **CONSERVING, fsi_output_dt=0.5)
    frames = map(run.layers[0].frame, range(run.nframes))
    E = [0.5 * (f["rho"] * sum(f[v] ** 2 for v in "uvw")).mean() for f in frames]
    ours, exact = -np.diff(E), -np.diff(table["E"])
    for name, at in SPANS.items():
        trial.check(name, Compared(ours[at].sum(), exact[at].sum()), trial.order)


@entry({}, {4: (100, 200, 400), 6: (100, 200)})
def viscous_tube(trial: Trial) -> None:
    """A shock comes back through the boundary layer that it has left. The error that is allowed is
    that of the reference on its coarser grid.
    """
    run = trial.solve("viscous_tube", 1.0, fsi_shock=0.0, fsi_dissipation=1.0)
    last, table = run.layers[0].frame(-1), reference("viscous_tube")
    apart = np.interp(table["x"], last["x"][0], last["rho"][0]) - table["rho"]
    trial.check("density at the wall", apart / table["rho"].mean(), error=0.08, power=1)
