"""The engine on the problems of the oracle of blocks, so that one can be held against the other."""

from __future__ import annotations

import numpy as np
import oracle_formulas as oracle
from block_ledgers import scheme_of
from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockForm
from fsipetsc.blockrun.columns import gained
from fsipetsc.blocks import conditions
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.maps import nodes
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.solid_pressure import gruneisen
from fsipetsc.parallel.block_layout import BlockLayout


def by_components(function):
    """f(X, t) as f(*X, t)."""
    return lambda *arguments: function(np.array(arguments[:-1]), arguments[-1])


def condition_of(given):
    """A condition of the oracle as one of the engine."""
    motion, kept = getattr(given, "motion", oracle.REST), given._asdict()
    kept = {key: value for key, value in kept.items() if key not in ("motion", "values")}
    for key in ("T", "heat_flux"):
        if key in kept and not isinstance(given, oracle.Open):
            value = kept.pop(key)
            if callable(value):
                kept[key] = by_components(value)
            elif value:
                kept[key] = value
    if isinstance(given, oracle.Given):
        kept["values"] = by_components(given.values)
    if motion is not oracle.REST:
        kept["x"] = by_components(motion.x)
        kept["velocity"] = by_components(motion.velocity)
    return getattr(conditions, type(given).__name__)(**kept)


def material_of(m, d):
    """A material of the oracle as one of the engine: a perfect gas, or a solid."""
    force = tuple(m.force) if m.force else ((0.0,) * d if d > 1 else 0.0)
    if m.kind == "gas":
        return Fluid(m.mu, m.kappa, m.gamma, m.R, force=force)
    more = {"pressing": gruneisen(m.gruneisen)} if m.gruneisen else {}
    return ElasticSolid(
        *(m.mu_e, m.lambda_e, m.kappa, m.m0, m.alpha, m.p_ref), m.law, m.heat, force=force, **more
    )


def block_of(b):
    """A block of the oracle as one of the engine."""
    X, d = b.X, len(b.X)
    periodic = tuple(p is not None for p in b.periods) or (False,) * d
    for k, period in enumerate(b.periods):
        if period is not None:
            first = np.take(X, [0], k + 1) + oracle.spread(period, d)
            X = np.concatenate([X, first], axis=k + 1)
    places = X.transpose(*range(d, 0, -1), 0)
    cells = tuple(n - 1 for n in X.shape[1:])

    def initial(*places):
        return [1.0 + 0.0 * places[0]] * (2 * d + 1 if b.material.kind == "solid" else d + 2)

    more = {"prestress": lambda *X: b.prestress(np.array(X))} if b.prestress else {}
    material = material_of(b.material, d)
    return Block(b.name, material, nodes(places), cells, initial, periodic=periodic, **more)


class Engine:
    """The right-hand side of the engine for an oracle's problem, in arrays like the oracle's."""

    def __init__(self, made, comm=MPI.COMM_SELF, **options):
        p = made.problem
        outer = (f for q in made.particles for f in q.outer)
        found = {(made.names[f.block], f.axis, f.side): f.condition for f in outer}
        faces = {owner: condition_of(condition) for owner, condition in found.items()}
        self.shapes = {b.name: b.X.shape[1:] for b in p.blocks}
        self.problem = BlockProblem(tuple(map(block_of, p.blocks)), faces, **options)
        auxiliary = gained(self.problem).itemsize // 8
        self.layout = BlockLayout(comm, self.problem, p.order, p.shock > 0.0, auxiliary=auxiliary)
        # dissipation 0: on where blocks are joined
        form = BlockForm(p.form, p.dissipation / 0.3 or -1.0, p.shock)
        self.scheme = scheme_of(self.layout, self.problem, p.order, form)
        self.y, self.f = self.layout.vector(), self.layout.vector()

    def put(self, q):
        """Let the solution be a state of the oracle."""
        for part in self.layout.parts:
            value = q[self.problem.blocks[part.k].name]
            self.y.owned(part.k)[:] = value.reshape(len(value), -1, order="F").T[part.numbers]

    def get(self, vector):
        """A world vector as arrays like the oracle's; on several ranks nan where others own it."""
        found = {}
        for part in self.layout.parts:
            name, own = self.problem.blocks[part.k].name, vector.owned(part.k)
            whole = np.full((own.shape[1], np.prod(self.shapes[name])), np.nan)
            whole[:, part.numbers] = own.T
            found[name] = whole.reshape(own.shape[1], *self.shapes[name], order="F")
        return found

    def complete(self, q, t=0.0):
        """As the oracle's."""
        self.put(q)
        self.scheme.complete(t, self.y)
        return self.get(self.y)

    def rates(self, q, t=0.0):
        """As the oracle's; q is completed, which the engine must see, too."""
        self.complete(q, t)
        self.scheme.rates(t, self.y, self.f.array)
        return self.get(self.f)
