"""The scheme of blocks in plain numpy, slow and obvious: the compiled engine is compared with it.

It shares no code with the engine except the exact SBP coefficients. Derivatives are dense matrices,
pair fluxes are made for all pairs of a line, particles are loops. The dimension d is 1, 2 or 3.
Formulas of a point are in oracle_formulas.py, rates of single blocks in oracle_volume.py, particles
and their constraints in oracle_particles.py; here they are put together.

Arrays of a block have the shape (components, n_1, ..., n_d): index k counts along the logical axis
xi_k. In the memory of the engine xi_1 is contiguous: its node n is ``array.reshape(c, -1,
order="F")[:, n]``.

    gas    q = (J, J rho, J rho u_1..d, J E)     J: volume per logical volume, E: energy per volume
    solid  q = (D_1..d, v_1..d, e)               D = x - X, e: total energy per mass (with W/m0 if
                                                 heat is "elastic")

Use: ``oracle = Oracle(problem)``, ``q = oracle.random_state(rng)``, ``oracle.rates(q, t)``,
``oracle.complete(q, t)``, ``oracle.integrals(q)``. States and rates are dicts of arrays by the
block's name. One place has one gas: gases on two sides of a solid's vertex that do not touch each
other are not covered.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from oracle_formulas import Free, NoSlip, Open, Outflow, conserved, flux, gas_state, gauss, rate_of
from oracle_particles import Particles


@dataclass
class Sums:
    """Of the members of a particle. gas: Q (sums of W q), R (of rates); solid: mass, momentum,
    mass times displacement, force, energy and what of its rate is stored.
    """

    Q: np.ndarray = None
    R: np.ndarray = None
    M: float = 0.0
    P: np.ndarray = 0.0
    D: np.ndarray = 0.0
    force: np.ndarray = 0.0
    energy: float = 0.0
    stored: float = 0.0


class Oracle(Particles):
    """See the head of this file."""

    def rates(self, q, t=0.0, grid=None):
        """Of a completed state. grid: {name: (displacement, velocity)} in the place of those that
        follow from solids.
        """
        grids, terms, out = self.grids(q, t, grid), {}, {}
        for k, name in enumerate(self.names):
            if k in self.solids:
                terms[k] = M, force, energy, _ = self.solid_terms(k, q[name], grids[k], t)
                out[name] = np.array([*q[name][self.d : -1], *(force / M), energy / M])
            else:
                terms[k] = self.gas_terms(k, q[name], grids[k], t)
                out[name] = terms[k] / self.W[k]
        for p in self.particles:
            self._particle_rates(p, self._sums(p, q, terms), q, t, grids, terms, out)
        return out

    def _sums(self, p, q, terms=None):
        s = Sums()
        for k, node in p.gas:
            i = (slice(None), *node)
            s.Q = (0.0 if s.Q is None else s.Q) + self.W[k][node] * q[self.names[k]][i]
            if terms:
                s.R = (0.0 if s.R is None else s.R) + terms[k][i]
        for k, node in p.solid:
            i, value = (slice(None), *node), q[self.names[k]][(slice(None), *node)]
            M = (self.W[k] * self.solids[k][1])[node] * self.blocks[k].material.m0
            s.M, s.P, s.D = s.M + M, s.P + M * value[self.d : -1], s.D + M * value[: self.d]
            if terms:
                s.force, s.energy = s.force + terms[k][1][i], s.energy + terms[k][2][node]
                s.stored = s.stored + terms[k][3][node]
            else:
                s.energy = s.energy + M * value[-1]
        return s

    def _particle_rates(self, p, s, q, t, grids, terms, out):
        d = self.d
        u, v, a, inverse = np.zeros(d), np.zeros(d), np.zeros(2 * d), np.zeros(2 * d)
        if p.gas:
            m = self.blocks[p.gas[0][0]].material
            u, T = s.Q[2:-1] / s.Q[1], gas_state(m, s.Q).T
            self._through_faces(p, s, m, grids)
            a[:d], inverse[:d] = (s.R[2:-1] - u * s.R[1]) / s.Q[1], 1.0 / s.Q[1]
        if p.solid:
            v = s.P / s.M
            self._loads(p, s, v, grids, t)
            a[d:], inverse[d:] = s.force / s.M, 1.0 / s.M
        rows = self.rows(p, grids, t, 2, u, v)
        for row, factor in zip(rows, gauss(rows, a, inverse)[1] if rows else ()):
            if p.gas:
                s.R[2:-1] += factor * row.gas
                s.R[-1] += factor * row.gas_power
            if p.solid:
                s.force = s.force + factor * row.solid
                s.energy = s.energy + factor * row.solid_power
        # heat (capacity times rate of temperature) of both
        C, Q = np.zeros(2), np.zeros(2)
        if p.gas:
            C[0] = s.Q[1] * m.cv
            Q[0] = s.R[-1] - u @ s.R[2:-1] + (0.5 * u @ u - m.cv * T) * s.R[1] - m.p_inf * s.R[0]
        if p.solid:
            C[1] = s.M * self.blocks[p.solid[0][0]].material.alpha
            Q[1] = s.energy - v @ s.force - s.stored
        T_t = np.full(2, Q.sum() / C.sum()) if self._conducts(p) else Q / np.where(C > 0.0, C, 1.0)
        given = self._prescribed_T(p, t)
        T_t = [T_t[i] if given[i] is None else given[i][1] for i in range(2)]
        if p.gas:
            s.R[-1] += C[0] * T_t[0] - Q[0]
            self._gas_members(p, s, m, q, t, out)
        if p.solid:
            self._solid_members(p, s, v, T_t[1], t, terms, out)

    def _gas_members(self, p, s, m, q, t, out):
        """U_t = (R - U V_t)/V, (JU)_t = J U_t + U J_t with each member's own J."""
        U, face = s.Q[1:] / s.Q[0], self._given(p, "gas")
        U_t = (s.R[1:] - U * s.R[0]) / s.Q[0]
        if face:
            given = lambda X, t: self._from_values(m, face.condition.values(X, t))  # noqa: E731
            U_t = rate_of(given, self.place(face.block, face.node), t)
        for k, node in p.gas:
            i = (slice(None), *node)
            J, J_t = q[self.names[k]][i][0], out[self.names[k]][i][0]
            out[self.names[k]][i] = np.array([J_t, *(J * U_t + U * J_t)])

    def _solid_members(self, p, s, v, T_t, t, terms, out):
        """One v_t and T_t; of the energy each keeps what it stores in W."""
        acceleration, alpha = s.force / s.M, self.blocks[p.solid[0][0]].material.alpha
        face = self._given(p, "solid")
        if face:
            values = rate_of(face.condition.values, self.place(face.block, face.node), t)
            acceleration, T_t = values[: self.d], values[self.d]
        own = [self._own_heating(terms[k], node, v) for k, node in p.solid]
        more = T_t - np.dot([terms[k][0][node] for k, node in p.solid], own) / (s.M * alpha)
        for (k, node), heating in zip(p.solid, own):
            e_t = v @ acceleration + terms[k][3][node] / terms[k][0][node] + alpha * T_t
            if self._apart(p):
                e_t += heating + alpha * (more - T_t)
            out[self.names[k]][(slice(None), *node)] = np.array([*v, *acceleration, e_t])

    @staticmethod
    def _own_heating(terms, node, v):
        """alpha T_t of a node by the terms of its own block."""
        M, force, energy, stored = (part[(..., *node)] for part in terms)
        return (energy - v @ force - stored) / M

    @staticmethod
    def _from_values(m, values):
        rho, *u, T = values
        return conserved(m, rho, np.array(u), T)

    def _through_faces(self, p, s, m, grids):
        """What passes open faces of a gas, and heat through walls, into the sum of rates."""
        here = gas_state(m, s.Q)
        for f in p.outer:
            c, grid = f.condition, grids[f.block]
            if self._kind(f) != "gas":
                continue
            n = self.normal(f, grid.a)
            area, g = np.sqrt(n @ n), n @ grid.v[(slice(None), *f.node)]
            if isinstance(c, NoSlip) and c.heat_flux:
                s.R[-1] += c.heat_flux * area
            if not isinstance(c, (Open, Outflow)):
                continue
            through, inside = flux(here, n, g), s.Q[1:] / s.Q[0]
            if isinstance(c, Open):
                through = flux(self._by_characteristics(c, m, here, n, g), n, g)
            elif c.pressure > 0.0:
                outside = self._beyond(c, m, here, (n @ here.u - g) / area)
                o = gas_state(m, np.array([1.0, *outside]))
                waves = ((n @ w.u - g, np.sqrt(m.gamma * m.R * w.T)) for w in (here, o))
                fastest = max(abs(speed) + area * sound for speed, sound in waves)
                through = 0.5 * (through + flux(o, n, g) - fastest * (outside - inside))
            s.R[1:] -= through

    @staticmethod
    def _by_characteristics(c, m, here, n, g):
        """The gas at an open face: p + Z u_n of the inside, p - Z u_n of the outside, Z of the
        inside at the mean pressure, entropy and velocity along the face of the side that the gas
        comes from; faster than sound, all of it.
        """
        area = np.sqrt(n @ n)
        n = n / area

        def as_state(rho, u, T):
            return gas_state(m, np.array([1.0, *conserved(m, rho, u, T)]))

        there = as_state(c.rho, np.array(c.u, float), c.T)
        sound, sound_there = (np.sqrt(m.gamma * m.R * w.T) for w in (here, there))
        a, b = (n @ w.u - g / area for w in (here, there))
        if a >= sound:
            return here
        if b <= -sound_there:
            return there
        mean = here.rho + 0.5 * (there.p - here.p) / sound**2
        Z = np.sqrt(m.gamma * mean * (0.5 * (here.p + there.p) + m.p_inf))
        p, speed = 0.5 * (here.p + there.p + Z * (a - b)), 0.5 * (a + b + (here.p - there.p) / Z)
        side, own, c_side = (here, a, sound) if speed >= 0.0 else (there, b, sound_there)
        rho = side.rho + (p - side.p) / c_side**2
        return as_state(rho, side.u + n * (speed - own), (p + m.p_inf) / (rho * m.R))

    @staticmethod
    def _beyond(c, m, here, velocity):
        """Unknowns per volume beyond an outflow; velocity: of the gas out of it."""
        mach = max(velocity, 0.0) / np.sqrt(m.gamma * m.R * here.T)
        p = here.p + max(1.0 - mach**2, 0.0) * (c.pressure - here.p)
        return conserved(m, here.rho, here.u, (p + m.p_inf) / (here.rho * m.R))

    def _loads(self, p, s, v, grids, t):
        """Pressure, heat, and in three dimensions p_ref, on a solid."""
        p_ref = self.blocks[p.solid[0][0]].material.p_ref if self.d == 3 else 0.0
        for f in p.outer:
            c = f.condition
            if self._kind(f) != "solid":
                continue
            if isinstance(c, Free):
                push = (p_ref - c.pressure) * self.normal(f, grids[f.block].a)
                s.force, s.energy = s.force + push, s.energy + push @ v
            if getattr(c, "heat_flux", 0.0):
                area = self.normal(f, self.solids[f.block][0])
                s.energy += c.heat_flux * np.sqrt(area @ area)
        for f in p.contact:
            n = self.normal(f, grids[f.block].a)  # of the gas: into the solid
            s.force, s.energy = s.force - p_ref * n, s.energy - p_ref * n @ v

    def complete(self, q, t=0.0, grid=None):
        """The state with members of particles made one and all conditions fulfilled. Sums are kept,
        but for what walls and clamps take. The kinetic energy that a solid loses goes to the gas.
        """
        d, q = self.d, {name: value.copy() for name, value in q.items()}
        sums = [self._sums(p, q) for p in self.particles]
        for p, s in zip(self.particles, sums):
            if p.solid:
                D = s.D / s.M
                rows, face = self.rows(p, None, t, 0, 0.0 * D, 0.0 * D), self._given(p, "solid")
                if rows:
                    D = gauss(rows, np.concatenate([0.0 * D, D]), np.repeat([0.0, 1.0], d))[0][d:]
                if face:
                    X = self.place(face.block, face.node)
                    D = np.array(face.condition.values(X, t)[d + 1 :]) - X
                for k, node in p.solid:
                    q[self.names[k]][(slice(0, d), *node)] = D
        grids = self.grids(q, t, grid)
        W = {k: self.elastic(k, grids[k].x)[0] / self.blocks[k].material.m0 for k in self.solids}
        for p, s in zip(self.particles, sums):
            self._complete(p, s, q, t, grids, W)
        return q

    def _complete(self, p, s, q, t, grids, W):
        before = s.energy
        d, C, H = self.d, np.zeros(2), np.zeros(2)
        z, inverse = np.zeros(2 * d), np.zeros(2 * d)
        if p.gas:
            z[:d], inverse[:d] = s.Q[2:-1] / s.Q[1], 1.0 / s.Q[1]
        if p.solid:
            z[d:], inverse[d:] = s.P / s.M, 1.0 / s.M
        rows = self.rows(p, grids, t, 1, z[:d], z[d:])
        if rows:
            z = gauss(rows, z, inverse)[0]
        u, v = z[:d], z[d:]
        if p.gas and p.solid and not self._clamped(p):  # what the solid loses goes to the gas
            change = 0.5 * (s.M * v @ v - s.P @ s.P / s.M)
            s.energy, s.Q[-1] = s.energy + change, s.Q[-1] - change
        if p.gas:
            m = self.blocks[p.gas[0][0]].material
            C[0], H[0] = s.Q[1] * m.cv, s.Q[-1] - 0.5 * s.Q[1] * u @ u - m.p_inf * s.Q[0]
        stored = []
        if p.solid:
            n = self.blocks[p.solid[0][0]].material
            stored = [W[k][node] if n.heat == "elastic" else 0.0 for k, node in p.solid]
            masses = [(self.W[k] * self.solids[k][1])[node] * n.m0 for k, node in p.solid]
            C[1], H[1] = s.M * n.alpha, s.energy - 0.5 * s.M * v @ v - np.dot(masses, stored)
        T = np.full(2, H.sum() / C.sum()) if self._conducts(p) else H / np.where(C > 0.0, C, 1.0)
        given = self._prescribed_T(p, t)
        T = [T[i] if given[i] is None else given[i][0] for i in range(2)]
        if p.gas:
            face = self._given(p, "gas")
            U = conserved(m, s.Q[1] / s.Q[0], u, T[0])
            if face:
                X = self.place(face.block, face.node)
                U = self._from_values(m, face.condition.values(X, t))
            for k, node in p.gas:
                J = q[self.names[k]][(0, *node)]
                q[self.names[k]][(slice(1, None), *node)] = J * U
        face = self._given(p, "solid")
        if face:
            values = np.array(face.condition.values(self.place(face.block, face.node), t))
            v, T[1] = values[:d], values[d]
        for (k, node), w in zip(p.solid, stored):
            at_node, e = q[self.names[k]][(slice(None), *node)], 0.5 * v @ v + w + n.alpha * T[1]
            if self._apart(p) and given[1] is None:
                e = at_node[-1] + (s.energy - before) / s.M
            at_node[d:] = *v, e

    def random_state(self, rng, size=1.0):
        """Completed; node by node random. With clamps and walls as at t = 0."""
        blocks = {b.name: self.random_block(k, rng, size) for k, b in enumerate(self.blocks)}
        return self.complete(blocks)

    def integrals(self, q, t=0.0):
        """Sums over all blocks: see ``Volume.sums``. q may be complex, for derivatives."""
        grids, found = self.grids(q, t), {}
        for k, name in enumerate(self.names):
            for what, value in self.sums(k, q[name], grids[k].x).items():
                found[what] = found.get(what, 0.0) + value
        return found
