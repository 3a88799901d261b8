"""Grids from files: structured blocks that a meshing tool has written as CGNS, in its HDF5 form
(cgns.org, 'SIDS File Mapping'): each node of its tree is a group with a label, and its data stand
in a dataset named ' data', the first index fastest.

    grid = read_cgns("nozzle.cgns")
    blocks = [Block(name, air, X, X.cells, at_rest) for name, X in grid.zones.items()]
    problem = BlockProblem(blocks, grid.faces({"inlet": Given(...), "wall": Slip()}))

Faces whose nodes are at the same places meet, as in any problem of blocks: what the file says of
connections is not needed.
"""

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from fsipetsc.blocks.block import determinant
from fsipetsc.blocks.faces import FaceName
from fsipetsc.blocks.maps import Nodes
from fsipetsc.checks import Array
from fsipetsc.errors import InputError

#: units of length in CGNS [m]
METRES = {"Meter": 1.0, "Centimeter": 0.01, "Millimeter": 0.001, "Foot": 0.3048, "Inch": 0.0254}
METRES |= {"Null": 1.0, "UserDefined": 1.0}
#: a coordinate is constant that varies by less than this part of the others
FLAT = 1e-9


class Grid(NamedTuple):
    """What a file of a mesh holds.

    Attributes:
        zones: name -> its nodes [m], a map for `Block`; its `cells` are those of the block.
        patches: name of a boundary -> its faces, as `BlockProblem` names them.
    """

    zones: dict[str, Nodes]
    patches: dict[str, tuple[FaceName, ...]]

    def faces(self, conditions: Mapping[str, Any]) -> dict[FaceName, Any]:
        """Face -> condition, for `BlockProblem`.

        Args:
            conditions: name of a patch -> its condition. InputError if there is no such patch.
        """
        for name in conditions.keys() - self.patches.keys():
            known = ", ".join(map(repr, self.patches)) or "none"
            raise InputError(f"the grid has no patch {name!r}: it has {known}")
        return {face: given for name, given in conditions.items() for face in self.patches[name]}


def read_cgns(path: str | Path) -> Grid:
    """The structured zones of a CGNS file in two or three dimensions, in metres.

    A patch has the name of its family, else that of its boundary condition. Plane zones in space
    lose the coordinate that is constant. A left-handed zone gets its axis 0 reversed.

    Args:
        path: a CGNS file in its HDF5 form.

    Raises:
        InputError: the file cannot be read, or a zone, which is named, is of another kind.
    """
    grid = Grid({}, {})
    try:
        with h5py.File(path, "r") as file:
            for base in _labelled(file, "CGNSBase_t"):
                units = [_text(of)[32:64].strip() for of in _labelled(base, "DimensionalUnits_t")]
                if not {*units} <= {*METRES}:
                    raise ValueError(f"lengths are in {units[0]}: expected {', '.join(METRES)}")
                for zone in _labelled(base, "Zone_t"):
                    _add(grid, zone, METRES[(*units, "Null")[0]])
        if not grid.zones:
            raise ValueError("it has no structured zones")
    except (OSError, KeyError, ValueError) as error:
        raise InputError(f"{path}: {error} (what is read is CGNS in HDF5)") from None
    return grid


def _add(grid: Grid, zone: h5py.Group, metres: float) -> None:
    name = zone.name.rsplit("/", 1)[-1]
    if (kind := _text(zone["ZoneType"])) != "Structured":
        raise ValueError(f"zone '{name}' is {kind}: expected Structured")
    places = _places(name, zone["GridCoordinates"]) * metres
    d, every = places.shape[-1], [[0, n - 1] for n in places.shape[-2::-1]]
    corner = places[(slice(0, 2),) * d]  # two nodes along each axis
    edges = [np.diff(corner, axis=d - 1 - k)[(0,) * d] for k in range(d)]
    turned = determinant(np.array(edges)) < 0.0
    grid.zones[name] = Nodes(np.flip(places, axis=d - 1) if turned else places)
    for bc in (bc for group in _labelled(zone, "ZoneBC_t") for bc in _labelled(group, "BC_t")):
        patch = _text(bc["FamilyName"]) if "FamilyName" in bc else bc.name.rsplit("/", 1)[-1]
        ends = np.sort(np.asarray(bc["PointRange"][" data"]).reshape(2, d) - 1, axis=0).T.tolist()
        for axis, side in product(range(d), (0, 1)):
            if ends == [*every[:axis], [every[axis][side]] * 2, *every[axis + 1 :]]:
                face = name, axis, int(side != (turned and axis == 0))
                grid.patches[patch] = (*grid.patches.get(patch, ()), face)
                break
        else:
            wrong = f"nodes {' x '.join(f'{a + 1} to {b + 1}' for a, b in ends)}"
            raise ValueError(f"zone '{name}', patch '{patch}' has {wrong}: expected a whole face")


def _places(name: str, grid: h5py.Group) -> Array:
    """Nodes (…, d) of a zone; of a plane in space without the coordinate that is constant."""
    axes = [np.asarray(grid[f"Coordinate{x}"][" data"]) for x in "XYZ" if f"Coordinate{x}" in grid]
    if len(axes) == 3 and axes[0].ndim == 2:
        extent = [float(np.ptp(x)) for x in axes]
        flat = int(np.argmin(extent))
        if extent[flat] > FLAT * max(extent):
            raise ValueError(f"zone '{name}' is no plane: expected one coordinate that is constant")
        axes = [axes[k] for k in ((1, 2), (2, 0), (0, 1))[flat]]
    if not 2 <= len(axes) == axes[0].ndim:
        raise ValueError(f"zone '{name}' has {', '.join(grid)}: expected CoordinateX, CoordinateY")
    return np.stack(axes, axis=-1)


def _labelled(group: h5py.Group, label: str) -> list[h5py.Group]:
    children = [child for child in group.values() if isinstance(child, h5py.Group)]
    return [child for child in children if child.attrs.get("label", b"").decode() == label]


def _text(group: h5py.Group) -> str:
    return np.asarray(group[" data"]).astype("i1").tobytes().decode().strip("\0 ")
