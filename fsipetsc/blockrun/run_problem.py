"""A problem of blocks under the names that a run asks for: layers, interfaces, invariants."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block, determinant, mesh
from fsipetsc.blocks.conditions import holds_energy, steady
from fsipetsc.blocks.problem import BlockProblem, Meeting

#: letters of axes, of positions and of velocities
PLACES, VELOCITIES = "xyz", "uvw"
#: cells per axis by which the size of a block is estimated
_CELLS = 8


class RunProblem:
    """A BlockProblem as a run sees it; what it does not have itself it has from the problem.

    layers: its blocks. bodies: numbers of the blocks of each body of gas, which joins connect.
    """

    def __init__(self, problem: BlockProblem) -> None:
        self.blocks_problem = problem
        self.layers: tuple[Block, ...] = problem.blocks
        self.notes: tuple[str, ...] = tuple(problem.notes)
        self.bodies = _bodies(problem)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.blocks_problem, name)

    def unit(self, name: str) -> str:
        """What stands behind a number in a message: " m", or nothing without dimensions."""
        return f" {name}" if self.units == "SI" else ""

    @cached_property
    def interfaces(self) -> list[tuple[int, int]]:
        """(block of gas, block of a solid) that have faces in common, in the order of blocks."""
        found = set()
        for k, face in self._faces(Meeting):
            other = self.faces_of(k)[face].block
            if self.layers[k].kind == "fluid" and self.layers[other].kind == "solid":
                found.add((k, other))
        return sorted(found, key=sorted)

    @property
    def interface_names(self) -> list[str]:
        """As "gas | plate", the block with the lower number first."""
        pairs = (sorted(pair) for pair in self.interfaces)
        return [" | ".join(self.layers[k].name for k in pair) for pair in pairs]

    def interface_nodes(self, number: int) -> np.ndarray:
        """Nodes of the solid on an interface, each once."""
        _, solid = self.interfaces[number]
        faces = [self.face_nodes(solid, *face) for face in self._solid_faces(number)]
        return np.unique(np.concatenate(faces))

    @property
    def interface_faces(self) -> list[list[int]]:
        """[block, axis, side] of the solid's face on each interface, the first one of several."""
        pairs = enumerate(self.interfaces)
        return [[solid, *self._solid_faces(number)[0]] for number, (_, solid) in pairs]

    def _solid_faces(self, number: int) -> list[tuple[int, int]]:
        """(axis, side) of the solid's faces on an interface."""
        gas, solid = self.interfaces[number]
        faces = self.faces_of(solid).items()
        return sorted(f for f, met in faces if isinstance(met, Meeting) and met.block == gas)

    @cached_property
    def spacing(self) -> float:
        """The smallest mean size of the cells of a block [m]."""
        d = self.dimension
        return min((_size(b) / np.prod(b.cells)) ** (1.0 / d) for b in self.layers)

    @property
    def steady_data(self) -> bool:
        """No data of faces and no forcing depend on time."""
        forced = any(block.forcing is not None for block in self.layers)
        conditions = (self.faces_of(k)[face] for k, face in self._faces())
        still = all(steady(c) for c in conditions if not isinstance(c, Meeting))
        return still and not forced and self.jumps is None

    @cached_property
    def invariants(self) -> dict[str, Any]:
        """What must not change, as JSON has it: see fsipetsc.scheme.conservation_check.

        Less what comes in through faces and by forces, the mass of each body of gas, momentum and
        energy; entropy where nothing comes in and stresses do not heat the solids.
        """
        forced = self.jumps is not None or any(b.forcing is not None for b in self.layers)
        solids = [block for block in self.layers if block.kind == "solid"]
        gases = [k for k, block in enumerate(self.layers) if block.kind == "fluid"]
        conditions = [self.faces_of(k)[face] for k, face in self._faces()]
        closed = all(holds_energy(c) for c in conditions if not isinstance(c, Meeting))
        elastic = all(getattr(solid.material, "heat", "") == "elastic" for solid in solids)
        masses = [solid.material.m0 * self._volume(solid) for solid in solids]
        capacities = [m * solid.material.alpha for m, solid in zip(masses, solids, strict=True)]
        return {
            "masses": [
                [" + ".join(self.layers[k].name for k in body), [gases.index(k) for k in body]]
                for body in self.bodies
            ],
            "momentum": self.symmetry == 0,  # pressure acts around an axis, too
            "energy": True,
            "entropy": closed and elastic and not forced,
            "inertia": sum(masses),
            "heat_capacity": sum(capacities),
        }

    def _volume(self, block: Block) -> float:
        """About that of a block at rest; of a sector where there is an axis or a centre."""
        if not self.symmetry:
            return _size(block)
        n = self.symmetry + 1
        low, high = (float(_values(block.map, [np.array([end])])[0][0]) for end in (0.0, 1.0))
        return (high**n - low**n) / n

    def _faces(self, kind: type = object) -> list[tuple[int, tuple[int, int]]]:
        """(block, face) where something of this kind stands."""
        return [
            (k, face)
            for k in range(len(self.layers))
            for face, stands in self.faces_of(k).items()
            if isinstance(stands, kind)
        ]


def _bodies(problem: BlockProblem) -> list[list[int]]:
    """Blocks of gas that joins connect."""
    bodies = [[k] for k, block in enumerate(problem.blocks) if block.kind == "fluid"]
    for k, block in enumerate(problem.blocks):
        for met in problem.faces_of(k).values() if block.kind == "fluid" else ():
            if isinstance(met, Meeting) and problem.blocks[met.block].kind == "fluid":
                here = [body for body in bodies if {k, met.block} & set(body)]
                rest = [body for body in bodies if body not in here]
                bodies = sorted([*rest, sorted(j for body in here for j in body)])
    return bodies


def _size(block: Block) -> float:
    """About the volume of a block: that of some cells, by their middles."""
    d, step = block.dimension, 1e-4
    xi = np.array(mesh([(np.arange(_CELLS) + 0.5) / _CELLS] * d))
    slopes = []
    for shift in step * np.eye(d).reshape(d, d, *[1] * d):
        high, low = (np.array(_values(block.map, xi + s * shift)) for s in (1.0, -1.0))
        slopes.append((high - low) / (2.0 * step))
    return float(np.abs(determinant(np.array(slopes))).mean())


def _values(function: Callable[..., Any], xi: np.ndarray) -> list[np.ndarray]:
    return [np.broadcast_to(value, xi[0].shape) for value in function(tuple(xi))]
