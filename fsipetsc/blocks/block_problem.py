"""A problem: blocks, what stands at their faces, and what a run asks of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block, Range, mesh, size_of
from fsipetsc.blocks.conditions import Centre, Condition, Hinge, NoSlip
from fsipetsc.blocks.faces import BlockFace, FaceName, meet, united
from fsipetsc.checks import Array, check, described, place_text
from fsipetsc.errors import InputError
from fsipetsc.materials.own import knows_entropy
from fsipetsc.operators.sbp import Band, band, centred_band


@dataclass(eq=False)
class BlockProblem:
    """Blocks and the conditions at their faces.

    Faces are (name of a block, axis, side), side 0 at xi = 0 and 1 at xi = 1. Those whose nodes are
    at the same places meet: two gases or two solids are joined, gas and solid have an interface.

    Args:
        blocks: one or more blocks, in one, two or three dimensions.
        faces: face -> condition (`fsipetsc.blocks.conditions`) of each face that meets no other.
        jumps: `jumps(*X, t)` returns d tractions [Pa], along the axes, and heat [W/m2] per
            reference area, which interfaces supply from outside; None: 0.
        points: (name of a block, place X, `Hinge()`) for points of solids' faces that are held.
        notes: lines that the result carries.
        units: "SI", or "none" for a problem without dimensions.
        symmetry: 1 if the last coordinate is the distance from an axis, in one or two dimensions;
            2 if that of one dimension is the distance from a centre. Integrals are then those of a
            sector of unit angle, or of unit solid angle.
    """

    blocks: Sequence[Block]
    faces: Mapping[FaceName, Condition]
    jumps: Callable[..., Any] | None = None
    points: Sequence[tuple[str, Any, Hinge]] = ()
    notes: Sequence[str] = ()
    units: str = "SI"
    symmetry: int = 0

    def __post_init__(self) -> None:
        """tolerance, kinds, members: as of `meet`. hinges: (block, node) of points. gas_laws: those
        of its gases that differ in formulas or numbers, in their order. layers: the blocks, under
        the name that a run has for those of either method.
        """
        self.layers = self.blocks = tuple(self.blocks)
        self.notes = tuple(self.notes)
        names = [getattr(block, "name", None) for block in self.blocks]
        if not names or not all(isinstance(block, Block) for block in self.blocks):
            raise InputError("BlockProblem: blocks: expected one or more Blocks")
        if len({*names}) < len(names) or len({block.dimension for block in self.blocks}) > 1:
            wanted = "expected names of their own and one number of dimensions"
            raise InputError(f"BlockProblem: blocks {', '.join(names)}: {wanted}")
        check("units", self.units, "BlockProblem: units")
        check("optional", self.jumps, "BlockProblem: jumps")
        self.dimension = self.blocks[0].dimension
        self.tolerance, self.kinds, self._known, self.members = meet(self.blocks, self.faces)
        for own, block in zip(self.kinds, self.blocks) if self.dimension > 1 else ():
            if block.kind == "fluid" and block.material.mu == 0.0:
                walls = {face: met for face, met in own.items() if isinstance(met, NoSlip)}
                own |= {face: met.without_friction() for face, met in walls.items()}
        self._columns: dict[Any, int] = {face: n for n, face in enumerate(self.outer_faces)}
        self._check_symmetry()
        self._find_laws()
        self.hinges = frozenset(self._hinge(*point) for point in self.points)

    def unit(self, name: str) -> str:
        """The unit after a number in a message: " m", or nothing without dimensions."""
        return f" {name}" if self.units == "SI" else ""

    def centred(self, k: int) -> bool:
        """Whether block k goes to r = 0, along its last axis."""
        return isinstance(self.kinds[k].get((self.dimension - 1, 0)), Centre)

    def band(self, k: int, order: int, axis: int) -> Band:
        """Pair weights of an axis of block k."""
        block = self.blocks[k]
        if axis == self.dimension - 1 and self.centred(k):
            return centred_band(order, block.cells[axis], self.symmetry)
        return band(order, block.cells[axis], block.periodic[axis])

    @cached_property
    def outer_faces(self) -> dict[tuple[int, int, int], Condition]:
        """(block, axis, side) -> what stands at faces that no other one meets, but for r = 0."""
        every = ((k, face, met) for k, own in enumerate(self.kinds) for face, met in own.items())
        return {(k, *face): c for k, face, c in every if not isinstance(c, (BlockFace, Centre))}

    def column(self, face: tuple[int, int, int] | None) -> int:
        """Where the energy of a face, or of none, is among what comes in, see `face_names`."""
        return self._columns.get(face, len(self._columns))

    @property
    def face_names(self) -> list[str]:
        """What energy comes in by: outer faces, as "gas, axis 0, side 1"; at last all else."""
        names = (f"{self.blocks[k].name}, axis {a}, side {side}" for k, a, side in self.outer_faces)
        return [*names, "through no face"]

    def _pairs(self, *kinds: str) -> list[tuple[int, int]]:
        """Blocks of these two kinds that have faces in common."""
        every = ((k, met) for k, own in enumerate(self.kinds) for met in own.values())
        found = {(k, met.block) for k, met in every if isinstance(met, BlockFace)}
        wanted = (pair for pair in found if tuple(self.blocks[k].kind for k in pair) == kinds)
        return sorted(wanted, key=sorted)

    @property
    def joined(self) -> bool:
        """Whether there are joins of gas and gas or solid and solid."""
        return bool(self._pairs("fluid", "fluid") or self._pairs("solid", "solid"))

    @cached_property
    def interfaces(self) -> list[tuple[int, int]]:
        """(block of gas, block of a solid) that have faces in common, in the order of blocks."""
        return self._pairs("fluid", "solid")

    @property
    def interface_names(self) -> list[str]:
        """As "gas | plate", the block with the lower number first."""
        return [" | ".join(self.blocks[k].name for k in sorted(pair)) for pair in self.interfaces]

    def interface_faces(self, number: int) -> list[list[int]]:
        """[block, axis, side] of the solid's faces on an interface."""
        gas, k = self.interfaces[number]
        faces = self.kinds[k].items()
        return sorted([k, *f] for f, c in faces if isinstance(c, BlockFace) and c.block == gas)

    def places(self, k: int, nodes: Array) -> Array:
        """X of nodes of block k, (len, d); on faces the same bits for all nodes at one place."""
        return self.places_at(k, np.unravel_index(nodes, self.blocks[k].shape, order="F")).T

    def positions(self, k: int, where: Range) -> Array:
        """X of a range of nodes of block k, (d, N), as `places`, also beyond periodic ends."""
        index = mesh([np.arange(*ends) for ends in where])
        return self.places_at(k, index).reshape(self.dimension, -1)

    def places_at(self, k: int, index: Sequence[Array]) -> Array:
        """X (d, …) of the nodes of these indices, d arrays of one shape, as `places`."""
        *others, i = index
        image = (i < 0) & self.centred(k)
        X = self.blocks[k].places([*others, np.where(image, -1 - i, i)], self._known[k])
        X[-1] *= np.where(image, -1.0, 1.0)
        return X

    def face_normal(self, k: int, node: int, axis: int, side: int) -> tuple[Array, Array]:
        """At a node of a face: the outward unit normal (d,) of the reference map, and the unit
        vectors (n, d) to its neighbours on the face; in one dimension, the one inwards.
        """
        block, slopes, around = self.blocks[k], [], []
        index = np.array(np.unravel_index(node, block.shape, order="F"))[:, None]
        here = self.places_at(k, index)[:, 0]
        for along, unit in enumerate(np.eye(self.dimension, dtype=int)[..., None]):
            n, closed = block.shape[along], block.periodic[along]
            steps = [s for s in (-1, 1) if closed or 0 <= index[along, 0] + s < n]
            places = [self.places_at(k, index + s * unit)[:, 0] for s in steps]
            slopes.append(np.mean([s * (X - here) for s, X in zip(steps, places)], axis=0))
            around += [X - here for X in places if along != axis]
        normal = np.linalg.inv(np.array(slopes))[:, axis] * (1.0 if side else -1.0)
        normal /= np.linalg.norm(normal)
        beside = np.array(around or [-normal])
        return normal, beside / np.linalg.norm(beside, axis=1, keepdims=True)

    @property
    def _forced(self) -> bool:
        """There is forcing, or interfaces get something from outside."""
        return self.jumps is not None or any(b.forcing for b in self.blocks)

    @property
    def steady_data(self) -> bool:
        """No data of faces and no forcing depend on time."""
        return all(c.steady for c in self.outer_faces.values()) and not self._forced

    def loses(self, k: int) -> bool:
        """Whether the energy that steps lose in block k is known. It is for a solid with heat
        'elastic', if no data replace its motion and no pressure of its heat drives it.
        """
        block, conditions = self.blocks[k], self.kinds[k].values()
        stores = block.kind == "solid" and block.material.heat == "elastic"
        driven = stores and (block.forcing is not None or block.material.pressing is not None)
        return stores and not driven and not any(getattr(c, "all_given", False) for c in conditions)

    @cached_property
    def invariants(self) -> dict[str, Any]:
        """What must not change, as JSON has it (fsipetsc.scheme.observables), less what comes in:
        the mass of each body of gas, momentum, energy; the entropy of gases, where it is known,
        nothing comes in, and they give no heat to solids.
        """
        blocks, outer = self.blocks, self.outer_faces.values()
        solids = [block for block in blocks if block.kind == "solid"]
        gases = [k for k, block in enumerate(blocks) if block.kind == "fluid"]
        pairs = ((blocks[gas].material, blocks[k].material) for gas, k in self.interfaces)
        shared = any(gas.kappa > 0.0 and solid.kappa_e > 0.0 for gas, solid in pairs)
        entropy = all(map(knows_entropy, self.gas_laws)) and not (shared or self._forced)
        entropy &= all(solid.material.heat == "elastic" for solid in solids)
        entropy &= all(condition.conserves_energy for condition in outer)
        masses = [solid.material.m0 * size_of(solid, self.symmetry) for solid in solids]
        joins = np.array(self._pairs("fluid", "fluid"), int).reshape(-1, 2).T
        body_of = united(len(blocks), [tuple(joins)])[gases]
        bodies = [np.flatnonzero(body_of == body).tolist() for body in np.unique(body_of)]
        names = [" + ".join(blocks[gases[n]].name for n in body) for body in bodies]
        return {
            "masses": [[name, body] for name, body in zip(names, bodies)],
            # along r pressure acts around an axis, too
            "momentum": "xyz"[: self.dimension - (self.symmetry > 0)],
            "energy": True,
            "entropy": entropy,
            "inertia": sum(masses),
            "heat_capacity": sum(m * solid.material.alpha for m, solid in zip(masses, solids)),
        }

    def _find_laws(self) -> None:
        """Number the laws of gases; gas at one place has one state, and so one law. InputError
        where gases of different laws meet, be it at an edge or a vertex alone.
        """
        self.gas_laws, self._law_of = list[Any](), dict[int, int]()
        gases = {k: block.material for k, block in enumerate(self.blocks) if block.kind == "fluid"}
        for k, gas in gases.items():
            law, every = gas.gas_law, self.gas_laws
            alike = [type(law) is type(of) and all(map(np.array_equal, law, of)) for of in every]
            self._law_of[k] = [*alike, True].index(True)
            self.gas_laws += [law] * (not any(alike))
        for members in self.members if len(self.gas_laws) > 1 else ():
            gases = [k for k, _ in members if k in self._law_of]
            if len({self._law_of[k] for k in gases}) > 1:
                place = place_text(self.places(members[0][0], np.array([members[0][1]])))
                names = " and ".join(str(self.blocks[k]) for k in gases)
                wrong = "are gases of different laws: expected one law, or a solid between them"
                raise InputError(f"{names} meet at {place}, and {wrong}")

    def law_at(self, members: Sequence[tuple[int, int]]) -> int:
        """The number of the law of the gas among (block, node) at one place; 0 if there is none."""
        return next((self._law_of[k] for k, _ in members if k in self._law_of), 0)

    def _check_symmetry(self) -> None:
        """InputError for what cannot be around an axis or a centre, or does not fit there."""
        d, symmetry = self.dimension, self.symmetry
        if symmetry not in (0, 1, 2)[: max(4 - d, 1)]:
            wanted = "expected 0, 1 in one or two dimensions, or 2 in one"
            raise InputError(f"symmetry is {described(symmetry)} in {d} dimensions: {wanted}")
        for (name, *face), met in self.faces.items():
            if isinstance(met, Centre) and not (symmetry and face == [d - 1, 0]):
                wanted = f"expected axis {d - 1}, side 0 of a problem with an axis or a centre"
                raise InputError(f"block '{name}', face {tuple(face)}: Centre(): {wanted}")
        for k, block in enumerate(self.blocks if symmetry else ()):
            X = block.places(mesh([np.arange(n) for n in block.shape])).reshape(d, -1)
            first, second = X.reshape(d, block.shape[-1], -1)[:, :2].swapaxes(0, 1)
            off = np.abs([*(second - first)[:-1], 3.0 * first[-1] - second[-1]]).sum(axis=0)
            wrong, centred, centre = "", self.centred(k), "the axis or centre that it reaches"
            if symmetry == 1 and centred and block.kind == "solid":
                wrong = "a solid cannot reach an axis, where its stresses would be wrong"
            elif block.periods[:, -1].any() or block.prestress is not None:
                wrong = "r grows by a period, or it has a prestress: expected neither"
            elif centred and block.material.force[-1] != 0.0:
                wrong = f"its force has no direction at {centre}: expected one along the axis"
            elif not X[-1].min() > 1e-9 * X[-1].max():
                wrong = f"r = {X[-1].min():.6g} at a node: expected r > 0, as off_axis makes it"
            elif centred and not np.all(off <= 0.1 * (second - first)[-1]):
                wrong = f"its first nodes are not half a spacing from {centre}: see off_axis"
            if wrong:
                raise InputError(f"{block}: {wrong}")

    def _hinge(self, name: str, place: Any, condition: Hinge) -> tuple[int, int]:
        """(block, node). InputError where no node of a solid's face is at the place."""
        solids = {block.name: k for k, block in enumerate(self.blocks) if block.kind == "solid"}
        X, d = np.atleast_1d(np.asarray(place, float)), self.dimension
        where = f"BlockProblem: point of {described(name)} at {place_text(X)}"
        if name not in solids or not isinstance(condition, Hinge) or X.shape != (d,):
            raise InputError(f"{where}: expected (name of a solid, {d} coordinates, Hinge())")
        nodes, places = self._known[solids[name]]
        apart = np.abs(places.T - X).max(axis=1)
        i = int(np.argmin(apart))
        if not apart[i] <= 1e3 * self.tolerance:
            near = place_text(places[:, i])
            raise InputError(f"{where}: no node of a face is there; the nearest is at {near}")
        return solids[name], int(nodes[i])
