"""A problem of blocks under the names that a run asks for: layers, interfaces, invariants."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block, determinant, mesh
from fsipetsc.blocks.conditions import holds_energy, steady
from fsipetsc.blocks.faces import united
from fsipetsc.blocks.problem import BlockProblem, Meeting

#: letters of axes, of positions and of velocities
PLACES, VELOCITIES = "xyz", "uvw"
#: where energy comes in that comes through no face: by forces, interfaces, points that are held
INSIDE = "inside"
#: pieces along an axis by which the size of a block is estimated
_CELLS = 32


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
        every = ((k, met) for k in range(len(self.layers)) for met in self.faces_of(k).values())
        met = {(k, m.block) for k, m in every if isinstance(m, Meeting)}
        kinds = [block.kind for block in self.layers]
        found = [(k, j) for k, j in met if (kinds[k], kinds[j]) == ("fluid", "solid")]
        return sorted(found, key=sorted)

    @property
    def interface_names(self) -> list[str]:
        """As "gas | plate", the block with the lower number first."""
        pairs = (sorted(pair) for pair in self.interfaces)
        return [" | ".join(self.layers[k].name for k in pair) for pair in pairs]

    @property
    def face_names(self) -> list[str]:
        """Of what energy comes in by: the outer faces, as "gas, axis 0, side 1"; then INSIDE."""
        faces = ((self.layers[k].name, axis, side) for k, axis, side in self.outer_faces)
        return [*(f"{name}, axis {axis}, side {side}" for name, axis, side in faces), INSIDE]

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

    @cached_property
    def _conditions(self) -> list[Any]:
        """Of all faces that no other one meets."""
        return [self.faces_of(k)[axis, side] for k, axis, side in self.outer_faces]

    @property
    def _forced(self) -> bool:
        """There is forcing, or interfaces get something from outside."""
        return self.jumps is not None or any(b.forcing is not None for b in self.layers)

    @property
    def steady_data(self) -> bool:
        """No data of faces and no forcing depend on time."""
        return all(map(steady, self._conditions)) and not self._forced

    @cached_property
    def invariants(self) -> dict[str, Any]:
        """What must not change, as JSON has it: see fsipetsc.scheme.conservation_check.

        Less what comes in through faces and by forces, the mass of each body of gas, momentum and
        energy; entropy where nothing comes in and stresses do not heat the solids.
        """
        solids = [block for block in self.layers if block.kind == "solid"]
        gases = [k for k, block in enumerate(self.layers) if block.kind == "fluid"]
        closed = all(map(holds_energy, self._conditions)) and not self._forced
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
            "entropy": closed and elastic,
            "inertia": sum(masses),
            "heat_capacity": sum(capacities),
        }

    def _volume(self, block: Block) -> float:
        """About that of a block at rest; of a sector where there is an axis or a centre."""
        if not self.symmetry:
            return _size(block)
        n = self.symmetry + 1
        low, high = (float(block.face_positions(0, side)[0, 0]) for side in (0, 1))
        return (high**n - low**n) / n


def _bodies(problem: BlockProblem) -> list[list[int]]:
    """Blocks of gas that joins connect."""
    gas = [block.kind == "fluid" for block in problem.blocks]
    every = ((k, met) for k, own in enumerate(gas) if own for met in problem.faces_of(k).values())
    pairs = [(k, met.block) for k, met in every if isinstance(met, Meeting) and gas[met.block]]
    k, other = np.array(pairs, int).reshape(-1, 2).T
    first = united(np.arange(len(gas)), [(k, other)])
    return [np.flatnonzero(first == k).tolist() for k in np.unique(first) if gas[k]]


def _size(block: Block) -> float:
    """About the volume of a block: the sum over a few pieces, by the means of their edges."""
    d = block.dimension
    index = [np.unique(np.linspace(0, c, min(c, _CELLS) + 1).astype(int)) for c in block.cells]
    X, edges = block.places(mesh(index)), []
    for axis in range(1, d + 1):
        edge = np.diff(X, axis=axis)
        for other in range(1, d + 1):
            low, high = (np.delete(edge, end, axis=other) for end in (-1, 0))
            edge = edge if other == axis else 0.5 * (low + high)
        edges.append(edge)
    return float(np.abs(determinant(np.array(edges[::-1]))).sum())
