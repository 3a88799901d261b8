"""Entries of `verify`, functions of a Trial: runs; small motions by the linearised scheme."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from math import tau
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.optimize import brentq

from fsipetsc import Block, BlockProblem, Dirichlet, Fluid, FluidLayer, Layer, Problem, Wall, layers
from fsipetsc.blocks.conditions import Clamped, Free, Given, Hinge, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.cases import load_case
from fsipetsc.cases.common import at_rest, constant
from fsipetsc.checks import Array
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.options import defaults
from fsipetsc.studies.modes import column_modes, modes_near
from fsipetsc.studies.trials import Trial, reference

#: name of an entry -> its function; order of the operators -> cells in a unit of length; whether it
#: is on the level quick, too: with the first two grids of the first order
ENTRIES: dict[str, tuple[Any, dict[int, tuple[float, ...]], bool]] = {}
#: a reference between its points
smooth = partial(make_interp_spline, k=5)


def entry(grids: dict[int, tuple[float, ...]], quick: bool = True) -> Callable[[Any], Any]:
    """Make a function of a Trial an entry of its name."""

    def noted(measure: Any) -> Any:
        ENTRIES[measure.__name__] = measure, grids, quick
        return measure

    return noted


def joined(layers: Sequence[Any], frame: int) -> dict[str, Array]:
    """Return the fields of several blocks as one array each."""
    parts = [layer.frame(frame) for layer in layers]
    return {name: np.concatenate([part[name].ravel() for part in parts]) for name in parts[0]}


@entry({**dict.fromkeys((4, 2, 6), (4, 8, 16)), 8: (8, 16, 32)})
def vortex(trial: Trial) -> None:
    """An isentropic vortex on four blocks that move. With 2/1 dissipation is of first order."""
    gas, blocks, faces, n = Fluid(0.0, 0.0, 1.4, 1.0), [], {}, round(4.0 / trial.h)
    centre, speed = (-0.3, -0.2), (0.5, 0.3)  # of the vortex, at first; of the gas around it

    def flow(X: Array, Y: Array, t: float = 0.0) -> list[Array]:
        x, y = X - centre[0] - speed[0] * t, Y - centre[1] - speed[1] * t
        bell = np.exp(1.0 - x * x - y * y)
        swirl, q = 0.4 * np.sqrt(bell), 1.0 - 0.16 / 7.0 * bell
        return [q**2.5, speed[0] - swirl * y, speed[1] + swirl * x, q]

    def moved(X: Array, Y: Array, t: float) -> list[Array]:
        size = 0.3 * np.sin(2.0 * t)
        return [X + size * np.sin(np.pi * Y / 4 + 0.4), Y + size * np.sin(np.pi * X / 4)]

    def place(i: int, j: int, xi: Any) -> list[Array]:
        a, b = 4.0 * (xi[0] + i - 1.0), 4.0 * (xi[1] + j - 1.0)
        p, q = np.pi * a / 2.0, np.pi * b / 2.0
        bumps = np.sin(p) * np.sin(q + 0.5), np.sin(p + 0.3) * np.sin(q)
        return [a + 0.15 * bumps[0], b + 0.15 * bumps[1]]

    side = Given(values=lambda X, Y, t: flow(*moved(X, Y, t), t), x=moved)
    for j, i in product((0, 1), (0, 1)):
        blocks.append(Block(f"{i}{j}", gas, partial(place, i, j), (n, n), flow))
        faces |= {(f"{i}{j}", 0, i): side, (f"{i}{j}", 1, j): side}
    layers = trial.solve(BlockProblem(tuple(blocks), faces, units="none"), 1.0).layers
    table, order = reference("gas"), trial.closures if trial.order > 2 else 1.0
    some, frame = np.isfinite(table["r"]), joined(layers, -1)
    z = frame["x"] + 1j * frame["y"] - complex(*centre) - complex(*speed)
    velocity = frame["u"] + 1j * frame["v"] - complex(*speed)
    of_r = (smooth(table["r"][some], table[f"vortex {name}"][some]) for name in ("rho", "u", "p"))
    rho, u, p = (field(abs(z)) for field in of_r)
    turning = 1j * z / np.maximum(abs(z), 1e-300) * u
    trial.check("rho", frame["rho"] - rho, order, power=2)
    trial.check("velocity", velocity - turning, order, power=2)
    trial.check("p", frame["p"] - p, order, power=2)


@entry(dict.fromkeys((4, 2, 6), (200, 400)))
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
        return [np.where(x < -4.0, a, b) for a, b in zip(state, (still, 0.0 * x, 1.0 / still))]

    ours = tube(h, 0.2, sod, Wall(-0.5))
    for name in ("rho", "u", "p"):
        exact = np.interp(ours["x"], table["X"], table[f"sod {name}"])  # at points of the table
        order = trial.kinked() if name == "rho" else 1.0
        trial.check(f"Sod, {name}", ours[name] - exact, order, power=1)
    ours = tube(5.0 * h, 1.8, wavy, Dirichlet(-5.0, lambda t: state))
    known = np.isfinite(table["x"])
    x, exact = table["x"][known], table["shu_osher rho"][known]
    trial.check("Shu-Osher, rho", np.interp(x, ours["x"], ours["rho"]) - exact, 1.0, power=1)


@entry({**dict.fromkeys((6, 2), (16 / tau, 32 / tau)), 4: (16 / tau, 32 / tau, 48 / tau)})
def taylor_green(trial: Trial) -> None:
    """Taylor and Green's vortex without viscosity: the gas is nearly incompressible."""
    period, warm, table = 2.0 * np.pi, 2500 / 1.4, reference("taylor_green")

    def start(x: Array, y: Array, z: Array) -> list[Array]:
        p = (np.cos(2 * x) + np.cos(2 * y)) * (np.cos(2 * z) + 2.0) / 16.0
        u, v = np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z)
        return [1.0 + p / warm, u, v, 0.0 * x, warm + 0.0 * x]

    space, n = rectangle((0.0, 0.0, 0.0), (period,) * 3), round(period / trial.h)
    gas = Fluid(0.0, 0.0, 1.4, 1.0)
    box = BlockProblem((Block("gas", gas, space, (n,) * 3, start, periodic=(True,) * 3),), {})
    last = trial.solve(box, 1.0, fsi_convection="entropy", fsi_dissipation=-1.0).layers[0].frame(-1)
    for name in "uvw":
        ours = last[name][n // 16, n // 8, :: n // 16]
        trial.check(name, ours - table[name], trial.order, 0.02**2)


@entry(dict.fromkeys((4, 2, 6), (16, 32, 64)))
def oblique(trial: Trial) -> None:
    """Regular reflection of an oblique shock from a rigid wall."""
    table = reference("oblique")
    frame = trial.solve("oblique", 4.0, oblique_wall="rigid").layers[0].frame(-1)
    x, y, p = frame["x"], frame["y"], frame["p"]
    falls, rises = np.tan(table["angle"][1:])
    behind = y < (x - 1.0 / falls) * rises
    exact = np.where(behind, table["p"][2], np.where(y > 1.0 - x * falls, *table["p"][1::-1]))
    plateau = p[(np.abs(y) < 1e-9) & (x > 2.4) & (x < 2.8)].mean()
    trial.check("p, mean of errors", (p - exact) / table["p"][0], rate=1.0, power=1)
    trial.compare("p on the wall", plateau, table["p"][2], rate=1.0)


@entry({4: (100, 200, 400), 6: (100, 200)}, quick=False)
def viscous_tube(trial: Trial) -> None:
    """A shock comes back through its boundary layer; the reference's coarser grid errs as much."""
    run = trial.solve("viscous_tube", 1.0, fsi_shock=0.0, fsi_dissipation=1.0)
    last, table = run.layers[0].frame(-1), reference("viscous_tube")
    apart = np.interp(table["x"], last["x"][0], last["rho"][0]) - table["rho"]
    trial.check("density at the wall", apart / table["rho"].mean(), most=0.08, power=1)


@entry(dict.fromkeys((4, 2, 6, 8), (40, 80, 160, 320)))
def elastic_piston(trial: Trial) -> None:
    """A rod that recedes from a gas, and advances into it. Of the receding one the largest errors
    of cgmp, the paper's second-order scheme, at h = 1/40 and 1/320, are quoted.
    """
    table, place, order = reference("elastic_piston"), 0.7**4 / 4, trial.kinked(3.5)
    quoted = {"rho": (3.16e-5, 5.98e-7), "u": (3.17e-4, 5.98e-6)}
    quoted |= {"T": (9.04e-5, 1.71e-6), "stress": (3.00e-5, 3.90e-7)}
    for way, sign in (("receding", -1.0), ("advancing", 1.0)):
        run = trial.solve("elastic_piston", piston_way=way, fsi_cfl=0.4)
        rod, gas = (layer.frame(-1) for layer in run.layers)
        X, stress = run.layers[0].X, rod["sigma"] + 0.1 / 1.4
        s = (gas["x"] - sign * place) / (1.5 - sign * place)
        for name, published in quoted.items():
            x, at, ours = ("X", X, stress) if name == "stress" else ("s", s, gas[name])
            apart = ours - smooth(table[x], table[f"{way}_{name}"])(at)
            expected = {"rate": order, "power": 2}
            if way == "receding" and trial.order > 2:
                expected = {"most": published[trial.h < 1 / 100]}
            trial.check(f"{way}, {name}", apart, **expected)


@entry(dict.fromkeys((4, 2, 6), (100, 200, 400)))
def riemann_problems(trial: Trial) -> None:
    """The mean velocity of the interface."""
    lines = zip((0.3, 0.1, 0.15, 0.03), *reference("riemann_problems").values(), strict=True)
    for end, strong, number, K, _, u, _ in lines:
        name, problem = ("Mach", "strong") if strong else ("ratio", "sod")
        given = {f"shock_{name.lower()}": number, "shock_problem": problem}
        run = trial.solve("shock", ts_max_time=end, solid_modulus=K, **given)
        speed = (run.series["x_interface"][-1, 0] - 1.0) / run.series["t"][-1]
        trial.compare(f"{name} {number:g}, u", speed, u, rate=1.0)


@entry({4: (20, 40, 80), **dict.fromkeys((2, 6, 8), (20, 40))})
def superseismic(trial: Trial) -> None:
    """The gas has shocks, the solid jumps that do not steepen."""
    errors = trial.solve("superseismic").errors
    trial.check("gas", errors["fluid"]["combined"], rate=1.0)
    trial.check("solid", errors["solid"]["combined"], rate=trial.kinked())


@entry({4: (200, 400)}, quick=False)
def shock_on_panel(trial: Trial) -> None:
    """A shock hits a clamped steel panel after 0.06 ms: an experiment."""
    table, series = reference("shock_on_panel"), trial.solve("fin", ts_max_time=1.5e-3).series
    x, late = series["x_point"][:, 0], 1e3 * (series["t"] - 0.06e-3)
    moved, time = 1e3 * (x - x[0]), table["ms"][2]
    tip, unsure = table["mm"][0], table["uncertainty"][0]
    trial.compare("displacement of the tip, mm", moved.max(), tip, most=unsure / tip)
    trial.compare("time of it, ms", late[moved.argmax()], time, most=0.038)


@entry({4: (10, 20, 40), 6: (20, 40)})
def spinning_disk(trial: Trial) -> None:
    """A St. Venant-Kirchhoff disk in gas. The order in the maximum is the closures' degree."""
    table, order = reference("spinning_disk"), trial.order // 2
    for density in (0.5, 2.0, 20.0):
        given = {"disk_spin": 2.0, "disk_power": 4, "solid_density": density}
        solids = [of for of in trial.solve("disk", 0.5, **given).layers if of.kind == "solid"]
        first, last = joined(solids, 0), joined(solids, -1)
        X = first["x"] + 1j * first["y"]
        z, v = last["x"] + 1j * last["y"], last["u"] + 1j * last["v"]
        for what, ours, names in (("place", z, "real imag"), ("velocity", v, "v_real v_imag")):
            parts = (table[f"{name} {density:g}"] for name in names.split())
            real, imag = (smooth(table["R"], part)(abs(X)) for part in parts)
            trial.check(f"{what}, density {density:g}", ours - X * (real + 1j * imag), order)


@entry(dict.fromkeys((4, 2, 6), (16, 32, 64)))
def large_deformation(trial: Trial) -> None:
    """A solid alone: simple shear, extension, a turn around the middle."""
    h, table, stresses = trial.h, reference("large_deformation"), ("s_xx", "s_xy", "s_yy")

    def curved(xi: tuple[Array, ...]) -> tuple[Array, Array]:
        bump = 0.05 * np.sin(2.0 * np.pi * xi[0]) * np.sin(2.0 * np.pi * xi[1])
        return xi[0] + bump, xi[1] - bump

    def deformed(law: str, velocity: Any, side: Any, forcing: Any = None) -> Any:
        """The result of a solid with a velocity at first and one condition at all sides."""
        solid, n = ElasticSolid(1.0, 1.5, 0.0, 1.0, 1.0, law=law, heat="elastic"), round(1.0 / h)
        start = lambda X, Y: (*velocity(X, Y), 1.0, X, Y)  # noqa: E731
        block = Block("solid", solid, curved, (n, n), start, forcing=forcing)
        faces = {("solid", axis, side_of): side for axis in (0, 1) for side_of in (0, 1)}
        return trial.solve(BlockProblem((block,), faces, units="none"), 1.0).layers[0]

    speeds = {"shear": lambda X, Y, t=0.0: [Y, 0.0 * X]}
    speeds["extension"] = lambda X, Y, t=0.0: [X, 0.0 * X]
    for (row, law), (how, speed) in product(enumerate(("neo-hookean", "svk")), speeds.items()):
        side = Clamped(x=lambda X, Y, t, v=speed: [X + t * v(X, Y)[0], Y], velocity=speed)
        frame = deformed(law, speed, side).frame(-1)
        exact = np.array([table[f"{how} {name}"][row] for name in stresses])
        apart = np.array([frame[name] - of for name, of in zip(stresses, exact)])
        rounded = 8.0 / h * 2.0**-52 / h  # of differences, once in each step
        trial.check(f"{how}, {law}", apart / max(abs(exact)), most=rounded)

    rate = 2.0 * np.pi

    def force(X: Array, Y: Array, t: float) -> list[Array]:
        c, s = np.cos(rate * t), np.sin(rate * t)
        x, y = X - 0.5, Y - 0.5
        return [-(rate**2) * (c * x - s * y), -(rate**2) * (s * x + c * y), 0.0, 0.0, 0.0]

    turning = lambda X, Y: (-rate * (Y - 0.5), rate * (X - 0.5))  # noqa: E731
    turned = deformed("neo-hookean", turning, Free(), force)
    first, last = turned.frame(0), turned.frame(-1)
    trial.check("rotation, place", [last[x] - first[x] for x in "xy"], rate=3.0)
    trial.check("rotation, stress", [last[name] for name in stresses], rate=2.0)


@entry(dict.fromkeys((4, 2, 6), (20, 30)))
def beam(trial: Trial) -> None:
    """Free vibration in vacuum: the slowest motion that bends a beam."""
    table, h = reference("beam"), trial.h
    solid = ElasticSolid(1.0, 0.0, 0.0, 1.0, 1.0, law="linear", heat="elastic")
    hinges = tuple(("beam", (x, 0.0), Hinge()) for x in (0.0, 1.0))
    ways = ("clamped", 0.05, 22.37, Clamped(), ()), ("hinged", 0.02, np.pi**2, Free(), hinges)
    for ends, d, thin, sides, points in ways:
        across, cells, unit = (-0.5 * d, 0.5 * d), round(0.6 / h), np.sqrt(d**2 / 6.0)
        bent = Layer("beam", solid, across, lambda X, Y: (0, 0, 1, X, Y), cells, sides=sides)
        around = {"lower": Free(), "upper": Free(), "along": ((0.0, 1.0),), "points": points}
        problem = layers(bent, cells=(round(1 / h),), **around)
        # 2/1 has a second mode near it, which alternates from node to node
        s = modes_near(problem, {"fsi_order": trial.order}, 0.9j * thin * unit)[0]
        row = np.argmin(np.abs(table["d"] - d))
        known, other = table[ends][row], table[f"{ends} pi^2/12"][row]
        expected = trial.closures, abs(1.0 - other / known)
        trial.compare(f"{ends}, d = {d:g}", s.imag / unit, known, *expected)


def metal(density: float, fast: float, slow: float, pressure: float = 0.0) -> ElasticSolid:
    """An elastic solid of these speeds of P and S waves, free of stress under a pressure [SI]."""
    mu = density * slow**2
    lame = density * fast**2 - 2.0 * mu
    return ElasticSolid(mu, lame, 0.0, density, 1000.0, p_ref=pressure, heat="elastic")


@entry({4: (16, 32), 6: (24, 32)})
def normal_modes(trial: Trial) -> None:
    """Waves along the interface of two layers, 1 m deep: water or a metal over a metal."""
    table, n, gamma, cv, p, rho = reference("normal_modes"), round(1 / trial.h), 4.4, 1e3, 1e5, 1e3
    p_inf = rho * 1480.0**2 / gamma - p
    T = (p + p_inf) / ((gamma - 1.0) * cv * rho)
    water = Fluid(0.0, 0.0, gamma, (gamma - 1.0) * cv, law=stiffened_gas(gamma, cv, p_inf))
    fluid, solid = constant(rho, 0.0, 0.0, T), at_rest(T)
    steel, aluminium = metal(7850.0, 5900.0, 3200.0, p), (2700.0, 6320.0, 3130.0)
    above, tungsten = metal(*aluminium), metal(19250.0, 5220.0, 2890.0)
    for name, lid, upper, start, lower in (
        ("water over steel", Slip(), water, fluid, steel),
        ("water over aluminium", Slip(), water, fluid, metal(*aluminium, p)),
        ("tungsten under aluminium", Clamped(), above, solid, tungsten),
    ):
        below = Layer("lower", lower, (-1.0, 0.0), solid, cells=n)
        top = Layer("upper", upper, (0.0, 1.0), start, cells=n)
        problem = layers(below, top, lower=Clamped(), upper=lid, along=((0.0, 1.0),), cells=(n,))
        found = column_modes(problem, {"fsi_order": trial.order}, 0, 1)[0]
        known = complex(table[f"{name} real"][0], table[f"{name} imag"][0])
        trial.compare(name, found[np.abs(found - known).argmin()], known, trial.closures)


@entry({4: (24, 32, 48)}, quick=False)
def panel_flutter(trial: Trial) -> None:
    """lambda where the growth of the faster of two modes of a panel becomes positive. It differs
    from the thin limit by the effect of the thickness.

    The growth has a kink where the frequencies meet, but over sqrt(D / mass) the coefficients of
    (s - s1)(s - s1*)(s - s2)(s - s2*) are smooth: parabolas over lambda^2 are laid through them.
    """
    table, panel, d, mach = reference("panel_flutter"), load_case("panel"), 0.04, 2.0
    row = np.argmin(np.abs(table["d"] - d))
    # the order of frequencies where stress in a clamped corner goes as r^(0.69 - 1); frequency over
    # sqrt(D/m) of a thin panel at the onset of flutter, and lambdas around this
    clamped, hinged = (1.38, 52.0, (600.0, 650.0, 700.0)), (None, 32.0, (320.0, 350.0, 380.0))
    for ends, (order, frequency, lambdas) in {"clamped": clamped, "hinged": hinged}.items():
        own = {"panel_ends": ends, "panel_mach": mach, "panel_thickness": d, "panel_push": 0.0}
        opt = {**defaults(panel), "fsi_order": trial.order, "fsi_h": trial.h, **own}
        found, x = [], np.square(lambdas)
        for at in lambdas:
            opt["panel_lambda"] = at
            unit = np.sqrt(mach**2 / (at * np.sqrt(mach**2 - 1.0)) / opt["panel_mass"])
            s = modes_near(panel.build(opt), opt, 1j * frequency * unit, 2) / unit
            found.append(np.poly([*s, *s.conj()]).real)
        centre = 0.5 * (x.min() + x.max())
        fits = np.polynomial.polynomial.polyfit(x - centre, found, 2)

        def growth(at: float, centre: float = centre, fits: Array = fits) -> float:
            at_once = np.polynomial.polynomial.polyval(at * at - centre, fits)
            return float(np.roots(at_once).real.max())

        onset = float(brentq(growth, lambdas[0], lambdas[-1]))
        thin, thick = table[f"{ends} lambda"][:2]
        off = 1.0 - thick / thin
        trial.compare(f"{ends}, theory", onset, table[f"{ends} theory"][row], order, off)
        trial.compare(f"{ends}, thin limit", onset, thin, most=off)
