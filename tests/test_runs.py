"""Cases of runs/: each runs; numbers that pages tell of them, against theory."""

import numpy as np
import pytest
from helpers import REPOSITORY, compute
from scipy.optimize import brentq

CASES = {path.stem: str(path) for path in sorted((REPOSITORY / "runs").glob("*.py"))}


# runs/heat_flux.py and docs/heat.md


def rate_of_conduction(T, faster, L=0.02, K=8e6):
    """s [1/s] of the slowest exp(-s t) of small differences of temperature about T [K].

    A gas: (p/T) c_p T_t - p_t = kappa T_xx; both have the pressure p, for the sum of their energies
    is p V/(gamma - 1). The foam is pressed by p_t/K, which heats it. A gas has T = A sin(a y) + p/C
    (1 - cos(a y)) at y from its wall, the foam B cos(b z) + p e/C_s at z from its middle.
    """
    p0 = 1e5 * T / 280.0
    kappa, kappa_s, C_s, e = 0.026 * faster, 0.035 * faster, 30.0 * 1300.0, p0 / K
    C = 3.5 * p0 / T

    def determinant(s):
        a, b = np.sqrt(s * C / kappa), np.sqrt(s * C_s / kappa_s)
        sin, cos = np.sin(a * L), np.cos(a * L)
        rows = [
            [sin, -np.cos(0.5 * b * L), (1.0 - cos) / C - e / C_s],
            [kappa * a * cos, -kappa_s * b * np.sin(0.5 * b * L), kappa * a * sin / C],
            [kappa * a * (cos - 1.0), 0.0, kappa * a * sin / C + s * L * (2.5 + 3.5 * 0.5 * e)],
        ]
        return np.linalg.det(rows)

    return brentq(determinant, 2e-3 * faster, 4e-3 * faster, xtol=1e-12)


def test_heat_through_three_layers(tmp_path):
    """The steady flux is that of resistances in series; the rest decays at the rate of theory."""
    words = "-flux_warm 281 -flux_faster 3e4 -ts_max_time 0.24"
    run = compute(1, tmp_path, {"flux": (CASES["heat_flux"], words)})["flux"]
    t, flux = run.series["t"], run.series["heat_face"] / run.series["dt"][:, None]
    lengths = np.diff([0.02, *run.series["x_interface"][-1], 0.08])
    steady = 1.0 / np.sum(lengths / [780.0, 1050.0, 780.0])
    last = flux[-1000:, :2].mean(axis=0)  # some sound is left
    assert last == pytest.approx([steady, -steady], rel=5e-9)
    rest = (t > 0.05) & (t < 0.14)
    rate = -np.polyfit(t[rest], np.log(np.abs(flux[rest].sum(axis=1))), 1)[0]
    assert rate == pytest.approx(rate_of_conduction(280.5, 3e4), rel=2e-5)


# runs/ramp.py and docs/shocks.md


def test_a_flow_over_a_ramp(tmp_path):
    """Pressures are those of theory; wall heating and over-expansion as on finer grids."""
    words = "-ramp_wall rigid -fsi_h 0.0625"
    run = compute(1, tmp_path, {"ramp": (CASES["ramp"], words)})["ramp"]
    p_2, T_2, p_3 = 1.7065786, 1.1701513, 1.0026427
    on, behind = (run.blocks[f"gas {k}"] for k in (1, 2))
    middle = (on.X[0] > 0.5) & (on.X[0] < 0.9)
    p, T, p_behind = 1.4 * on["p"][-1], on["T"][-1], 1.4 * behind["p"][-1, 0]
    assert p[0, middle].mean() == pytest.approx(p_2, rel=2e-3)
    assert T[0, middle].mean() / T_2 - 1.0 == pytest.approx(0.0095, abs=0.001)
    assert T[3, middle].mean() == pytest.approx(T_2, rel=5e-3)
    assert p_behind.min() / p_3 - 1.0 == pytest.approx(-0.064, abs=0.002)
    assert p_behind[8:].mean() == pytest.approx(p_3, rel=0.01)
