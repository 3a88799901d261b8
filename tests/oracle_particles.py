"""Particles of the oracle of blocks: at one place, and their conditions (docs/derivation.md)."""

from collections import defaultdict, namedtuple
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from oracle_formulas import Clamped, Given, NoSlip, Open, Roller, Row, Slip, rate_of
from oracle_volume import Volume

#: two faces are walls of their own where one goes into the other's gas by 30 degrees or more
CONCAVE = -0.499
STEP = 1e-5  # of differences of a wall's velocity in time
#: one face at one node, with its condition (None where it meets another face)
Face = namedtuple("Face", "block axis side node condition")


@dataclass
class Particle:
    """All nodes at one place: (block, node)."""

    gas: list = field(default_factory=list)
    solid: list = field(default_factory=list)
    contact: list = field(default_factory=list)  # faces of gases that meet a solid
    outer: list = field(default_factory=list)  # faces with a condition
    slips: list = field(default_factory=list)  # groups of faces of one slip constraint each


class Particles(Volume):
    """Blocks, and the nodes of their faces put together by place."""

    def __init__(self, problem, kappa=0):
        super().__init__(problem, kappa)
        self.reference = [self.metrics(k, b.X) for k, b in enumerate(self.blocks)]
        size = 1e-7 * max(np.ptp(b.X) for b in self.blocks)
        by_place, by_face = defaultdict(Particle), defaultdict(list)
        for k, b in enumerate(self.blocks):
            for axis, side in product(range(self.d), (0, 1)):
                if self.periodic(k, axis):
                    continue
                index = np.indices(b.X.shape[1:]).take(-side, axis + 1)
                nodes = list(map(tuple, index.reshape(self.d, -1).T.tolist()))
                # whole numbers, whose bounds are no places that anyone would choose
                places = (self.place(k, node) / size + 0.3819660113 for node in nodes)
                keys = [tuple(np.floor(place).astype(int)) for place in places]
                by_face[frozenset(keys)].append((k, axis, side, nodes, keys))
                for node, key in zip(nodes, keys):
                    p = self.of_node[k, node] = by_place[key]
                    members = p.gas if b.material.kind == "gas" else p.solid
                    if (k, node) not in members:
                        members.append((k, node))
        for faces in by_face.values():
            kinds = [self.blocks[f[0]].material.kind for f in faces]
            assert len(faces) <= 2
            for (k, axis, side, nodes, keys), kind in zip(faces, kinds):
                owner = self.names[k], axis, side
                condition = problem.faces(owner) if len(faces) == 1 else None
                for node, key in zip(nodes, keys):
                    face = Face(k, axis, side, node, condition)
                    if condition is not None:
                        by_place[key].outer.append(face)
                    elif kind == "gas" and "solid" in kinds:
                        by_place[key].contact.append(face)
        self.particles = list(by_place.values())
        for p in self.particles:
            self._group_slips(p)

    def place(self, k, node):
        return self.blocks[k].X[(slice(None), *node)]

    def normal(self, face, a):
        """Outward area vector at a node, from metrics a (or their rate)."""
        k, axis, side, node = face[:4]
        area = self.W[k][node] / self.axes[k][axis].weight[node[axis]]
        return (2 * side - 1) * area * a[(axis, slice(None), *node)]

    def _sticks(self, p):
        return any(self.blocks[f.block].material.mu > 0.0 for f in p.contact)

    def _slides(self, f):
        """Whether gas slips along a wall; without viscosity it does along any, but on a line."""
        free = self.d > 1 and getattr(self.blocks[f.block].material, "mu", None) == 0.0
        return isinstance(f.condition, (Slip, NoSlip) if free else Slip)

    def _group_slips(self, p):
        """Faces along which the gas slips, at walls or solids, are one constraint unless they meet
        at a concave edge. Where gas sticks to a solid, a roller of it holds both in the place of a
        wall along the same plane."""
        sticks = self._sticks(p)
        found = [] if sticks else [*p.contact]
        rolls = [self._directions(f)[0] for f in p.outer if isinstance(f.condition, Roller)]
        for f in filter(self._slides, p.outer):
            if not (sticks and any(self._directions(f)[0] @ n > 0.8 for n in rolls)):
                found.append(f)
        groups = []
        for face in [(f, *self._directions(f)) for f in found]:
            fits = [g for g in groups if all(self._one_wall(face, other) for other in g)]
            (fits[0] if fits else groups.append([]) or groups[-1]).append(face)
        p.slips = [[face[0] for face in group] for group in groups]

    @staticmethod
    def _one_wall(a, b):
        (_, normal, inward), (_, other_normal, other_inward) = a, b
        return min(inward @ other_normal, other_inward @ normal) > CONCAVE

    def _directions(self, f):
        """Unit normal of a face at a node, and the direction into the face (0 in its middle)."""
        k, axis, _, node = f[:4]
        normal, inward = self.normal(f, self.reference[k]), np.zeros(self.d)
        for j in range(self.d):
            for step in (-1, 1) if j != axis and not self.periodic(k, j) else ():
                other = [i + step * (j == m) for m, i in enumerate(node)]
                if 0 <= other[j] < self.blocks[k].X.shape[1 + j]:
                    toward = self.place(k, tuple(other)) - self.place(k, node)
                    inward += toward / np.linalg.norm(toward)
        return normal / np.linalg.norm(normal), inward / max(np.linalg.norm(inward), 1e-3)

    def kind(self, face):
        return self.blocks[face.block].material.kind

    def conducts(self, p):
        """Whether gas and solid of a particle have one temperature."""
        members = p.gas[:1] + p.solid[:1]
        return len(members) == 2 and all(self.blocks[k].material.kappa > 0.0 for k, _ in members)

    def prescribed_T(self, p, t):
        """(T, T_t) or None, of the gas and of the solid."""
        found = {"gas": None, "solid": None}
        for f in p.outer:
            T = None if isinstance(f.condition, Open) else getattr(f.condition, "T", None)
            if T is not None:
                X = self.place(f.block, f.node)
                found[self.kind(f)] = T(X, t) if callable(T) else T, rate_of(T, X, t)
        both = found["gas"] or found["solid"]
        return (both, both) if self.conducts(p) else (found["gas"], found["solid"])

    def apart(self, p):
        """Whether each member of a solid keeps its own temperature: none is conducted or given."""
        solids = [self.blocks[k].material for k, _ in p.solid]
        free = self.given(p, "solid") is None and self.prescribed_T(p, 0.0)[1] is None
        return free and all(m.heat == "elastic" and m.kappa == 0.0 for m in solids)

    def given(self, p, kind):
        """values(t) of the face at which the unknowns of a kind are given, or None."""
        for f in p.outer:
            if isinstance(f.condition, Given) and self.kind(f) == kind:
                return lambda t, f=f: f.condition.values(self.place(f.block, f.node), t)
        return None

    def rows(self, p, grids, t, level, u, v):
        """Constraints of places (level 0, of solids alone), velocities (1), accelerations (2)."""
        zero, unit, found = np.zeros(self.d), np.eye(self.d), []
        if self._sticks(p) and level > 0:
            found += [Row(e, -e, e @ v, -e @ v, 0.0) for e in unit]
        for group in p.slips if level > 0 else ():
            found.append(self._slip_row(p, group, grids, t, level, u, v))
        for f in p.outer:
            motion = self._motion(f, t)
            w, value = motion[1], motion[level]
            if isinstance(f.condition, NoSlip) and level > 0 and not self._slides(f):
                found += [Row(e, zero, e @ w, 0.0, e @ value) for e in unit]
            elif isinstance(f.condition, Clamped):
                found += [Row(zero, e, 0.0, e @ w, e @ value) for e in unit]
            elif isinstance(f.condition, Roller):
                n = self.normal(f, self.solids[f.block][0])
                found.append(Row(zero, n, 0.0, 0.0, 0.0))
        return found

    def _motion(self, face, t):
        """Displacement, velocity, acceleration of a wall or clamp."""
        motion, X = getattr(face.condition, "motion", None), self.place(face.block, face.node)
        if motion is None:
            return np.zeros((3, self.d))
        w, before, after = (rate_of(motion, X, t + step) for step in (0.0, -STEP, STEP))
        return motion(X, t) - X, w, (after - before) / (2.0 * STEP)

    def _slip_row(self, p, group, grids, t, level, u, v):
        """sum n.(u - w) = 0 over faces of a group, w of the solid or wall; or its derivative."""
        N, on_solid, value, power = np.zeros(self.d), np.zeros(self.d), 0.0, 0.0
        for f in group:
            n, n_t = self.normal(f, grids[f.block].a), self.normal(f, grids[f.block].a_t)
            N = N + n
            if f in p.contact:
                on_solid, turned, power = on_solid - n, n_t @ (u - v), power + n @ v
            else:
                _, w, w_t = self._motion(f, t)
                value = value + (n @ w, n @ w_t)[level - 1]
                turned, power = n_t @ (u - w), power + n @ w
            value -= turned if level == 2 else 0.0
        return Row(N, on_solid, power, on_solid @ v, value)
