"""Problems whose ledgers are checked: gas and solid with smooth data on the shapes of
block_shapes.
"""

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Roller, Slip
from fsipetsc.blocks.maps import nodes
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid

#: cells along an axis
N = 7


def gas(d=2, mu=0.0, force=0.0):
    return Fluid(mu, 0.03, 1.4, 1.0, force=(force,) * d if d > 1 else force)


def solid(d=2, heat="elastic", force=0.0, kappa=0.05):
    force = (force,) * d if d > 1 else force
    return ElasticSolid(1.0, 2.0, kappa, 2.0, 1.5, 0.3, "log", heat, force=force)


def swirling(*X):
    d = len(X)
    wave = [0.2 * np.sin(3.0 * X[c] + 2.0 * X[-1] + c) for c in range(d)]
    return [1.0 + 0.2 * np.cos(2.0 * sum(X)), *wave, 1.0 + 0.1 * np.sin(3.0 * X[0] + 1.0)]


def bent(*X):
    d = len(X)
    v = [0.1 * np.cos(2.0 * X[0] + 3.0 * X[-1] + c) for c in range(d)]
    x = [X[c] + 0.02 * np.sin(2.0 * X[c - 1] + c) for c in range(d)]
    return [*v, 1.1 + 0.1 * np.sin(2.0 * X[0] + X[-1]), *x]


def conditions_of(blocks, condition):
    """condition(name, axis, side) of each face that no other one meets, by its middle."""
    sides = [
        (b, k, s) for b in blocks for k in range(b.dimension) if not b.periodic[k] for s in (0, 1)
    ]
    found = [b.face_positions(k, s).mean(axis=1) for b, k, s in sides]
    middles = np.reshape(found, (len(sides), -1) if sides else (0, 1))
    apart = np.abs(middles[:, None] - middles).max(axis=-1) > 1e-9
    alone = (~apart).sum(axis=1) == 1
    return {(b.name, *f): condition(b.name, *f) for (b, *f), one in zip(sides, alone) if one}


def problem_of(shape, faces, fluid, plate, points=(), **options):
    """A problem on a shape of block_shapes; faces: (name, axis, side) -> condition of those that
    meet nothing. options: of blocks of gas and of solids; jumps.
    """
    blocks = []
    for name, (X, _) in shape.items():
        kind = name.split()[0]
        material, initial = (fluid, swirling) if kind == "gas" else (plate, bent)
        cells, d = tuple(n - 1 for n in X.shape[1:]), len(X)
        more = {"initial": initial, **options.get(kind, {})}
        blocks.append(Block(name, material, nodes(X.transpose(*range(d, 0, -1), 0)), cells, **more))
    found = conditions_of(blocks, faces)
    return BlockProblem(tuple(blocks), found, options.get("jumps"), points=points)


def closed(name, axis, side):
    """Slip walls and rollers."""
    return Slip() if name.startswith("gas") else Roller()


def moved(*X_and_t):
    *X, t = X_and_t
    return [x + 0.1 * np.sin(3.0 * t + c) * (1.0 + X[0]) for c, x in enumerate(X)]
