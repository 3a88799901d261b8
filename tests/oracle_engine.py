"""The engine on problems of the oracle of blocks, to hold one against the other: materials,
conditions and blocks of the oracle as those of the engine."""

from functools import cache

import numpy as np
from block_ledgers import complete, rates
from mpi4py import MPI
from oracle_formulas import rate_of, spread

from fsipetsc import Block, BlockProblem, Fluid
from fsipetsc.blocks import conditions
from fsipetsc.blocks.maps import nodes
from fsipetsc.materials.own import transport_law
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.solid_pressure import gruneisen
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.scheme.plan import RATE
from fsipetsc.stepping.block_state import BlockState


def by_components(value):
    """f(X, t) as f(*X, t); else the value."""
    return (lambda *at: value(np.array(at[:-1]), at[-1])) if callable(value) else value


def condition_of(given):
    kept = given._asdict()
    if motion := kept.pop("motion", None):
        kept |= {"x": motion, "velocity": lambda X, t: rate_of(motion, X, t)}
    kept = {key: by_components(value) for key, value in kept.items() if value is not None}
    return getattr(conditions, type(given).__name__)(**kept)


@cache
def power(n):
    return lambda T: T**n


def material_of(m, d):
    force = tuple(m.force) if m.force else ((0.0,) * d if d > 1 else 0.0)
    if m.kind == "gas":
        law = stiffened_gas(m.gamma, m.cv, m.p_inf) if m.p_inf else None
        transport = transport_law(*map(power, m.powers)) if any(m.powers) else None
        return Fluid(m.mu, m.kappa, m.gamma, m.R, law, transport, force)
    more = {"pressing": gruneisen(m.gruneisen)} if m.gruneisen else {}
    return ElasticSolid(
        *(m.mu_e, m.lambda_e, m.kappa, m.m0, m.alpha, m.p_ref), m.law, m.heat, force=force, **more
    )


def block_of(b):
    X, d = b.X, len(b.X)
    for k, period in enumerate(b.periods):
        if period is not None:
            X = np.concatenate([X, X.take([0], k + 1) + spread(period, d)], axis=k + 1)
    return Block(
        *(b.name, material_of(b.material, d), nodes(X.transpose(*range(d, 0, -1), 0))),
        tuple(n - 1 for n in X.shape[1:]),
        lambda *X: [1.0 + 0.0 * X[0]] * (2 * d + 1 if b.material.kind == "solid" else d + 2),
        periodic=tuple(p is not None for p in b.periods) or (False,) * d,
        prestress=(lambda *X: b.prestress(np.array(X))) if b.prestress else None,
    )


class Engine:
    """The right-hand side of the engine for an oracle's problem, in arrays like the oracle's."""

    def __init__(self, made, **options):
        p = made.problem
        faces = {
            (made.names[f.block], f.axis, f.side): condition_of(f.condition)
            for particle in made.particles
            for f in particle.outer
        }
        self.shapes = [b.X.shape[1:] for b in p.blocks]
        self.problem = BlockProblem(tuple(map(block_of, p.blocks)), faces, **options)
        # dissipation 0: on where blocks are joined
        opt = {"fsi_order": p.order, "fsi_convection": p.form, "fsi_shock": p.shock}
        opt["fsi_dissipation"] = p.dissipation / 0.3 or -1.0
        self.state = BlockState(MPI.COMM_SELF, self.problem, opt)
        self.state.refresh(0.0)  # data that do not depend on time
        self.y, self.f = self.state.y, np.zeros_like(self.state.y)

    def _get(self, vector):
        found = {}
        for part in self.state.layout.parts.values():
            own = self.state.layout.owned(part.k, vector).T
            whole = np.empty_like(own)
            whole[:, part.numbers] = own
            name, shape = self.problem.blocks[part.k].name, self.shapes[part.k]
            found[name] = whole.reshape(-1, *shape, order="F")
        return found

    def complete(self, q, t=0.0):
        """As the oracle's."""
        for part in self.state.layout.parts.values():
            value = q[self.problem.blocks[part.k].name]
            self.state.owned(part.k)[:] = value.reshape(len(value), -1, order="F").T[part.numbers]
        self.state.results[RATE] = 2e3  # differences in time are of 2^-14 s
        complete(self.state, t, self.y)
        return self._get(self.y)

    def rates(self, q, t=0.0):
        """As the oracle's; q is completed, which the engine must see, too."""
        self.complete(q, t)
        rates(self.state, t, self.y, self.f)
        return self._get(self.f)
