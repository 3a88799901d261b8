"""Nodes of several blocks at one place are one particle: who belongs to it, and what holds it.

All nodes on faces of blocks are *members*, (block, node); members at one place are a *particle*. What a particle is subject to
follows from the faces of its members: faces where gas meets a solid, and faces with a condition. A direction in which it
cannot move freely is a *constraint*, with a normal that is the sum of the area vectors of some faces:

    SLIDES   gas slips along a solid:          N . (a_gas - a_solid) given
    WALL     gas slips along a wall:           N . a_gas             given
    ROLLS    a solid slips along a wall:       N . a_solid  =  0

Sticking gas and what is clamped or given needs no normal. Source: the constraints of Gauss's principle, one particle at a
time; at corners of bodies the normals of all faces at the body are summed.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blocks.conditions import Clamped, Given, NoSlip, Open, Roller, Slip
from fsipetsc.blocks.problem import BlockProblem, Meeting

SLIDES, WALL, ROLLS = 0, 1, 2
#: unit normals with at least this scalar product belong to one smooth wall
SMOOTH = 0.8

Array = NDArray[Any]
#: (number of the member in its particle, axis, side)
Face = tuple[int, int, int]


@dataclass
class Particle:
    """What holds one particle.

    members: (block, node), ascending. constraints: (kind, faces of members). sticks: gas and solid have one velocity.
    wall, slip, clamp, given_gas, given_solid: the condition that prescribes the velocity of the gas, that of a wall along
    which it slips, the motion of the solid, all unknowns; None where there is none. warm: a condition that gives a
    temperature. shares_heat: gas and solid have one temperature. shares_energy: solid members have one energy per mass, as
    one temperature asks for where stresses heat.
    """

    members: list[tuple[int, int]]
    constraints: list[tuple[int, list[Face]]] = field(default_factory=list)
    sticks: bool = False
    shares_heat: bool = False
    shares_energy: bool = False
    wall: Any = None
    slip: Any = None
    clamp: Any = None
    given_gas: Any = None
    given_solid: Any = None
    warm: Any = None

    @property
    def moves(self) -> bool:
        """Whether walls or given faces move it by themselves."""
        return any(getattr(c, "x", None) is not None for c in (self.wall, self.slip, self.given_gas))


def particles_of(problem: BlockProblem) -> list[Particle]:
    """All particles of a problem, in the order of their first members."""
    met = _faces_of_members(problem)
    groups: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for particle, block, node in zip(*(numbers.tolist() for numbers in problem.members), strict=True):
        groups[particle].append((block, node))
    hinged = _hinged(problem)
    return [_particle(problem, members, met, hinged) for members in groups.values()]


def _faces_of_members(problem: BlockProblem) -> dict[tuple[int, int], list[tuple[int, int, Any]]]:
    """(block, node) -> [(axis, side, what the face meets or its condition)]."""
    found: dict[tuple[int, int], list[tuple[int, int, Any]]] = defaultdict(list)
    for k in range(len(problem.blocks)):
        for (axis, side), met in problem.faces_of(k).items():
            for n in problem.face_nodes(k, axis, side).tolist():
                found[k, n].append((axis, side, met))
    return found


def _hinged(problem: BlockProblem) -> set[tuple[int, int]]:
    """The nodes nearest to the points that are held."""
    found = set()
    for name, place, _ in problem.points:
        k = problem.number(name)
        nodes = np.unique(np.concatenate([problem.face_nodes(k, *face) for face in problem.faces_of(k)]))
        distance = np.linalg.norm(problem.places(k, nodes) - np.asarray(place), axis=1)
        found.add((k, int(nodes[np.argmin(distance)])))
    return found


def _particle(
    problem: BlockProblem, members: list[tuple[int, int]], faces: Any, hinged: set[tuple[int, int]]
) -> Particle:
    particle = Particle(members)
    slides: list[Face] = []
    walls: list[tuple[Face, str]] = []
    rolls: list[tuple[Face, str]] = []
    for number, (k, n) in enumerate(members):
        gas = problem.blocks[k].kind == "fluid"
        for axis, side, met in faces[k, n]:
            face = number, axis, side
            if isinstance(met, Meeting):
                if gas and problem.blocks[met.block].kind == "solid":
                    _meet_solid(particle, problem.blocks[k], problem.blocks[met.block], face, slides)
            elif isinstance(met, Slip):
                walls.append((face, met.name))
                particle.slip = _moving_first(particle.slip, met)
            elif isinstance(met, Roller):
                rolls.append((face, ""))
            else:
                _take_over(particle, met, gas)
    if particle.clamp is None and hinged.intersection(members):
        particle.clamp = Clamped()
    solids = [problem.blocks[k].material for k, _ in members if problem.blocks[k].kind == "solid"]
    particle.shares_energy = all(solid.heat == "coupled" for solid in solids)
    if not particle.sticks:
        particle.constraints += [(SLIDES, group) for group in _corners(slides)]
    same_wall = _SameWall(problem, members)
    particle.constraints += [(WALL, group) for group in _grouped(walls, same_wall)]
    particle.constraints += [(ROLLS, group) for group in _grouped(rolls, same_wall)]
    return particle


def _meet_solid(particle: Particle, gas: Any, solid: Any, face: Face, slides: list[Face]) -> None:
    """Viscous gas sticks to the solid, else it slides; they have one temperature where both conduct."""
    if gas.material.mu > 0.0:
        particle.sticks = True
    else:
        slides.append(face)
    if gas.material.kappa > 0.0 and solid.material.kappa_e > 0.0:
        particle.shares_heat = True


def _take_over(particle: Particle, met: Any, gas: bool) -> None:
    """What a condition without a normal holds."""
    if isinstance(met, NoSlip):
        particle.wall = _moving_first(particle.wall, met)
    elif isinstance(met, Clamped):
        particle.clamp = _moving_first(particle.clamp, met)
    elif isinstance(met, Given):
        name = "given_gas" if gas else "given_solid"
        setattr(particle, name, met)
    if getattr(met, "T", None) is not None and not isinstance(met, Open):
        particle.warm = met


def _moving_first(known: Any, other: Any) -> Any:
    """Of two conditions at one particle that which prescribes a motion."""
    if known is None or (other.x is not None and known.x is None):
        return other
    return known


def _corners(faces: list[Face]) -> list[list[Face]]:
    """Faces of several members are summed to one normal; those of one member, in a notch, are constraints of their own."""
    groups: list[list[Face]] = []
    for face in faces:
        for group in groups:
            if all(face[0] != other[0] for other in group):
                group.append(face)
                break
        else:
            groups.append([face])
    return groups


def _grouped(faces: list[tuple[Face, str]], same_wall: _SameWall) -> list[list[Face]]:
    """Faces of one wall are one constraint."""
    groups: list[list[tuple[Face, str]]] = []
    for face in faces:
        for group in groups:
            if any(same_wall(face, other) for other in group):
                group.append(face)
                break
        else:
            groups.append([face])
    return [[face for face, _ in group] for group in groups]


class _SameWall:
    """Whether two faces at a particle belong to one wall: by their names, if they have any; else if it goes on smoothly, or
    around a corner that juts into the gas.
    """

    def __init__(self, problem: BlockProblem, members: list[tuple[int, int]]) -> None:
        self._problem, self._members = problem, members

    def __call__(self, one: tuple[Face, str], other: tuple[Face, str]) -> bool:
        if one[1] or other[1]:
            return one[1] == other[1]
        if one[0][0] == other[0][0]:
            return False
        n, place, _ = self._of(one[0])
        m, _, within = self._of(other[0])
        recedes = float((within - place) @ n) > 1e-6 * float(np.linalg.norm(within - place))
        return float(n @ m) > SMOOTH or recedes

    def _of(self, face: Face) -> tuple[Array, Array, Array]:
        """(outward unit normal, place of the node, mean place of its neighbours within the face), of the reference map."""
        number, axis, side = face
        k, node = self._members[number]
        block, d = self._problem.blocks[k], self._problem.dimension
        index = np.array(np.unravel_index(node, block.shape[::-1])[::-1])
        place, steps, around = self._place(k, index), [], []
        for along in range(d):
            ends = []
            for step in (-1, 1):
                other = index.copy()
                other[along] += step
                if block.periodic[along] or 0 <= other[along] < block.shape[along]:
                    ends.append(self._place(k, other) - place if step > 0 else place - self._place(k, other))
                    if along != axis:
                        around.append(place + step * ends[-1])
            steps.append(sum(ends) / len(ends))
        normal = np.linalg.inv(np.array(steps))[:, axis] * (1.0 if side else -1.0)
        mean = sum(around) / len(around) if around else place
        return normal / np.linalg.norm(normal), place, mean

    def _place(self, k: int, index: Array) -> Array:
        return self._problem.positions(k, [(int(i), int(i) + 1) for i in index])[:, 0]
