"""The scheme of blocks in plain numpy, slow and obvious: the compiled engine is compared with it.

It shares no code with the engine except the exact SBP coefficients. Derivatives are dense matrices,
pair fluxes are made for all pairs of a line, stresses are derivatives of energies, particles are
loops. The dimension d is 1, 2 or 3; the last coordinate may be the distance from an axis or a
centre. Formulas at a point: oracle_formulas.py; grids: oracle_grid.py; rates of single blocks:
oracle_volume.py; particles and their constraints: oracle_particles.py.

Arrays of a block have the shape (components, n_1, ..., n_d): index k counts along the logical axis
xi_k. In the memory of the engine xi_1 is contiguous: its node n is ``array.reshape(c, -1,
order="F")[:, n]``.

    gas    q = (J, J rho, J rho u_1..d, J E)     J: volume per logical volume, E: energy per volume
    solid  q = (D_1..d, v_1..d, e)               D = x - X, e: total energy per mass (with W/m0 if
                                                 heat is "elastic")

States and rates are dicts of arrays by the block's name. Gases on two sides of a solid's vertex
that do not touch each other are not covered."""

from types import SimpleNamespace

import numpy as np
import oracle_formulas as formulas
from oracle_formulas import TINY, conserved, flux, gas_state, gauss
from oracle_particles import Particles


class Oracle(Particles):
    """See the head of this file. kappa: coordinates around an axis (1) or a centre (2)."""

    def rates(self, q, t=0.0):
        """Of a completed state."""
        grids, terms, out = self.grids(q, t), {}, {}
        for k, name in enumerate(self.names):
            if k in self.solids:
                terms[k] = M, force, energy, _ = self.solid_terms(k, q[name], grids[k])
                out[name] = np.array([*q[name][self.d : -1], *(force / M), energy / M])
            else:
                terms[k] = self.gas_terms(k, q[name], grids[k])
                out[name] = terms[k] / self.W[k]
        for p in self.particles:
            self._particle_rates(p, self._sums(p, q, terms), q, t, grids, terms, out)
        return out

    def _sums(self, p, q, terms=None):
        """Of the members of a particle. gas: Q (sums of W q), R (of rates); solid: mass, momentum,
        mass times displacement, force, energy or its rate, and what of that is stored."""
        s = SimpleNamespace(**dict.fromkeys("QRMPD", 0.0), force=0.0, energy=0.0, stored=0.0)
        for k, node in p.gas:
            i = (slice(None), *node)
            s.Q = s.Q + self.W[k][node] * q[self.names[k]][i]
            s.R = s.R + terms[k][i] if terms else None
        for k, node in p.solid:
            M, value = self.mass(k, node), q[self.names[k]][(slice(None), *node)]
            s.M, s.P, s.D = s.M + M, s.P + M * value[self.d : -1], s.D + M * value[: self.d]
            if terms:
                _, force, energy, stored = (part[(..., *node)] for part in terms[k])
                s.force, s.stored = s.force + force, s.stored + stored
            s.energy = s.energy + (energy if terms else M * value[-1])
        return s

    def mass(self, k, node):
        """Of a node of a solid."""
        return self.W[k][node] * self.solids[k][1][node] * self.blocks[k].material.m0

    def _materials(self, p):
        """Of the gas and of the solid of a particle, or None."""
        return [self.blocks[of[0][0]].material if of else None for of in (p.gas, p.solid)]

    def _motion_of(self, p, s, of_gas, of_solid):
        """Vectors of both in one, and the inverse masses."""
        z, inverse, d = np.zeros(2 * self.d), np.zeros(2 * self.d), self.d
        if p.gas:
            z[:d], inverse[:d] = of_gas / s.Q[1], 1.0 / s.Q[1]
        if p.solid:
            z[d:], inverse[d:] = of_solid / s.M, 1.0 / s.M
        return z, inverse

    def _temperatures(self, p, s, heat, t, level):
        """Heat over capacity of gas and solid, of both if heat is conducted, or what is given;
        or (level 1) their rates. And the capacities."""
        m, n = self._materials(p)
        C = np.array([s.Q[1] * m.cv if m else 0.0, s.M * n.alpha if n else 0.0])
        T = np.full(2, heat.sum() / C.sum()) if self.conducts(p) else heat / np.where(C, C, 1.0)
        given = self.prescribed_T(p, t)
        return [T[i] if given[i] is None else given[i][level] for i in range(2)], C

    def _particle_rates(self, p, s, q, t, grids, terms, out):
        d, (m, _), heat = self.d, self._materials(p), np.zeros(2)
        if p.gas:
            self._through_faces(p, s, m, grids)
        z, _ = self._motion_of(p, s, s.Q[2:-1] if p.gas else 0.0, s.P)
        u, v = z[:d], z[d:]
        if p.solid:
            self._loads(p, s, v, grids)
        a, inverse = self._motion_of(p, s, s.R[2:-1] - u * s.R[1] if p.gas else 0.0, s.force)
        rows = self.rows(p, grids, t, 2, u, v)
        for row, factor in zip(rows, gauss(rows, a, inverse)[1]):
            if p.gas:
                s.R[2:-1] += factor * row.gas
                s.R[-1] += factor * row.gas_power
            if p.solid:
                s.force = s.force + factor * row.solid
                s.energy = s.energy + factor * row.solid_power
        if p.gas:
            e = m.cv * gas_state(m, s.Q).T
            heat[0] = s.R[-1] - u @ s.R[2:-1] + (0.5 * u @ u - e) * s.R[1] - m.p_inf * s.R[0]
        if p.solid:
            heat[1] = s.energy - v @ s.force - s.stored
        T_t, C = self._temperatures(p, s, heat, t, 1)
        if p.gas:
            s.R[-1] += C[0] * T_t[0] - heat[0]
            self._gas_members(p, s, m, q, t, out)
        if p.solid:
            self._solid_members(p, s, v, T_t[1], C[1], t, terms, out)

    def _gas_members(self, p, s, m, q, t, out):
        """U_t = (R - U V_t)/V, (JU)_t = J U_t + U J_t with each member's own J."""
        U, given = s.Q[1:] / s.Q[0], self.given(p, "gas")
        U_t = (s.R[1:] - U * s.R[0]) / s.Q[0]
        if given:
            U_t = np.imag(self._from_values(m, given(t + 1j * TINY))) / TINY
        for k, node in p.gas:
            i = (slice(None), *node)
            J, J_t = q[self.names[k]][i][0], out[self.names[k]][i][0]
            out[self.names[k]][i] = np.array([J_t, *(J * U_t + U * J_t)])

    def _solid_members(self, p, s, v, T_t, capacity, t, terms, out):
        """One v_t and T_t; each keeps the energy that it stores in W, if apart its own heat too."""
        a, given = s.force / s.M, self.given(p, "solid")
        alpha = capacity / s.M
        if given:
            *a, T_t = np.imag(np.array(given(t + 1j * TINY), complex))[: self.d + 1] / TINY
        members = [[part[(..., *node)] for part in terms[k]] for k, node in p.solid]
        own = [energy - v @ force - stored for _, force, energy, stored in members]
        for (k, node), (M, *_, stored), heat in zip(p.solid, members, own):
            e_t = v @ a + stored / M + alpha * T_t
            if self.apart(p):
                e_t += heat / M - sum(own) / s.M
            out[self.names[k]][(slice(None), *node)] = np.array([*v, *a, e_t])

    @staticmethod
    def _from_values(m, values):
        rho, *u, T = values
        return conserved(m, rho, np.array(u), T)

    def _through_faces(self, p, s, m, grids):
        """What passes open faces of a gas, and heat through walls, into the sum of rates."""
        here = gas_state(m, s.Q)
        for f in p.outer:
            c, grid = f.condition, grids[f.block]
            if self.kind(f) != "gas":
                continue
            n = self.normal(f, grid.a)
            area, g = np.sqrt(n @ n), n @ grid.v[(slice(None), *f.node)]
            if isinstance(c, formulas.NoSlip) and c.heat_flux:
                s.R[-1] += c.heat_flux * area
            if isinstance(c, formulas.Open):
                s.R[1:] -= flux(self._by_characteristics(c, m, here, n, g), n, g)
            elif isinstance(c, formulas.Outflow):
                outside = self._beyond(c, m, here, (n @ here.u - g) / area)
                o = gas_state(m, np.array([1.0, *outside]))
                waves = ((n @ w.u - g, np.sqrt(m.gamma * m.R * w.T)) for w in (here, o))
                fastest = max(abs(speed) + area * sound for speed, sound in waves)
                both = flux(here, n, g) + flux(o, n, g)
                s.R[1:] -= 0.5 * (both - fastest * (outside - s.Q[1:] / s.Q[0]))

    @staticmethod
    def _by_characteristics(c, m, here, n, g):
        """The gas at an open face: p + Z u_n of the inside, p - Z u_n of the outside, Z of the
        inside at the mean pressure, entropy and velocity along the face of the side that the gas
        comes from; faster than sound, all of it."""
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

    def _loads(self, p, s, v, grids):
        """Pressure, heat, and in three dimensions p_ref, on a solid."""
        p_ref = self.blocks[p.solid[0][0]].material.p_ref if self.d == 3 else 0.0
        for f in p.outer:
            if self.kind(f) != "solid":
                continue
            if isinstance(f.condition, formulas.Free):
                push = (p_ref - f.condition.pressure) * self.normal(f, grids[f.block].a)
                s.force, s.energy = s.force + push, s.energy + push @ v
            if flow := getattr(f.condition, "heat_flux", None):
                s.energy += flow * np.linalg.norm(self.normal(f, self.solids[f.block][0]))
        for f in p.contact:
            n = self.normal(f, grids[f.block].a)  # of the gas: into the solid
            s.force, s.energy = s.force - p_ref * n, s.energy - p_ref * n @ v

    def complete(self, q, t=0.0):
        """The state with members of particles made one and all conditions fulfilled. Sums are kept,
        but for what walls and clamps take. The kinetic energy that a solid loses goes to the gas.
        """
        d, q = self.d, {name: value.copy() for name, value in q.items()}
        sums = [self._sums(p, q) for p in self.particles]
        for p, s in zip(self.particles, sums):
            if p.solid:
                D, given = s.D / s.M, self.given(p, "solid")
                rows = self.rows(p, None, t, 0, 0.0 * D, 0.0 * D)
                D = gauss(rows, np.concatenate([0.0 * D, D]), np.repeat([0.0, 1.0], d))[0][d:]
                for k, node in p.solid:
                    moved = np.array(given(t)[d + 1 :]) - self.place(k, node) if given else D
                    q[self.names[k]][(slice(0, d), *node)] = moved
        grids = self.grids(q, t)
        stored = {k: self.stored(k, q[self.names[k]]) for k in self.solids}
        for p, s in zip(self.particles, sums):
            self._complete(p, s, q, t, grids, stored)
        return q

    def _complete(self, p, s, q, t, grids, stored):
        before, d, (m, n), heat = s.energy, self.d, self._materials(p), np.zeros(2)
        z, inverse = self._motion_of(p, s, s.Q[2:-1] if p.gas else 0.0, s.P)
        z = gauss(self.rows(p, grids, t, 1, z[:d], z[d:]), z, inverse)[0]
        u, v = z[:d], z[d:]
        clamped = any(isinstance(f.condition, formulas.Clamped) for f in p.outer)
        if p.gas and p.solid and not clamped:  # what the solid loses goes to the gas
            change = 0.5 * (s.M * v @ v - s.P @ s.P / s.M)
            s.energy, s.Q[-1] = s.energy + change, s.Q[-1] - change
        if p.gas:
            heat[0] = s.Q[-1] - 0.5 * s.Q[1] * u @ u - m.p_inf * s.Q[0]
        if p.solid:
            elastic = sum(self.mass(k, node) * stored[k][node] for k, node in p.solid)
            heat[1] = s.energy - 0.5 * s.M * v @ v - elastic
        T, _ = self._temperatures(p, s, heat, t, 0)
        given = self.given(p, "gas")
        for k, node in p.gas:
            U = self._from_values(m, given(t) if given else (s.Q[1] / s.Q[0], *u, T[0]))
            q[self.names[k]][(slice(1, None), *node)] = q[self.names[k]][(0, *node)] * U
        if given := self.given(p, "solid"):
            *v, T[1] = given(t)[: d + 1]
        for k, node in p.solid:
            at_node = q[self.names[k]][(slice(None), *node)]
            e = 0.5 * np.dot(v, v) + stored[k][node] + n.alpha * T[1]
            if self.apart(p):
                e = at_node[-1] + (s.energy - before) / s.M
            at_node[d:] = *v, e

    def random_state(self, rng, size=1.0):
        """Completed; node by node random. With clamps and walls as at t = 0."""
        blocks = {b.name: self.random_block(k, rng, size) for k, b in enumerate(self.blocks)}
        return self.complete(blocks)

    def integrals(self, q, t=0.0):
        """Sums over all blocks: see ``Volume.sums``. q may be complex, for derivatives."""
        found = {}
        for k, (b, D) in enumerate(zip(self.blocks, self.moved(q, t, 0))):
            for what, value in self.sums(k, q[b.name], b.X + D).items():
                found[what] = found.get(what, 0.0) + value
        return found
