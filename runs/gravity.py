"""Air under gravity on an elastic floor: it stays at rest, or a sound wave swings in it.

    mpiexec -n 2 python -m fsipetsc runs/gravity.py
    python -m fsipetsc runs/gravity.py -gravity_wave 0      # nothing moves

10 km of air of one temperature lie between a lid and a floor, 5 km thick, that carries the air and
its own weight. The force on a gas has the potential -f X, so the scheme keeps this state at rest to
round-off (docs/gravity.md).

Numbers to compare with: on a rigid floor u = A exp(z/2H) sin(k z) cos(omega t) is a small wave of
the air, H = R T/g, k = n pi/height, omega^2 = c^2 (k^2 + 1/(2H)^2) (H. Lamb, Hydrodynamics, art.
309). The run follows it for one period, 56.7 s, and prints errors. With -gravity_sudden true the
floor does not carry itself at first: by linear elasticity its top sinks by g depth^2/c^2 = 6.131 m,
c^2 = K/density, and is back after 4 depth/c = 3.162 s. A second.
"""

import numpy as np

from fsipetsc import Fluid, FluidLayer, Option, Problem, Solid, SolidLayer, Wall, clamped
from fsipetsc.equations.elementary import exp

OPTIONS = (
    Option("gravity_wave", float, 1e-3, "m/s", "A, the amplitude of the wave at the floor"),
    Option("gravity_mode", int, 1, "", "n, half waves within the height", check="positive"),
    Option("gravity_sudden", bool, False, "", "the floor does not carry its own weight at first"),
    Option("gravity_g", float, 9.81, "m/s2", "acceleration of gravity", check="nonnegative"),
)
GAMMA, R, T0, P0 = 1.4, 287.0, 300.0, 1e5
HEIGHT, DEPTH, DENSITY, MODULUS = 10e3, 5e3, 2500.0, 1e11
C2 = GAMMA * R * T0
DEFAULTS = {"fsi_h": 250.0, "fsi_order": 4, "ts_max_time": 57.0, "fsi_output_dt": 0.5}


def build(opt):
    """The floor in -DEPTH < X < 0, the air above it."""
    g, A, k = opt["gravity_g"], opt["gravity_wave"], opt["gravity_mode"] * np.pi / HEIGHT
    air = Fluid(mu=0.0, kappa=0.0, gamma=GAMMA, R=R, force=-g)
    rock = Solid(K=MODULUS, kappa_e=0.0, m0=DENSITY, alpha=800.0, force=-g)
    half = 0.5 * g / (R * T0)  # 1/2H
    omega = np.sqrt(C2 * (k * k + half * half))

    def wave(z, t=0.0):
        rho, grows = P0 / (R * T0) * exp(-2.0 * half * z), A * exp(half * z)
        U, slope = grows * np.sin(k * z), grows * (half * np.sin(k * z) + k * np.cos(k * z))
        moved = np.sin(omega * t) / omega  # U times this is the displacement
        denser = -moved * (slope - 2.0 * half * U)
        T = T0 * (1.0 - (GAMMA - 1.0) * moved * slope)
        return rho * (1.0 + denser), U * np.cos(omega * t), T

    def floor(X, t=0.0):
        return 0.0, -P0 + (0.0 if opt["gravity_sudden"] else DENSITY * g * X), T0, X

    known = (None, None) if opt["gravity_sudden"] else (floor, wave)
    layers = (
        SolidLayer("floor", rock, (-DEPTH, 0.0), floor, exact=known[0]),
        FluidLayer("air", air, (0.0, HEIGHT), wave, exact=known[1]),
    )
    note = f"the period of the wave is {2.0 * np.pi / omega:.4f} s"
    return Problem(layers, left=clamped(), right=Wall(HEIGHT), notes=(note,))
