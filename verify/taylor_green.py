"""Taylor and Green's vortex at constant density, by Fourier series.

u = (sin x cos y cos z, -cos x sin y cos z, 0) at t = 0, period 2 pi; u_t = P(u x w) - nu k^2 u, P
the projection on what has no divergence, w = curl u; dealiased by the 2/3 rule, RK4.
"""

import numpy as np

fft, back = np.fft.rfftn, np.fft.irfftn


def flow(n, every, steps, nu=0.0):
    """u (3, n, n, n), axes x, y, z, again and again when the time `every` has passed in `steps`."""
    k1 = np.fft.fftfreq(n, 1 / n)
    k = np.array(np.meshgrid(k1, k1, np.arange(n // 2 + 1), indexing="ij"))
    squares = (k**2).sum(0)
    kept = (abs(k) < n / 3).all(0)
    x = np.meshgrid(*[2 * np.pi * np.arange(n) / n] * 3, indexing="ij")
    c, s = np.cos(x), np.sin(x)
    first = np.array([s[0] * c[1] * c[2], -c[0] * s[1] * c[2], 0 * c[0]])
    w = np.array([fft(v) for v in first])

    def places(w):
        return np.array([back(v, s=(n, n, n), axes=(0, 1, 2)) for v in w])

    def rate(w):
        u, curl = places(w), places(1j * np.cross(k, w, axis=0))
        f = np.array([fft(v) for v in np.cross(u, curl, axis=0)]) * kept
        return f - k * (k * f).sum(0) / np.maximum(squares, 1) - nu * squares * w

    dt = every / steps
    while True:
        for _ in range(steps):
            a = rate(w)
            b = rate(w + dt / 2 * a)
            c = rate(w + dt / 2 * b)
            w = w + dt / 6 * (a + 2 * b + 2 * c + rate(w + dt * c))
        yield places(w)


def columns(n=96, steps=60, end=1.0):
    """Head -> numbers: on the line y = 2 pi/8, z = 2 pi/16."""
    u = next(flow(n, end, steps))[:, :: n // 16, n // 8, n // 16]
    return dict(zip(("x", "u", "v", "w"), (2 * np.pi * np.arange(16) / 16, *u)))


if __name__ == "__main__":
    from csv_file import save

    save(
        "taylor_green",
        columns(),
        "made by verify/taylor_green.py: velocities at t = 1, y = pi/4, z = pi/8; period 2 pi",
        "without viscosity, density constant; 96^3 nodes, 60 steps: nine digits; 64^3 nodes differ",
        "by 2.4e-7, 48^3 by 9.3e-6; steps of half the size by 1.1e-9",
    )
