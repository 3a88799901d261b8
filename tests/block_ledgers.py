"""Runs of blocks without files, and their ledgers; problems of gas and solid with smooth data."""

import numpy as np
from mpi4py import MPI

from fsipetsc import Block, BlockProblem, Fluid
from fsipetsc.blocks.conditions import Roller, Slip
from fsipetsc.blocks.maps import nodes, rectangle
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.particles.members import particles_of
from fsipetsc.particles.prescribed import Prescribed
from fsipetsc.scheme.plan import DT, NEXT, TIME
from fsipetsc.stepping.block_state import BlockState
from fsipetsc.stepping.saved import gained

#: cells along an axis
N = 7
#: slip walls and rollers
CLOSED = {"gas": Slip(), "solid": Roller()}


class Steps(BlockState):
    """A problem in time by RK4, on one rank. came: what has come in, column by column.

    apart: each stage is a call of its own, as where data depend on time."""

    def __init__(self, problem, order=2, apart=False, **options):
        super().__init__(MPI.COMM_SELF, problem, {"fsi_order": order, **options})
        self.asked |= apart
        self.t, self._at = 0.0, gained(problem)
        self.came = np.zeros(self.layout.auxiliary)
        self.set_initial()
        self.finish()

    def step(self, dt, steps=1):
        for _ in range(steps):
            self.batch[[TIME, DT, NEXT]] = self.t, dt, self.t + dt
            super().step()
            self.t += dt
            self.came += self.latest_numbers[-self.came.size :]

    def integrals(self):
        """Mass of all gas, momentum, energy after the last step."""
        found = self.latest
        mass = found["mass"].sum() if "mass" in found.dtype.names else 0.0
        momentum = (found[f"momentum_{x}"] for x in "xyz"[: self.problem.dimension])
        return np.array([mass, *momentum, found["energy"]])

    def gained(self):
        """The same, of what has come in."""
        mass = self.of_faces("mass_in").sum() if "mass_in" in self._at else 0.0
        impulse = (self.of_faces(f"impulse_{x}")[0] for x in "xyz"[: self.problem.dimension])
        return np.array([mass, *impulse, self.of_faces("energy_in")[0]])

    def lost(self):
        """Of the kinetic and elastic energy of solids, where that is known."""
        return self.of_faces("lost_energy")[0] if "lost_energy" in self._at else 0.0

    def face_energies(self):
        """Name of a face -> energy that has come in there, heat among it."""
        both = zip(self.of_faces("energy_face"), self.of_faces("heat_face"), strict=True)
        return dict(zip(self.problem.face_names, both, strict=True))

    def of_faces(self, name):
        """What has come in, by the name of its columns."""
        return self.came[self._at[name]]


def complete(state, t, y):
    """Let a vector obey all conditions at time t."""
    state.set_data(t)
    state.project(y)


def rates(state, t, y, f):
    """f = dy/dt of a completed vector."""
    state.set_data(t)
    state.right_hand_side(y, f)


def check_motion(problem, step):
    """Velocities that are given are those of places, and fit where faces meet, at t = 1."""
    particles = particles_of(problem)
    Prescribed(problem, particles, np.arange(len(particles)), lambda: step).check_motion(1.0)


def slab(material, initial, ends, cells):
    """[0, 1] in one dimension."""
    block = Block("slab", material, rectangle(0.0, 1.0), (cells,), initial)
    return BlockProblem((block,), {("slab", 0, side): ends[side] for side in (0, 1)})


def gas(d=2, mu=0.0, force=0.0):
    return Fluid(mu, 0.03, 1.4, 1.0, force=(force,) * d if d > 1 else force)


def solid(d=2, heat="elastic", force=0.0):
    force = (force,) * d if d > 1 else force
    return ElasticSolid(1.0, 2.0, 0.05, 2.0, 1.5, 0.3, "log", heat, force=force)


def swirling(*X):
    d = len(X)
    wave = [0.2 * np.sin(3.0 * X[c] + 2.0 * X[-1] + c) for c in range(d)]
    return [1.0 + 0.2 * np.cos(2.0 * sum(X)), *wave, 1.0 + 0.1 * np.sin(3.0 * X[0] + 1.0)]


def bent(*X):
    d = len(X)
    v = [0.1 * np.cos(2.0 * X[0] + 3.0 * X[-1] + c) for c in range(d)]
    x = [X[c] + 0.02 * np.sin(2.0 * X[c - 1] + c) for c in range(d)]
    return [*v, 1.1 + 0.1 * np.sin(2.0 * X[0] + X[-1]), *x]


def conditions_of(blocks, faces):
    """Of faces that meet no other; faces: by (name, axis, side), (kind, axis, …) or kind."""
    sides = [(b, *face) for b in blocks for face in b.faces]
    middles = [b.face_positions(k, s).mean(axis=1) for b, k, s in sides]
    found = {}
    for (b, *face), middle in zip(sides, middles):
        if sum(np.abs(middle - other).max() < 1e-9 for other in middles) == 1:
            kind = b.name.split()[0]
            keys = (b.name, *face), (kind, *face), (kind, face[0]), kind
            found[keys[0]] = next(faces[key] for key in keys if key in faces)
    return found


def problem_of(shape, faces, fluid, plate, points=(), **options):
    """On a shape of block_shapes; options: of blocks of gas and of solids; jumps."""
    blocks = []
    for name, (X, _) in shape.items():
        kind = name.split()[0]
        material, initial = (fluid, swirling) if kind == "gas" else (plate, bent)
        cells, d = tuple(n - 1 for n in X.shape[1:]), len(X)
        more = {"initial": initial, **options.get(kind, {})}
        blocks.append(Block(name, material, nodes(X.transpose(*range(d, 0, -1), 0)), cells, **more))
    conditions = conditions_of(blocks, faces)
    return BlockProblem(tuple(blocks), conditions, options.get("jumps"), points=points)


def moved(*X_and_t):
    *X, t = X_and_t
    return [x + 0.1 * np.sin(3.0 * t + c) * (1.0 + X[0]) for c, x in enumerate(X)]
