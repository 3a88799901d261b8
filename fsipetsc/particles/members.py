"""Nodes of several blocks at one place are one particle: who belongs to it, and its conditions.

These follow from the faces of its members: faces where gas meets a solid, and faces with a
condition. A direction in which a particle cannot move freely is a *constraint*, with the sum of the
area vectors of its faces as normal (docs/derivation.md, Particles):

    SLIPS   gas slips along faces of solids, walls, or both that go on smoothly or around a convex
            edge; those that meet at a concave edge are constraints of their own
    ROLLS   a solid slips along a wall

One sum for a wall and a solid that goes on from it: two normals that differ by the error of the
differences would hold the gas in all directions. Where gas sticks to a solid the gas goes with it:
walls of the gas hold the two across themselves alone, as SLIPS, or not where a Roller does that.
"""

from collections import defaultdict
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block_problem import BlockFace, BlockProblem
from fsipetsc.blocks.conditions import Clamped
from fsipetsc.checks import place_text
from fsipetsc.errors import InputError

SLIPS, ROLLS = 0, 1
#: kinds of members
GAS, SOLID = 0, 1
#: facts of a particle that are no flags: see Particle.facts
NUMBERS = "moves_gas", "moves_solid", "heats_gas", "heats_solid", "count", "column", "law"
#: a wall that goes into the gas of another one by 30 degrees, or more steeply, is a wall of its own
CONCAVE = -0.499
#: rollers whose unit normals have at least this scalar product are one
SMOOTH = 0.8


class Face(NamedTuple):
    """A face at a node of a block, and its condition or the block it meets; a hinge has axis -1."""

    block: int
    node: int
    axis: int
    side: int
    met: Any

    @property
    def name(self) -> tuple[int, int, int]:
        return self.block, self.axis, self.side

    def said(self, problem: BlockProblem) -> str:
        """Such as "NoSlip of 'gas', axis 0, side 1,"."""
        if self.axis < 0:
            return "a Hinge"
        kind, block = type(self.met).__name__, problem.blocks[self.block].name
        return f"{kind} of '{block}', axis {self.axis}, side {self.side},"


class Particle:
    """The conditions of one particle.

    members: (block, node), ascending. sticks: gas and solid have one velocity. shares_heat: they
    have one temperature. one_T: several solid members have one. stores: temperatures depend on
    elastic energies. constraints: SLIPS or ROLLS, and the faces of each, first those at walls.

    faces: those whose conditions count: "wall" prescribes the velocity of the gas, "slip" that of a
    wall along which it slips, "clamp" the motion of the solid, "given_gas" and "given_solid" all
    unknowns, "warm_gas" and "warm_solid" a temperature, or all unknowns of the other one. held: all
    faces whose conditions hold gas or solid.
    """

    def __init__(self, problem: BlockProblem, members: list[tuple[int, int]], faces: Any) -> None:
        """faces: (block, node) -> its faces. InputError."""
        self._problem, self.members, self.faces = problem, members, dict[str, Face]()
        self.constraints, self.sticks, self.shares_heat = list[Any](), False, False
        at_solids, found = list[Face](), list[Face]()  # of a gas; with conditions
        for face in (face for member in members for face in faces[member]):
            gas = problem.blocks[face.block].material
            if not isinstance(face.met, BlockFace):
                found.append(face)
            elif gas.kind == "fluid" != problem.blocks[face.met.block].kind:
                at_solids.append(face)
                solid = problem.blocks[face.met.block].material
                self.sticks |= gas.mu > 0.0
                self.shares_heat |= gas.kappa > 0.0 and solid.kappa_e > 0.0
        for face in found:
            self._take_over(face, problem.blocks[face.block].kind == "fluid")
        self.held = [face for face in found if face.met.part or face.met.all_given]
        if hinges := problem.hinges.intersection(members):
            hinge = Face(*min(hinges), -1, 0, Clamped())
            self.held.insert(0, hinge)
            self.faces.setdefault("clamp", hinge)
        if "given_solid" in self.faces:
            self.faces.pop("clamp", None)
        for face in self.held if self.sticks and not self.holds else ():
            # the gas in the corner would be pressed together without end, and push the solid
            if face.met.part == "wall" and not face.met.slides:
                place = place_text(problem.places(members[0][0], np.array([members[0][1]]))[0])
                raise InputError(
                    f"{face.said(problem)} meets at {place} a solid that slides along it: no grid "
                    "converges there: let the wall be Slip or have a slip_length, or the solid be "
                    "clamped there"
                )
        self._constrain(at_solids, found)
        self._find_heat([problem.blocks[k].material for k, _ in members])

    @property
    def holds(self) -> bool:
        """Whether the motion of its solid is given."""
        return not self.faces.keys().isdisjoint(("clamp", "given_solid"))

    def moved_by(self, name: str) -> bool:
        """Whether the condition of this name, if there is one, moves by itself."""
        return name in self.faces and self.faces[name].met.moves

    def warms(self, name: str) -> bool:
        """Whether a temperature of this name is given by itself."""
        return name in self.faces and not self.faces[name].met.all_given

    def slides(self, face: Face) -> bool:
        """Whether the condition of a face holds what is there along the face's normal alone."""
        part = face.met.part
        return face.met.slides or part == "roller" or (self.sticks and part == "wall")

    def mover(self, gas: bool) -> Face | None:
        """The face whose condition says how its gas moves, or else its solid."""
        slides = self.moved_by("slip") and not self.moved_by("wall")
        walls = ("slip", "wall") if slides else ("wall", "slip")
        solid = "given_solid", "clamp"
        names = (*solid, *walls) if self.sticks else walls if gas else solid
        names = ("given_gas", *names) if gas else names
        return next((self.faces[name] for name in names if name in self.faces), None)

    @property
    def moves(self) -> bool:
        """Whether walls or given faces move it by themselves."""
        return any(map(self.moved_by, ("wall", "slip", "given_gas")))

    def facts(self) -> dict[str, int]:
        """What procedures are told of it. moves_…, heats_…: where the energy is booked by which
        gas or solid are moved and heated; column: where the mass of its gas is.
        """
        problem, faces, given = self._problem, self.faces, "given_solid" in self.faces
        gases = [k for k, block in enumerate(problem.blocks) if block.kind == "fluid"]
        held = not faces.keys().isdisjoint(("wall", "given_gas")) or (self.sticks and self.holds)

        def column(face: Face | None) -> int:
            return problem.column(face and face.name)

        return {
            **{name: name in faces for name in ("wall", "clamp", "given_gas", "given_solid")},
            **{name: getattr(self, name) for name in ("sticks", "shares_heat", "one_T", "moves")},
            "held": bool(self.held),
            "free_gas": not held,
            "free_solid": not self.holds,
            "placed": given or self.moved_by("clamp"),
            "warm_gas": self.warms("warm_gas"),
            "warm_solid": given or self.warms("warm_solid"),
            "moves_gas": column(self.mover(True)),
            "moves_solid": column(self.mover(False)),
            "heats_gas": column(faces.get("warm_gas")),
            "heats_solid": column(faces.get("given_solid", faces.get("warm_solid"))),
            "count": len(self.constraints),
            "column": next((gases.index(k) for k, _ in self.members if k in gases), 0),
            "law": problem.law_at(self.members),
        }

    def _take_over(self, face: Face, gas: bool) -> None:
        """Note what a face's condition prescribes; of two for the same the moving one. A roller is
        a constraint alone. Walls that hold the gas across themselves alone count as "slip".
        """
        met, faces = face.met, self.faces
        name = "" if met.part == "roller" else met.part
        name = "slip" if name == "wall" and (self.sticks or met.slides) else name
        if met.all_given:
            name = "given_gas" if gas else "given_solid"
        elif name in faces:
            moving, moved = (c.x or c.velocity for c in (met, faces[name].met))
            name = name if moving and not moved else ""
        warm = "warm_gas" if gas else "warm_solid"
        faces |= {taken: face for taken in (name, warm if met.warms else "") if taken}

    def _constrain(self, at_solids: list[Face], found: list[Face]) -> None:
        """Find the constraints; at_solids: faces of the gas, found: those with conditions."""
        problem = self._problem
        sliding = [(problem.blocks[face.block].kind, face) for face in found if self.slides(face)]
        slips, rolls = ([face for of, face in sliding if of == kind] for kind in ("fluid", "solid"))
        face_normal = cache(problem.face_normal)

        def one_wall(one: Face, other: Face) -> bool:
            """Unless one goes into the other's gas."""
            (n, beside), (m, along) = face_normal(*one[:4]), face_normal(*other[:4])
            return bool(min(*(beside @ m), *(along @ n)) > CONCAVE)

        def one_roller(one: Face, other: Face) -> bool:
            return bool(face_normal(*one[:4])[0] @ face_normal(*other[:4])[0] > SMOOTH)

        if self.sticks:
            slips = [one for one in slips if not any(one_roller(one, roll) for roll in rolls)]
        else:
            slips = [*at_solids, *slips]
        for kind, faces, one in (SLIPS, slips, one_wall), (ROLLS, rolls, one_roller):
            groups = defaultdict[Any, list[Face]](list)  # faces that are one with the same others
            for face in faces:
                groups[tuple(one(face, other) for other in faces)].append(face)
            for group in groups.values():
                walls_first = sorted(group, key=lambda face: isinstance(face.met, BlockFace))
                self.constraints.append((kind, walls_first))

    def _find_heat(self, materials: list[Any]) -> None:
        """Who has one temperature, and whether elastic energies matter to it."""
        faces, names = self.faces, ("given_gas", "given_solid", "warm_gas", "warm_solid")
        if "given_gas" in faces:
            faces.pop("warm_gas", None)
        known = [faces[name] for name in names if name in faces]
        if self.shares_heat and known:
            faces["warm_gas"] = faces["warm_solid"] = known[0]
        solids = [material for material in materials if material.kind == "solid"]
        elastic = any(solid.heat == "elastic" for solid in solids)
        conducts = all(solid.heat == "coupled" or solid.kappa_e > 0.0 for solid in solids)
        prescribed = self.warms("warm_solid") or "given_solid" in faces
        self.one_T = len(solids) > 1 and (conducts or prescribed)
        self.stores = elastic and (self.one_T or prescribed or self.shares_heat)


def particles_of(problem: BlockProblem) -> list[Particle]:
    """All particles of a problem, in the order of their first members. InputError, on all ranks."""
    met: dict[tuple[int, int], list[Face]] = defaultdict(list)
    for k in range(len(problem.blocks)):
        for (axis, side), stands in problem.kinds[k].items():
            for n in problem.blocks[k].face_nodes(axis, side).tolist():
                met[k, n].append(Face(k, n, axis, side, stands))
    return [Particle(problem, members, met) for members in problem.members]
