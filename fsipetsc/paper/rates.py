"""dy/dt at a rank's points of a layer, from those with halos, which fulfil conditions; the monitor.

Gas, (4.20): compressible Navier-Stokes in a rigid frame that moves with the velocity s(t) of the
gas's interface point, X = x - x_I(t) + X_I, mu' = 4 mu / 3, e = rho (internal energy + u^2/2):

    rho_t     + (rho (u-s))_X                                            = 0
    (rho u)_t + (rho u (u-s) + p - mu' u_X)_X                            = rho force
    e_t       + (e (u-s) + u (p - mu' u_X) - kappa T_X)_X                = rho u force

Solid, (4.19): Lagrangian, sigma an unknown beside p(epsilon, rho), epsilon = alpha T, rho = m0/x_X:

    u_t          = (sigma - p)_X / m0 + force         (T: the paper's row is misprinted, see (3.1c))
    sigma_t      = K / x_X u_X
    alpha m0 T_t = (sigma - p) u_X + (kappa_e / x_X T_X)_X
    x_t          = u

D acts twice, mu and kappa may vary; rates need values within twice the reach of D. Each quantity
has a row of scratch. A layer is a fsipetsc.paper.paper_layers.Layer.

After a step each layer finds 1/dt [1/s] at Courant number 1, by convection and diffusion, and this
rank's share of the masses of the gases [kg/m2], then of energy [J/m2] and momentum [N s/m2] of all
layers, by the operator's norm, without the strip between an embedded boundary and its ghost point.
"""

import numpy as np

from fsipetsc.equations import gas
from fsipetsc.kernels.loops import each, number, pick, variable, when
from fsipetsc.operators.sbp import STIFFNESS_OF_WIDE
from fsipetsc.paper.ends import delta_of, distance, fill_ghost, move_boundary
from fsipetsc.paper.stencils import STIFFNESS, add_remainder, derivatives, near_ends
from fsipetsc.scheme.monitor import rate_of, survey
from fsipetsc.scheme.plan import BAD, OFF_GRID, RATE, SAID_STOP, STOP

#: rows of scratch: of work, and with those of what is added to rates
WORK_ROWS, SCRATCH_ROWS = 12, 16
#: of the points 0 to 3: coefficients of delta, delta^2 ... in the integral from the ghost point (0)
#: to the boundary (delta) of the cubic through them
STRIP = np.array([[24, -22, 8, -1], [0, 36, -20, 3], [0, -18, 16, -3], [0, 4, -4, 1]]) / 24.0


class Gas(gas.Gas):
    """The equations of a gas of blocks with what this method asks for beside."""

    def viscosity(self, T):
        """mu' = 4/3 mu(T)."""
        return 4.0 / 3.0 * self.mu * self.transport.viscosity(T)

    def conductivity(self, T):
        return self.kappa * self.transport.conductivity(T)

    def velocity_and_temperature(self, rho, m, E):
        """(u, T) from (rho, rho u, e), the last one per volume."""
        u = m / rho
        return u, self.law.temperature(rho, E / rho - 0.5 * u * u)

    def total_energy(self, rho, u, T):
        """e, per volume."""
        return rho * (self.law.internal_energy(rho, T) + 0.5 * u * u)


def widened(span, reach):
    """(first, end) of the active points of a span and those within ``reach`` of them."""
    a, b, A, B = span
    return np.maximum(A, a - reach), np.minimum(B + 1, b + reach)


def added_to_rates(layer):
    """What is added to rates, (unknowns, points), or None: the forcing, then narrow terms."""
    if not layer.narrow:
        return layer.forcing
    (a, b, _, _), rows = layer.span, layer.scratch[WORK_ROWS:]
    for c in each(layer.local.shape[0]):
        for i in each(a, b, vector=True):
            rows[c, i] = 0.0 if layer.forcing is None else layer.forcing[c, i]
    return rows


def put(layer, added, i, rates):
    """Let rates take the place of the unknowns of a point, which nothing reads any more."""
    for c, rate in enumerate(rates):
        layer.local[c, i] = rate if added is None else added[c, i] + rate


def begin_step(layer):
    """Keep the solution; its runs of numbers are those of this rank's active points."""
    size, (a, b, _, _) = layer.local.shape[1], layer.span
    for c in each(layer.local.shape[0]):
        first = layer.at + c * size
        layer.runs[c, 0], layer.runs[c, 1] = first + a, first + b
        for i in each(a, b, vector=True):
            layer.y[c, i] = layer.local[c, i]


def entropy_keeping(gas, rho, m, e, rho_t, m_t, e_t, u_X):
    """What must be added to e_t so that the entropy of a gas's interface point obeys rho T S_t =
    mu' u_X^2. Without conduction no heat reaches this particle of the gas: with h = eps + p/rho

        e_t = u m_t + (h - u^2/2) rho_t + mu' u_X^2.

    Errors of the closure, and the entropy that a shock leaves there, would stay for ever.
    """
    u, T = gas.velocity_and_temperature(rho, m, e)
    h = e / rho - 0.5 * u * u + gas.law.pressure(rho, T) / rho
    return u * m_t + (h - 0.5 * u * u) * rho_t + gas.viscosity(T) * u_X * u_X - e_t


def fluxes(gas, s, unknowns, u, T, u_X, T_X):
    """What stands within (..)_X in (4.20)."""
    (rho, m, e), relative = unknowns, u - s
    pressing = gas.law.pressure(rho, T) - gas.viscosity(T) * u_X
    energy = e * relative + u * pressing - gas.conductivity(T) * T_X
    return rho * relative, m * relative + pressing, energy


def gas_rates(layer):
    """The rates of (4.20), in the place of the unknowns."""
    op, gas, end, per_h, s = layer.op, layer.material, layer.end, 1.0 / layer.h, layer.frame[0]
    w, added, span = layer.scratch, added_to_rates(layer), layer.span
    (force,), (rho, m, e) = gas.force, (layer.local[c] for c in range(3))
    u, T, u_X, T_X, f, g, h = (w[c] for c in range(7))
    (f0, f1), (v0, v1) = (widened(span, reach) for reach in (op.reach, 2 * op.reach))
    for i in each(v0, v1, vector=True):
        r = 1.0 / rho[i]
        v = m[i] * r
        u[i], T[i] = v, gas.law.temperature(rho[i], e[i] * r - 0.5 * v * v)
    ghost, interface = (span[3], span[2]) if layer.side else span[2:]
    if end.gradient:  # u and T of the ghost point are others from here on, for the gradients
        own_u, own_T = variable(), variable()
        with when((v0 <= ghost) & (ghost < v1)):
            own_u.value, own_T.value = u[ghost], T[ghost]
            u[ghost], T[ghost] = end(layer).gradient()
    if layer.narrow:
        narrow_gas(layer, w, added, span)
    for i, near, gradients in derivatives(layer, (u, T), (f0, f1, *span[2:]), per_h):
        if near:  # the two end points are needed again
            u_X[i], T_X[i] = gradients
        unknowns = rho[i], m[i], e[i]
        f[i], g[i], h[i] = fluxes(gas, s, unknowns, u[i], T[i], *gradients)
    if end.gradient:
        with when((f0 <= ghost) & (ghost < f1)):
            of_ghost = own_u.value, own_T.value, u_X[ghost], T_X[ghost]
            unknowns = rho[ghost], m[ghost], e[ghost]
            f[ghost], g[ghost], h[ghost] = fluxes(gas, s, unknowns, *of_ghost)
    for i, near, (f_X, g_X, h_X) in derivatives(layer, (f, g, h), span, per_h):
        if near and near[1] is interface:
            rates = -f_X, -g_X, -h_X
            more = entropy_keeping(gas, rho[i], m[i], e[i], *rates, u_X[i])
            h_X = np.where((gas.kappa == 0.0) & (near[0] == 0), h_X - more, h_X)
        put(layer, added, i, (-f_X, force * rho[i] - g_X, force * m[i] - h_X))


def narrow_gas(layer, w, k, span):
    """Add what narrow derivatives of (u, T), rows 0 and 1 of scratch w, make of the rates."""
    op, gas, (u, T) = layer.op, layer.material, (w[0], w[1])
    mu, mu_u, kappa, *scratch = (w[c] for c in range(7, WORK_ROWS))
    for i in each(*widened(span, 2 * op.p), vector=True):
        viscosity = gas.viscosity(T[i])
        mu[i], mu_u[i], kappa[i] = viscosity, viscosity * u[i], gas.conductivity(T[i])
    for term in each(3):  # R(mu') u in (rho u)_t, R(u mu') u and R(kappa) T in e_t
        y, rate = w[pick(term == 2, 1, 0)], k[pick(term == 0, 1, 2)]
        add_remainder(layer, -1.0 / (layer.h * layer.h), w[7 + term], y, scratch, rate, span)


def elastic_rates(layer):
    """The rates of (4.19), in the place of the unknowns."""
    op, solid, per_h = layer.op, layer.material, 1.0 / layer.h
    w, added, span = layer.scratch, added_to_rates(layer), layer.span
    u, sigma, T, x = (layer.local[c] for c in range(4))
    net, conducted, shorter, velocity = (w[c] for c in range(4))
    wider = (*widened(span, op.reach), *span[2:])
    for i, _, (T_X, x_X) in derivatives(layer, (T, x), wider, per_h):
        r = 1.0 / x_X
        shorter[i], net[i] = r, sigma[i] - solid.pressure(T[i], x_X)
        conducted[i], velocity[i] = solid.kappa_e * r * T_X, u[i]
    if layer.narrow:
        scale, (by, *scratch) = layer.h * layer.h * solid.alpha * solid.m0, (w[4], w[5], w[6])
        for i in each(*widened(span, min(op.reach, 2 * op.p)), vector=True):
            by[i] = solid.kappa_e * shorter[i]
        add_remainder(layer, -1.0 / scale, by, T, scratch, added[2], span)
    rows = velocity, net, conducted
    for i, _, (u_X, net_X, conducted_X) in derivatives(layer, rows, span, per_h):
        acceleration = net_X / solid.m0 + solid.force
        warming = (net[i] * u_X + conducted_X) / (solid.alpha * solid.m0)
        put(layer, added, i, (acceleration, solid.K * shorter[i] * u_X, warming, u[i]))


def stretch(layer):
    """scratch[0] = h x_X of a solid, at the active ones of this rank's points."""
    for i, _, (x_X,) in derivatives(layer, [layer.local[3]], layer.span, 1.0):
        layer.scratch[0, i] = x_X


# after a step. steps: one record for all layers of this rank. results: fsipetsc.scheme.plan;
# bounds: (layers, 2) of 1/dt; latest: masses of so many gases, energy, momentum, then interfaces;
# data: arrays of data of ends and interfaces, none where no data depend on time


def forget(steps):
    """Forget what is known of the step before. Data that are no numbers make this one bad."""
    steps.results[:STOP] = 0.0
    steps.bounds.reshape(-1)[:] = -np.inf
    steps.latest[:] = 0.0
    for numbers in steps.data:
        for i in each(numbers.size):
            with when(~(abs(numbers[i]) < np.inf)):
                steps.results[BAD] = 1.0


def complete_gas(layer):
    """Fill the ghost point, let the boundary move over the grid, monitor the points."""
    fill_ghost(layer)
    move_boundary(layer)
    with when(distance(layer) <= number(layer.least - 2) + 1e-9):
        layer.steps.results[OFF_GRID] = 1.0 + number(layer.number)
    gas, q, h, (a, b, *_) = layer.material, layer.local, layer.h, layer.span

    def see(i):
        """Speeds |u-s| + c, diffusivities max(mu', kappa/cv)/rho; the least of rho and T."""
        rho, m, e = (q[c, i] for c in range(3))
        u, T = gas.velocity_and_temperature(rho, m, e)
        speed = np.absolute(u - layer.frame[0]) + np.sqrt(gas.law.sound_speed_squared(rho, T))
        heat = gas.conductivity(T) / gas.law.heat_capacity(rho, T)
        diffusivity = np.maximum(gas.viscosity(T), heat) / rho
        densities = {"mass": rho, "momentum": m, "energy": e}
        return (speed, diffusivity, -np.where(T < rho, T, rho)), {**densities, "": T + speed}

    (fastest, diffusivity, least), totals, finite = surveyed(layer, (0.0, 0.0, -np.inf), see)
    for k in range(4):
        i, weight = layer.ghost + (1 - 2 * layer.side) * k, 0.0
        for coefficient in STRIP[k, ::-1]:
            weight = (weight + float(coefficient)) * delta_of(layer)
        with when((a <= i) & (i < b)):
            for total, density in zip(totals, see(i)[1].values()):
                total.value += -weight * density
    mass, momentum, energy = totals
    layer.steps.latest[layer.number // 2] += h * mass.value  # every other layer is a gas
    good = (least.value < 0.0) & finite
    note(layer, (h, momentum, energy.value), fastest.value, diffusivity.value, good)


def complete_solid(layer):
    """Monitor the points, in Lagrangian coordinates."""
    solid, q, h, (_, _, A, _) = layer.material, layer.local, layer.h, layer.span
    per_h = 1.0 / h

    def see(i):
        """Wave moduli, and what must be positive."""
        u, sigma, T = (q[c, i] for c in range(3))
        j = np.maximum(i, A + 1)  # the first point has the stretch of the second one
        x_X = (q[3, j] - q[3, j - 1]) * per_h
        p = solid.pressure(T, x_X)
        modulus = solid.wave_modulus(T, p, np.minimum(sigma, p), x_X)
        densities = {"momentum": u, "energy": 0.5 * u * u, "heat": T}
        return (modulus, -modulus, -x_X, -T), {**densities, "": x_X + sigma + modulus}

    found, (momentum, kinetic, heat), finite = surveyed(layer, (0.0, *(-np.inf,) * 3), see)
    stiffest, softest, shortest, coldest = (one.value for one in found)
    energy = kinetic.value + solid.alpha * heat.value
    diffusivity = solid.kappa_e / (-shortest * solid.alpha * solid.m0)
    good = (shortest < 0.0) & (coldest < 0.0) & (softest <= 0.0) & finite
    note(layer, (solid.m0 * h, momentum, energy), np.sqrt(stiffest / solid.m0), diffusivity, good)


def surveyed(layer, least, see):
    """Extremes of this rank's points, each at least ``least``, integrals over h, and whether all is
    finite. see(i): of a point the extremes, and by names three densities, and what must be finite.
    """
    a, b, _, _ = layer.span
    extremes, found = survey(layer.scratch, least, [(a, b, None)], lambda i, more: see(i))
    *totals, other = found.values()
    finite = totals[0].value + totals[1].value + totals[2].value + other.value
    for r, i, _, _ in near_ends(layer.op, layer.span):
        for total, density in zip(totals, see(i)[1].values()):
            total.value += (layer.closure[r, 0] - 1.0) * density
    return extremes, totals, np.absolute(finite) < np.inf


def note(layer, integrals, speed, diffusivity, good):
    """Note the integrals of a layer, its rates, and whether all its points are physical."""
    (scale, momentum, energy), h, order, steps = integrals, layer.h, layer.op.order, layer.steps
    steps.latest[steps.gases] += scale * energy
    steps.latest[steps.gases + 1] += scale * momentum.value
    stiffness = STIFFNESS[order] if layer.narrow else STIFFNESS_OF_WIDE
    steps.bounds[layer.number] = speed / h, stiffness * diffusivity / (h * h)
    with when(~good):
        steps.results[BAD] = 1.0


def finish(steps):
    """Find the bound on the next step, from the rates of all ranks."""
    results = steps.results
    results[RATE] = rate_of(steps.bounds.reshape(-1))
    results[STOP] = results[SAID_STOP]
