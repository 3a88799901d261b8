"""dy/dt at a rank's points of a layer, from its points with halos, which fulfil all conditions.
Compiled.

Gas, (4.20): compressible Navier-Stokes in a rigid frame that moves with the velocity s(t) of the
gas's interface point, X = x - x_I(t) + X_I, mu' = 4 mu / 3, e = rho (internal energy + u^2/2):

    rho_t     + (rho (u-s))_X                                            = 0
    (rho u)_t + (rho u (u-s) + p - mu' u_X)_X                            = rho force
    e_t       + (e (u-s) + u (p - mu' u_X) - kappa T_X)_X                = rho u force

Solid, (4.19): Lagrangian, sigma an unknown beside the pressure p(epsilon, rho), epsilon = alpha T,
rho = m0 / x_X:

    u_t          = (sigma - p)_X / m0 + force         (T: the paper's row is misprinted, see (3.1c))
    sigma_t      = K / x_X u_X
    alpha m0 T_t = (sigma - p) u_X + (kappa_e / x_X T_X)_X
    x_t          = u

Viscous stress and conduction are inside the outer derivative: D acts twice, mu and kappa may vary;
rates need values within twice the reach of D. The loops work on a row of scratch for each quantity.
"""


from fsipetsc.operators.loops import njit
from fsipetsc.boundaries import DIRICHLET, INTERFACE_END, OPEN
from fsipetsc.paper.ends import gradient_values
from fsipetsc.paper.narrow import MARGIN, narrow_gas, narrow_solid
from fsipetsc.paper.stencils import INNER, U, derivative

#: rows of scratch, and by how much they are longer than there are points
ROWS, MORE = 16, 2 * MARGIN


@njit(**INNER)
def outer_side(layer):
    """Where the embedded boundary of a gas stands: 0 left, 1 right."""
    return 1 if layer.end_kind[0] == INTERFACE_END else 0


@njit(**INNER)
def own_range(layer):
    """(a, b, A, B) among a rank's points with halos: it owns the active ones a .. b-1; A and B are
    the first and the last active point of all."""
    first = layer.own_lo - layer.halo_lo
    A, B = layer.lo - first, layer.hi - first
    return max(layer.own_lo - first, A), min(layer.own_hi - first, B + 1), A, B


@njit(**INNER)
def widened(a, b, A, B, reach):
    """(first, end) of the active points a .. b-1 and those within ``reach`` of them."""
    return max(A, a - reach), min(B + 1, b + reach)


@njit(**INNER)
def start_with(forcing, out):
    """out = forcing."""
    for i in range(out.shape[0]):
        for c in range(out.shape[1]):
            out[U(i), U(c)] = forcing[U(i), U(c)]


# gas


@njit(**INNER)
def primitive_rows(gas, q, rho, m, e, u, T, a, b):
    """The conserved unknowns, u and T at the points a .. b-1."""
    for i in range(a, b):
        density, momentum, energy = q[U(i), 0], q[U(i), 1], q[U(i), 2]
        r = 1.0 / density
        v = momentum * r
        rho[U(i)], m[U(i)], e[U(i)], u[U(i)] = density, momentum, energy, v
        T[U(i)] = gas.law.temperature(density, energy * r - 0.5 * v * v)


@njit(**INNER)
def gas_fluxes(gas, s, rho, m, e, u, T, u_X, T_X, f, g, h, a, b):
    """f, g, h = rho (u-s), rho u (u-s) + p - mu' u_X, e (u-s) + u (p - mu' u_X) - kappa T_X."""
    for i in range(a, b):
        k = U(i)
        relative = u[k] - s
        pressing = gas.law.pressure(rho[k], T[k]) - gas.viscosity(T[k]) * u_X[k]
        f[k], g[k] = rho[k] * relative, m[k] * relative + pressing
        h[k] = e[k] * relative + u[k] * pressing - gas.conductivity(T[k]) * T_X[k]


@njit(**INNER)
def put_gas(force, rho, m, f_X, g_X, h_X, out, a, b, shift):
    """out += -(fluxes)_X and what the body force does."""
    for i in range(a, b):
        k = U(i - shift)
        out[k, 0] -= f_X[U(i)]
        out[k, 1] += force * rho[U(i)] - g_X[U(i)]
        out[k, 2] += force * m[U(i)] - h_X[U(i)]


@njit(**INNER)
def entropy_keeping(gas, rho, m, e, rho_t, m_t, e_t, u_X):
    """What must be added to e_t so that the entropy of a gas's interface point obeys rho T S_t =
    mu' u_X^2.

    Without conduction this point is a particle that no heat reaches, and with h = eps + p/rho

        e_t = u m_t + (h - u^2/2) rho_t + mu' u_X^2.

    The error that the closure makes in the energy, and the entropy that a shock leaves there, would
    stay for ever: nothing carries them away.
    """
    u, T = gas.velocity_and_temperature(rho, m, e)
    h = e / rho - 0.5 * u * u + gas.law.pressure(rho, T) / rho
    return u * m_t + (h - 0.5 * u * u) * rho_t + gas.viscosity(T) * u_X * u_X - e_t


@njit(**INNER)
def gas_rates(op, gas, layer, q, forcing, w, out):
    """(4.20). q: (points with halos, 3); forcing, out: (owned, 3); w: scratch."""
    a, b, A, B = own_range(layer)
    (f0, f1), (v0, v1) = widened(a, b, A, B, op.reach), widened(a, b, A, B, 2 * op.reach)
    start_with(forcing, out)
    if a >= b:
        return
    rho, m, e, u, T, u_X, T_X = w[0], w[1], w[2], w[3], w[4], w[5], w[6]
    f, g, h, f_X, g_X, h_X = w[7], w[8], w[9], w[10], w[11], w[12]
    per_h = 1.0 / layer.h
    primitive_rows(gas, q, rho, m, e, u, T, v0, v1)
    side = outer_side(layer)
    ghost, kind = (A if side == 0 else B), layer.end_kind[side]
    apart = (kind == OPEN or kind == DIRICHLET) and v0 <= ghost < v1
    own_u, own_T = 0.0, 0.0
    if apart:  # u and T of the ghost point are others for the gradients
        own_u, own_T = u[ghost], T[ghost]
        u[ghost], T[ghost] = gradient_values(gas, layer, q, ghost, side)
    derivative(op, u, u_X, f0, f1, A, B, per_h)
    derivative(op, T, T_X, f0, f1, A, B, per_h)
    if op.narrow:
        narrow_gas(op, gas, layer, u, T, w[13], w[14], w[15], out, a, b, A, B)
    if apart:
        u[ghost], T[ghost] = own_u, own_T
    gas_fluxes(gas, layer.s, rho, m, e, u, T, u_X, T_X, f, g, h, f0, f1)
    derivative(op, f, f_X, a, b, A, B, per_h)
    derivative(op, g, g_X, a, b, A, B, per_h)
    derivative(op, h, h_X, a, b, A, B, per_h)
    end = B if side == 0 else A
    if gas.kappa == 0.0 and a <= end < b:
        rates = -f_X[end], -g_X[end], -h_X[end]
        h_X[end] -= entropy_keeping(gas, rho[end], m[end], e[end], *rates, u_X[end])
    put_gas(gas.force, rho, m, f_X, g_X, h_X, out, a, b, layer.halo_lo)


# solid


@njit(**INNER)
def solid_rows(q, u, sigma, T, x, a, b):
    """The unknowns at the points a .. b-1."""
    for i in range(a, b):
        u[U(i)], sigma[U(i)], T[U(i)], x[U(i)] = q[U(i), 0], q[U(i), 1], q[U(i), 2], q[U(i), 3]


@njit(**INNER)
def solid_fluxes(solid, sigma, T, x_X, T_X, stretch, net, conducted, a, b):
    """1/x_X, sigma - p, kappa_e/x_X T_X."""
    for i in range(a, b):
        k = U(i)
        stretch[k], net[k] = 1.0 / x_X[k], sigma[k] - solid.pressure(T[k], x_X[k])
        conducted[k] = solid.kappa_e * stretch[k] * T_X[k]


@njit(**INNER)
def put_solid(solid, u, stretch, net, u_X, net_X, conducted_X, out, a, b, shift):
    """out += (u, sigma, T, x)_t."""
    for i in range(a, b):
        k, j = U(i - shift), U(i)
        out[k, 0] += net_X[j] / solid.m0 + solid.force
        out[k, 1] += solid.K * stretch[j] * u_X[j]
        out[k, 2] += (net[j] * u_X[j] + conducted_X[j]) / (solid.alpha * solid.m0)
        out[k, 3] += u[j]


@njit(**INNER)
def elastic_rates(op, solid, layer, q, forcing, w, out):
    """(4.19). q: (points with halos, 4); forcing, out: (owned, 4); w: scratch."""
    a, b, A, B = own_range(layer)
    (f0, f1), (v0, v1) = widened(a, b, A, B, op.reach), widened(a, b, A, B, 2 * op.reach)
    start_with(forcing, out)
    if a >= b:
        return
    u, sigma, T, x, x_X, T_X = w[0], w[1], w[2], w[3], w[4], w[5]
    stretch, net, conducted, u_X, net_X, conducted_X = w[6], w[7], w[8], w[9], w[10], w[11]
    per_h = 1.0 / layer.h
    solid_rows(q, u, sigma, T, x, v0, v1)
    derivative(op, x, x_X, f0, f1, A, B, per_h)
    derivative(op, T, T_X, f0, f1, A, B, per_h)
    solid_fluxes(solid, sigma, T, x_X, T_X, stretch, net, conducted, f0, f1)
    derivative(op, u, u_X, a, b, A, B, per_h)
    derivative(op, net, net_X, a, b, A, B, per_h)
    derivative(op, conducted, conducted_X, a, b, A, B, per_h)
    if op.narrow:
        narrow_solid(op, solid, layer, T, stretch, w[12], w[13], out, a, b, A, B)
    put_solid(solid, u, stretch, net, u_X, net_X, conducted_X, out, a, b, layer.halo_lo)
