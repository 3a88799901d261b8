"""A scheme of blocks that solves no equations: unknowns spread, and particles share them.

It has what fsipetsc.blockrun.block_state asks of a scheme. Numbers depend on halos and particles.
"""

from __future__ import annotations

import numpy as np

from fsipetsc.blockrun.columns import fields_of
from fsipetsc.blockrun.scheme import Scheme
from fsipetsc.blocks.values import block_values
from fsipetsc.parallel.particle_exchange import ParticleExchange

#: of the spreading [1/s], and of what is added to the last unknown of a node
RATE, SOURCE = 0.3, 0.01


class StubScheme:
    """q_t = RATE * (sum of the neighbours - their number q) + SOURCE in the last unknown.

    SOURCE cos 20 t where data depend on time.
    """

    alone, steady, fault = False, False, None
    step = Scheme.step

    def __init__(self, layout, problem, order, form, instant, columns, ends, alone):
        self._columns, self._ends = columns, ends
        self._memory = tuple(np.zeros(layout.local_size) for _ in range(2))
        self.layout, self.problem, self.d = layout, problem, problem.dimension
        self.kinds = [block.kind for block in problem.blocks]
        self._places = {part.k: problem.places(part.k, part.numbers) for part in layout.parts}
        self._exchanges = [self._exchange(kind) for kind in ("fluid", "solid")]

    def _exchange(self, kind):
        """Of particles with members of one kind; (exchange, particles, places of own members)."""
        members, layout = self.problem.members, self.layout
        chosen = np.array([self.kinds[k] == kind for k in members.block], bool)
        particle, block, node = (array[chosen] for array in members)
        owners = np.empty(particle.size, np.int64)
        for k in range(len(self.kinds)):
            owners[block == k] = layout.owners(k, node[block == k])
        here = np.isin(particle, particle[owners == layout.comm.rank])
        particle, block, node, owners = (a[here] for a in (particle, block, node, owners))
        dof = next((layout.dofs[k] for k, own in enumerate(self.kinds) if own == kind), 1)
        tag = 1 + (kind == "solid")
        exchange = ParticleExchange(layout.comm, particle, owners, dof, tag)
        at = np.empty(exchange.mine.size, np.int64)
        for part in layout.parts:
            own = block[exchange.mine] == part.k
            at[own] = part.at(node[exchange.mine][own])
        return exchange, np.unique(particle, return_inverse=True)[1], at[:, None] + np.arange(dof)

    def attach(self, y, stage, extremes, rates, results, latest, at_ends, *rest):
        self._extremes, self._latest, self._at_ends = extremes, latest, at_ends

    def initial(self, t, y):
        d = self.d
        for part in self.layout.parts:
            block, X = self.problem.blocks[part.k], self._places[part.k].T
            values, q = block_values(block, "initial", X, t), y.owned(part.k)
            if block.kind == "fluid":
                rho, *u, T = values
                columns = [np.ones_like(rho), rho, *(rho * c for c in u), rho * T]
            else:
                v, T, x = values[:d], values[d], values[d + 1 :]
                columns = [*(x[c] - X[c] for c in range(d)), *v, T]
            for c, column in enumerate(columns):
                q[:, c] = column

    def stretch(self, t, y):
        self.complete(t, y)

    def complete(self, t, y):
        for exchange, particle, at in self._exchanges:
            exchange.table[: len(at)] = y.array[at]
            exchange.begin()
            exchange.end()
            sums = np.zeros((particle.max(initial=-1) + 1, exchange.table.shape[1]))
            np.add.at(sums, particle, exchange.table[exchange.row])
            counts = np.bincount(particle, minlength=len(sums))
            if len(at):
                y.array[at] = (sums / counts[:, None])[particle[exchange.mine]]

    def rates(self, t, y, f):
        y.begin()
        y.end()
        for part in self.layout.parts:
            own, ghosted, first = part.patch
            q = y.ghosted(part.k).reshape(*ghosted[::-1], part.dof)
            middle = tuple(slice(a, a + n) for a, n in zip(first[::-1], own[::-1], strict=True))
            rates = np.zeros(q.shape)
            for axis in range(3):
                low, high = (
                    tuple(slice(*ends) if a == axis else slice(None) for a in range(3))
                    for ends in ((None, -1), (1, None))
                )
                apart = q[high] - q[low]
                rates[low] += apart
                rates[high] -= apart
            rates = RATE * rates[middle].reshape(-1, part.dof)
            if self.kinds[part.k] == "fluid":
                rates[:, 0] = 0.0
            rates[:, -1] += SOURCE * self._wave(t) - (
                20.0 if "fails" in self.problem.notes else 0.0
            )
            self.layout.owned(part.k, f)[:] = rates
        f[f.size - self.layout.behind :] = 1.0 if self.layout.comm.rank == 0 else 0.0

    def _wave(self, t):
        return 1.0 if self.problem.steady_data else np.cos(20.0 * t)

    def look(self, y):
        self._latest[:], self._at_ends[:] = 0.0, 0.0
        fluids = [k for k, kind in enumerate(self.kinds) if kind == "fluid"]
        words = self._extremes[1:].reshape(-1, 5)
        words[:] = 0.0, 0.0, 0.0, -np.inf, 0.0
        for part in self.layout.parts:
            q = y.owned(part.k)
            bad = not np.isfinite(q).all() or (q[:, -1] <= 0.0).any()
            words[part.k] = float(bad), 40.0 + np.abs(q).max(), 0.0, -q[:, 0].min(), q[:, 0].max()
            self._latest[self._columns["energy"]] += q[:, -1].sum()
            if part.k in fluids:
                self._latest[self._columns["mass"].start + fluids.index(part.k)] = q[:, 1].sum()
        for number, k, row, X in self._ends:
            self._at_ends[:2, number] = y.owned(k)[row, :2]
            self._at_ends[0, number] += X

    def volume_ratio(self, y, k):
        return np.ones(len(y.owned(k)))

    def fields(self, t, y, k):
        part, d = self.layout.part(k), self.d
        q, X, kind = y.owned(k), self._places[k], self.kinds[k]
        columns = fields_of(kind, d)
        found = np.zeros((len(q), len(columns)))
        if kind == "fluid":
            found[:, 0], found[:, 1 : 1 + d] = q[:, 1], q[:, 2 : 2 + d]
            found[:, 1 + d], found[:, 3 + d] = q[:, -1], q[:, 0]
            found[:, -d:] = X
        else:
            found[:, :d], found[:, d] = q[:, d : 2 * d], q[:, -1]
            x = columns.index("x")
            found[:, x : x + d] = X + q[:, :d]
        assert part is not None
        return found

    def destroy(self):
        for exchange, _, _ in self._exchanges:
            exchange.destroy()
