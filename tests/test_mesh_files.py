"""Grids from CGNS files: one that Gmsh 4 wrote (two sectors of an annulus), small ones."""

import h5py
import numpy as np
import pytest
from helpers import REPOSITORY

from fsipetsc import Block, BlockProblem, Fluid, InputError
from fsipetsc.blocks.conditions import NoSlip, Slip
from fsipetsc.mesh_files import read_cgns

AIR = Fluid(mu=0.01, kappa=0.0, gamma=1.4, R=287.0)
SQUARE = np.meshgrid(np.linspace(0.0, 2.0, 5), np.linspace(0.0, 1.0, 4))


def block_of(name, zone):
    return Block(name, AIR, zone, zone.cells, lambda X, Y: (1.2, 0.0, 0.0, 300.0))


def problem_of(grid, conditions):
    blocks = tuple(block_of(*zone) for zone in grid.zones.items())
    return BlockProblem(blocks, grid.faces(conditions))


def read(folder, X, kind="Structured", patch=None, unit=None):
    """A file with a zone 'z' of coordinates X, as CGNS has them; patch: (first nodes, last)."""

    def put(group, name, label, data=None):
        child = group.create_group(name)
        child.attrs["label"] = np.bytes_(label)
        if isinstance(data, str):
            data = np.frombuffer(data.encode(), "i1")
        if data is not None:
            child.create_dataset(" data", data=data)
        return child

    with h5py.File(folder / "a.cgns", "w") as file:
        base = put(file, "base", "CGNSBase_t", np.array([2, len(X)]))
        if unit:
            names = "".join(n.ljust(32) for n in ("Kilogram", unit, "Second", "Kelvin", "Radian"))
            put(base, "DimensionalUnits", "DimensionalUnits_t", names)
        zone = put(base, "z", "Zone_t", np.zeros((3, 2), int))
        put(zone, "ZoneType", "ZoneType_t", kind)
        grid = put(zone, "GridCoordinates", "GridCoordinates_t")
        for name, x in zip("XYZ", X, strict=False):
            put(grid, f"Coordinate{name}", "DataArray_t", x)
        if patch:
            wall = put(put(zone, "ZoneBC", "ZoneBC_t"), "wall", "BC_t", "BCWall")
            put(wall, "PointRange", "IndexRange_t", np.array(patch))
    return read_cgns(folder / "a.cgns")


def test_blocks_of_a_file_of_gmsh_meet():
    grid = read_cgns(REPOSITORY / "tests" / "frozen" / "sector.cgns")
    cells = {name: zone.cells for name, zone in grid.zones.items()}
    assert cells == {"gas_S00001": (8, 12), "gas_S00002": (8, 12)}
    conditions = {"inner": NoSlip(), "outer": Slip(), "bottom": Slip(), "left": Slip()}
    problem = problem_of(grid, conditions)
    assert problem.joined
    X = problem.places(0, problem.blocks[0].face_nodes(0, 0))
    assert np.hypot(*X.T) == pytest.approx(np.ones(13), abs=1e-12)
    with pytest.raises(InputError, match=r"axis 1, side 1.*has no condition"):
        problem_of(grid, {k: v for k, v in conditions.items() if k != "left"})
    with pytest.raises(InputError, match="no patch 'outlet': it has 'bottom', "):
        grid.faces({"outlet": Slip()})


def test_units_planes_and_hands(tmp_path):
    x, y = SQUARE
    grid = read(tmp_path, (x, y), unit="Millimeter", patch=((5, 1), (5, 4)))
    assert grid.zones["z"].places[-1, -1] == pytest.approx([2e-3, 1e-3])
    assert grid.patches == {"wall": (("z", 0, 1),)}
    # (z, x) is right-handed in the plane y = 1; x runs backwards, so the zone is turned
    turned = read(tmp_path, (y, 1.0 + 0.0 * x, x), patch=((1, 1), (1, 4)))
    left = read(tmp_path, (2.0 - x, y), patch=((1, 1), (1, 4)))
    for grid, side in ((turned, 0), (left, 1)):
        assert grid.zones["z"].places[0, 0] == pytest.approx([0.0, 0.0])
        assert grid.patches == {"wall": (("z", 0, side),)}
        block_of("z", grid.zones["z"])


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"kind": "Unstructured"}, "zone 'z' is Unstructured: expected Structured"),
        ({"patch": ((1, 1), (3, 1))}, "'wall' has nodes 1 to 3 x 1 to 1: expected a whole face"),
        ({"unit": "Furlong"}, "lengths are in Furlong: expected Meter"),
    ],
)
def test_what_is_wrong_with_a_file(tmp_path, changed, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, **{"X": SQUARE, **changed})
