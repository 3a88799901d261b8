"""Nodes of several blocks at one place are one particle: who belongs to it, and its conditions.

All nodes on faces of blocks are *members*, (block, node); members at one place are a *particle*.
What a particle is subject to follows from the faces of its members: faces where gas meets a solid,
and faces with a condition. A direction in which it cannot move freely is a *constraint*. With the
area vectors n of faces, those of gas pointing out of it, a the accelerations,

    SLIPS   gas slips along faces of solids, walls, or both that go on smoothly or around a convex
            edge: sum_solids n . (a_gas - a_solid) + sum_walls n . (a_gas - a_wall) given
    ROLLS   a solid slips along a wall: sum n . a_solid = 0

One sum for a wall and a solid that goes on from it: two normals that differ by the error of the
differences would hold the gas in all directions. Faces that meet at a concave edge, in a notch, are
constraints of their own. Sticking gas and what is clamped or given needs no normal.

Where gas sticks to a solid the solid decides, and the gas there goes with it: walls of the gas
hold the two across themselves alone, as SLIPS, and not at all where a Roller of the solid does
that. Otherwise a solid that slides beside a wall with friction would be pinned at its edge.
Source: docs/derivation.md, Particles.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blocks.block_problem import BlockProblem, Meeting
from fsipetsc.blocks.conditions import Clamped
from fsipetsc.blocks.maps import place_text
from fsipetsc.errors import InputError

SLIPS, ROLLS = 0, 1
#: kinds of members
GAS, SOLID = 0, 1
#: a wall that goes into the gas of another one more steeply than by 30 degrees is a wall of its own
CONCAVE = -0.5
#: rollers whose unit normals have at least this scalar product are one
SMOOTH = 0.8

Array = NDArray[Any]


class Face(NamedTuple):
    """A face at a node: number of the member in its particle, its block, axis and side, and what it
    meets or its condition. Of a hinge, which is at no face, the axis is -1.
    """

    member: int
    block: int
    axis: int
    side: int
    met: Any

    @property
    def name(self) -> tuple[int, int, int]:
        """(block, axis, side)."""
        return self[1:4]

    def said(self, problem: BlockProblem) -> str:
        """Such as "NoSlip of 'gas', axis 0, side 1,"."""
        if self.axis < 0:
            return "a Hinge"
        kind, block = type(self.met).__name__, problem.blocks[self.block].name
        return f"{kind} of '{block}', axis {self.axis}, side {self.side},"


class Constraint(NamedTuple):
    """kind: SLIPS or ROLLS. walls: faces at walls; solids: faces of the gas at solids."""

    kind: int
    walls: list[Face]
    solids: list[Face]


@dataclass
class Particle:
    """The conditions of one particle.

    members: (block, node), ascending. sticks: gas and solid have one velocity. shares_heat: they
    have one temperature. one_T: several solid members have one temperature. stores: that takes an
    elastic energy into account. The others are conditions, None where there is none: wall
    prescribes the velocity of the gas, slip that of a wall along which it slips, clamp the motion
    of the solid, given_gas and given_solid all unknowns, warm_gas and warm_solid a temperature.
    faces: by these names the face, (block, axis, side), whose condition it is. asked: those of all
    conditions that hold gas or solid, if they are several.
    """

    members: list[tuple[int, int]]
    constraints: list[Constraint] = field(default_factory=list)
    sticks: bool = False
    shares_heat: bool = False
    one_T: bool = False
    stores: bool = False
    wall: Any = None
    slip: Any = None
    clamp: Any = None
    given_gas: Any = None
    given_solid: Any = None
    warm_gas: Any = None
    warm_solid: Any = None
    faces: dict[str, tuple[int, int, int]] = field(default_factory=dict)
    asked: list[Face] = field(default_factory=list)

    def slides(self, face: Face) -> bool:
        """Whether the condition of a face holds what is there along the face's normal alone."""
        part = face.met.part
        return face.met.slides or part == "roller" or (self.sticks and part == "wall")

    def wall_normal(self, problem: BlockProblem) -> Array:
        """The unit normal of its wall."""
        block, *face = self.faces["wall"]
        node = next(n for k, n in self.members if k == block)
        return problem.face_normal(block, node, *face)[0]

    def mover(self, gas: bool) -> str:
        """The name of the condition that says how its gas moves, or else its solid; "" if none."""
        slides = self.slip and self.slip.moves and not (self.wall and self.wall.moves)
        walls = ("slip", "wall") if slides else ("wall", "slip")
        solid = "given_solid", "clamp"
        names = (*solid, *walls) if self.sticks else walls if gas else solid
        names = ("given_gas", *names) if gas else names
        return next((name for name in names if getattr(self, name) is not None), "")

    @property
    def moves(self) -> bool:
        """Whether walls or given faces move it by themselves."""
        return any(c is not None and c.moves for c in (self.wall, self.slip, self.given_gas))


def particles_of(problem: BlockProblem) -> list[Particle]:
    """All particles of a problem, in the order of their first members. InputError, on all ranks."""
    met: dict[tuple[int, int], list[tuple[int, int, Any]]] = defaultdict(list)
    for k in range(len(problem.blocks)):
        for (axis, side), stands in problem.faces_of(k).items():
            for n in problem.face_nodes(k, axis, side).tolist():
                met[k, n].append((axis, side, stands))
    return [_particle(problem, members, met) for members in problem.members]


def _particle(problem: BlockProblem, members: list[tuple[int, int]], faces: Any) -> Particle:
    """faces: (block, node) -> [(axis, side, what the face meets or its condition)]."""
    particle, blocks = Particle(members), problem.blocks
    at_solids: list[Face] = []  # of a gas
    found: list[Face] = []  # with conditions
    for number, (k, n) in enumerate(members):
        gas = blocks[k].material if blocks[k].kind == "fluid" else None
        for axis, side, met in faces[k, n]:
            face = Face(number, k, axis, side, met)
            if not isinstance(met, Meeting):
                found.append(face)
            elif gas and blocks[met.block].kind == "solid":
                at_solids.append(face)
                particle.sticks |= gas.mu > 0.0
                conducts = gas.kappa > 0.0 and blocks[met.block].material.kappa_e > 0.0
                particle.shares_heat |= conducts
    sticks, hinges = particle.sticks, sorted(problem.hinges.intersection(members))
    for face in found:
        _take_over(particle, face.met, blocks[face.block].kind == "fluid", face.name)
    held = [Face(members.index(at), at[0], -1, 0, Clamped()) for at in hinges[:1]]
    particle.clamp = particle.clamp or (held[0].met if held else None)
    held += [face for face in found if face.met.holds]
    if any(face.met != held[0].met for face in held):
        particle.asked = held
    if sticks and not particle.clamp and not particle.given_solid:
        _check_sliding(problem, members[0], held)
    sliding = [face for face in found if particle.slides(face)]
    slips = [face for face in sliding if blocks[face.block].kind == "fluid"]
    rolls = [face for face in sliding if blocks[face.block].kind == "solid"]
    slips = slips if sticks else [*at_solids, *slips]
    directions = {}  # outward unit normal, and unit vector from the node into the face
    for face in [*slips, *rolls] if len(slips) + len(rolls) > 1 else ():
        normal, place, within = problem.face_normal(*members[face.member], face.axis, face.side)
        into = within - place  # 0 in the middle of a face, where no other wall is
        directions[face.name] = normal, into / (np.linalg.norm(into) or 1.0)

    def one_wall(one: Face, other: Face) -> bool:
        """By the names of walls if both have one; else unless one goes into the other's gas."""
        names = [getattr(face.met, "name", "") for face in (one, other)]
        if all(names):
            return names[0] == names[1]
        (n, into), (m, along) = directions[one.name], directions[other.name]
        return bool(min(into @ m, along @ n) > CONCAVE)

    def one_roller(one: Face, other: Face) -> bool:
        return bool(directions[one.name][0] @ directions[other.name][0] > SMOOTH)

    if sticks:
        slips = [one for one in slips if not any(one_roller(one, roll) for roll in rolls)]
    for kind, faces_of, one in (SLIPS, slips, one_wall), (ROLLS, rolls, one_roller):
        for group in _grouped(faces_of, one):
            at_solid = [face for face in group if isinstance(face.met, Meeting)]
            walls = [face for face in group if not isinstance(face.met, Meeting)]
            particle.constraints.append(Constraint(kind, walls, at_solid))
    _heat_conditions(particle, [blocks[k].material for k, _ in members])
    return particle


def _check_sliding(problem: BlockProblem, member: tuple[int, int], held: list[Face]) -> None:
    """InputError where a solid slides along a wall to which the gas beside sticks: the gas in the
    corner would be pressed together without end, on any grid, and push the solid.
    """
    for face in held:
        if face.met.part == "wall" and not face.met.slides:
            place = place_text(problem.places(member[0], np.array([member[1]]))[0])
            raise InputError(
                f"{face.said(problem)} meets at {place} a solid that slides along it: no grid "
                "converges there: let the wall be Slip or have a slip_length, or the solid be "
                "clamped there"
            )


def _take_over(particle: Particle, met: Any, gas: bool, face: tuple[int, int, int]) -> None:
    """What a condition says beside a direction; of two of a kind that which prescribes motion."""
    name = "" if met.part == "roller" else met.part
    name = "slip" if name == "wall" and (particle.sticks or met.slides) else name
    if met.all_given:
        name = "given_gas" if gas else "given_solid"
    elif name and (known := getattr(particle, name)):
        moving, moved = (c.x or c.velocity for c in (met, known))
        name = name if moving and not moved else ""
    warm = "warm_gas" if gas else "warm_solid"
    for taken in (name, warm if met.warms else ""):
        if taken:
            setattr(particle, taken, met)
            particle.faces[taken] = face


def _heat_conditions(particle: Particle, materials: list[Any]) -> None:
    """Who has one temperature, and whether elastic energies matter to it."""
    if particle.given_gas is not None:
        particle.warm_gas = None
    if particle.shares_heat:
        warm, faces = particle.warm_gas or particle.warm_solid, particle.faces
        face = faces.get("warm_gas", faces.get("warm_solid"))
        given = [faces[name] for name in ("given_gas", "given_solid") if name in faces]
        if given:  # all unknowns, of which the other side takes the temperature
            warm, face = None, given[0]
        particle.warm_gas = particle.warm_solid = warm
        if face is not None:
            faces["warm_gas"] = faces["warm_solid"] = face
    solids = [material for material in materials if material.kind == "solid"]
    elastic = any(solid.heat == "elastic" for solid in solids)
    conducts = all(solid.heat == "coupled" or solid.kappa_e > 0.0 for solid in solids)
    prescribed = particle.warm_solid is not None or particle.given_solid is not None
    particle.one_T = len(solids) > 1 and (conducts or prescribed)
    particle.stores = elastic and (particle.one_T or prescribed or particle.shares_heat)


def _grouped(faces: list[Any], one: Any) -> list[list[Any]]:
    """Faces of which each is one with all others of its group."""
    groups: list[list[Any]] = []
    for face in faces:
        for group in groups:
            if all(one(face, other) for other in group):
                group.append(face)
                break
        else:
            groups.append([face])
    return groups
