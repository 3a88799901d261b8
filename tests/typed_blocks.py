"""A case of blocks as `python -m fsipetsc new -blocks` writes it, and all maps, conditions and laws
of a case's own, with types: mypy --strict must accept it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc import Block, BlockProblem, Option
from fsipetsc.blocks import conditions, maps
from fsipetsc.blocks.conditions import Condition, Free, NoSlip, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.maps import annulus, rectangle
from fsipetsc.equations.elementary import exp, power
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.own import gas_law, solid_law
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.mesh_files import read_cgns

Array = NDArray[np.float64]
SUMMARY = "an elastic ring around a gas that is compressed on one side"
OPTIONS = (
    Option("ring_modulus", float, 1e6, "Pa", "2 mu + lambda of the ring", check="positive"),
    Option("ring_density", float, 100.0, "kg/m3", "density of the ring", check="positive"),
)
DEFAULTS = {"fsi_h": 0.02, "fsi_order": 4, "ts_max_time": 0.02, "fsi_output_dt": 0.0004}
P0, T0 = 1e5, 300.0
PIPE, INNER, OUTER = 0.1, 0.4, 0.5


def build(opt: Mapping[str, Any]) -> BlockProblem:
    h: float = opt["fsi_h"]
    air = Fluid(mu=0.0, kappa=0.0, gamma=1.4, R=287.0)
    K, density = opt["ring_modulus"], opt["ring_density"]
    more: dict[str, Any] = {"p_ref": P0, "law": "neo-hookean", "heat": "elastic"}
    rubber = ElasticSolid(mu_e=K / 4, lambda_e=K / 2, kappa_e=0.0, m0=density, alpha=1500.0, **more)

    def pulse(X: Array, Y: Array) -> tuple[Array, float, float, Array]:
        p = P0 * (1.0 + 2.0 * exp(-((X - 0.25) ** 2 + Y**2) / 0.05**2))
        T = T0 * power(p / P0, 1.0 - 1.0 / air.gamma)
        return p / (air.R * T), 0.0, 0.0, T

    def at_rest(X: Array, Y: Array) -> tuple[float, float, float, Array, Array]:
        return 0.0, 0.0, T0, X, Y

    def cells(thickness: float) -> int:
        return max(8, round(thickness / h))

    around, loop = 8 * round(np.pi * INNER / 8 / h), (False, True)
    inside, outside = (cells(INNER - PIPE), around), (cells(OUTER - INNER), around)
    blocks = (
        Block("gas", air, annulus(PIPE, INNER), inside, pulse, periodic=loop),
        Block("ring", rubber, annulus(INNER, OUTER), outside, at_rest, periodic=loop),
    )
    faces = {("gas", 0, 0): Slip(), ("ring", 0, 1): Free(P0)}
    return BlockProblem(blocks, faces)


def still(*X: Array) -> tuple[float, ...]:
    return 1.0, *(0.0 for _ in X), T0


def slab() -> BlockProblem:
    """Flat layers; conditions in dictionaries, functions of place and time."""
    air = Fluid(1e-5, 0.0, 1.4, 287.0)
    stiff = ElasticSolid(1.0, 2.0, 0.0, 1.0, 1.0, force=(0.0, -9.81))

    def at_rest(X: Array, Y: Array) -> list[Array]:
        return [0.0 * X, 0.0 * X, T0 + 0.0 * X, X, Y]

    def hot(X: Array, Y: Array, t: float) -> Array:
        return T0 + t * X

    walls = {(0, 0): NoSlip(T=hot), (0, 1): NoSlip(x=lambda X, Y, t: (X, Y + np.sin(t)))}
    held, way = conditions.Clamped(), [(0.2, 0.8)]
    panel = Layer("panel", stiff, (0.0, 0.1), at_rest, cells=8, span=way, sides=held)
    gas = Layer("air", air, (0.1, 1.0), still, sides=walls, beside=NoSlip(slip_length=0.1))
    lower, upper = Free(lambda X, Y, t: P0 + t), conditions.Open(1.0, (0.0, 0.0), T0, order=1)
    return layers(panel, gas, along=[(0.0, 1.0)], h=0.1, lower=lower, upper=upper)


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
        Block("b", Fluid(0.0, 0.0, 1.4, 1.0, law=gas), maps.stretched(square, None), (8, 8), still),
        Block("c", water, maps.nodes(np.zeros((3, 4, 2))), (3, 2), still),
        Block("d", water, maps.off_axis(square, 8), (8, 8), still),
        Block("e", water, maps.ball(1.0, 8), (8,), still),
        *(Block(name, water, zone, zone.cells, still) for name, zone in grid.zones.items()),
    ]
    faces: dict[tuple[str, int, int], Condition] = {
        ("bent", 0, 0): conditions.Given(lambda X, Y, t: (1.0, 0.0, t, T0)),
        ("bent", 0, 1): conditions.Outflow(P0),
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
    NoSlip(T="hot")  # type: ignore[arg-type]
    rectangle(0.0)  # type: ignore[call-arg]
    BlockProblem((block,), {("gas", 0): Slip()})  # type: ignore[arg-type]
    BlockProblem(block, {})  # type: ignore[arg-type]
    BlockProblem((block,), {("gas", 0, 0): "wall"})  # type: ignore[arg-type]
