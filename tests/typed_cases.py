"""What case files and programs take of the package, with types: mypy --strict must accept it."""

import numpy as np
from numpy.typing import NDArray

import fsipetsc as fsi
from fsipetsc import Block, BlockProblem, Fluid, FluidLayer, Problem, Solid, SolidLayer, Wall
from fsipetsc.blocks import conditions, maps
from fsipetsc.blocks.conditions import Condition, Free, NoSlip, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.materials.own import gas_law, solid_law
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.mesh_files import read_cgns

Array = NDArray[np.float64]
P0, T0 = 1e5, 300.0


def driven() -> list[Problem]:
    """Data that depend on time, and lists for tuples."""
    air, plate = Fluid(0.0, 0.1, 1.4, 287.0, force=9.81), Solid(1e7, 0.2, 100.0, 1000.0)

    def still(X: Array) -> tuple[float, float, float]:
        return 1.0, 0.0, T0

    def heat(X: Array, t: float) -> tuple[float, float, Array]:
        return 0.0, 0.0, t * X

    def at_rest(X: Array) -> tuple[float, float, float, Array]:
        return 0.0, 0.0, T0, X

    gas = FluidLayer("gas", air, (0.0, 1.0), still, forcing=heat)
    solid = SolidLayer("plate", plate, (1.0, 2.0), at_rest)
    piston = Wall(lambda t: 0.1 * np.sin(t), T=lambda t: T0 + t, velocity=lambda t: 0.1 * np.cos(t))
    stopped = Wall(lambda t: np.where(t < 1.0, t, 1.0))
    filled = fsi.Dirichlet(0.0, lambda t: (1.0, t, T0))
    starts = piston, stopped, filled, fsi.Open(0.0, P0, T0)
    driven, pressed = fsi.clamped(lambda t: np.sin(t)), fsi.free(-P0, T=T0)
    ends = driven, pressed, fsi.absorbing(heat_flux=1.0), fsi.clamped()
    return [Problem([gas, solid], start, end, notes=["driven"]) for start, end in zip(starts, ends)]


def drift(case: Problem) -> float:
    """Of the energy in a run: the functions for runs and results."""
    try:
        with fsi.run(case, order=4, h=0.1, output="a.h5") as run:
            hottest: float = run.layers[0]["T"].max()
            print(run.case, hottest, run.summary["steps"], fsi.compare("b.h5", run.path).equal)
            return float(np.ptp(run.series["energy"]))
    except fsi.InputError as error:
        return error.status


def still(*X: Array) -> tuple[float, ...]:
    return 1.0, *(0.0 for _ in X), T0


def every(path: str) -> BlockProblem:
    """All maps and all conditions."""
    water = Fluid(1e-3, 0.6, 4.4, 400.0, law=stiffened_gas(4.4, 1800.0, 6e8))
    gas = gas_law(
        pressure=lambda rho, T: rho * T,
        internal_energy=lambda rho, T: T,
        temperature=lambda rho, e: e,
        density=lambda p, T: p / T,
        temperature_of=lambda rho, p: p / rho,
    )
    own = ElasticSolid(0.0, 0.0, 0.0, 1.0, 1.0, law=solid_law(stress=lambda F: F))
    square = rectangle((0.0, 0.0), (1.0, 1.0))
    upright = (lambda y: (0.0 * y, y)), (lambda y: (1.0, y))
    flat = (lambda x: (x, 0.0 * x)), (lambda x: (x, 1.0 + x * (1.0 - x)))
    grid = read_cgns(path)

    def bent(xi: tuple[Array, ...]) -> tuple[Array, Array]:
        return xi[0], xi[1] + 0.1 * np.sin(xi[0])

    blocks = [
        Block("bent", water, bent, (8, 8), still),
        Block("free", own, maps.corners((0, 0), (1, 0), (0, 1), (1, 1)), (8, 8), still),
        Block("a", water, maps.transfinite(upright, flat), (8, 8), still),
        Block("b", Fluid(0.0, 0.0, 1.4, 1.0, law=gas), square, (8, 8), still),
        Block("c", water, maps.nodes(np.zeros((3, 4, 2))), (3, 2), still),
        Block("d", water, maps.off_axis(square, 8), (8, 8), still),
        *(Block(name, water, zone, zone.cells, still) for name, zone in grid.zones.items()),
    ]
    faces: dict[tuple[str, int, int], Condition] = {
        ("bent", 0, 0): conditions.Given(lambda X, Y, t: (1.0, 0.0, t, T0)),
        ("bent", 0, 1): conditions.Outflow(P0),
        ("bent", 1, 0): NoSlip(T=lambda X, Y, t: T0 + t * X, slip_length=0.1),
        ("bent", 1, 1): NoSlip(x=lambda X, Y, t: (X, Y + np.sin(t))),
        ("free", 1, 0): Free(lambda X, Y, t: P0 + t),
        ("free", 0, 0): conditions.Absorbing(-P0),
        ("free", 0, 1): conditions.Roller(T=T0),
        ("a", 0, 0): conditions.Periodic((1.0, 0.0)),
        ("d", 1, 0): conditions.Centre(),
        **grid.faces({"inner": NoSlip()}),
    }
    faces["a", 0, 1] = conditions.Periodic((-1.0, 0.0))
    return BlockProblem(
        blocks,
        faces,
        jumps=lambda X, Y, t: (0.0 * X, t, 0.0),
        points=[("free", (0.0, 0.0), conditions.Hinge())],
        symmetry=1,
    )


def wrong(block: Block) -> None:
    """What the checker must refuse: an ignored line without an error is an error."""
    air = Fluid("thick", 0.0, 1.4, 287.0)  # type: ignore[arg-type]
    FluidLayer("gas", air, (0.0, 1.0), 1.0)  # type: ignore[arg-type]
    FluidLayer("gas", air, (0.0, 1.0), lambda: (1.0, 0.0, T0))  # type: ignore[arg-type,misc]
    Problem((), left=0.0, right=Wall(1.0))  # type: ignore[arg-type]
    Wall(0.0, temperature=T0)  # type: ignore[call-arg]
    NoSlip(T="hot")  # type: ignore[arg-type]
    rectangle(0.0)  # type: ignore[call-arg]
    BlockProblem((block,), {("gas", 0): Slip()})  # type: ignore[arg-type]
    BlockProblem(block, {})  # type: ignore[arg-type]
    BlockProblem((block,), {("gas", 0, 0): "wall"})  # type: ignore[arg-type]
