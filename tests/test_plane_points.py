"""Series of points of interfaces in two dimensions: the traction and heat flux of the scheme, whoever owns what."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import computed, solve
from test_plane_rates import ORDERS, Rates, problem

from fsipetsc.cases import load_case, plane_mms
from fsipetsc.errors import InputError
from fsipetsc.options import defaults
from fsipetsc.stepping.plane.watched import NAMES, Watched, chosen

COLUMN = 5


def record_of(rates, places):
    """What is recorded of points of a random state."""
    watched = Watched(rates.layout, rates.path, chosen(rates.case, rates.layout, places))
    record = np.zeros(1, [(name, "f8", (len(watched.points),)) for name in NAMES])
    rates.path.apply_conditions(rates.y, 0.0)
    watched.look(record[0], 0.0)
    return watched.points, record[0]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("mu", [0.0, 0.02], ids=["slip", "no slip"])
def test_traction_and_heat_are_what_the_scheme_does(order, mu):
    """Where gas slips the rates show it; else it is what makes the two accelerations one, and the rates of T."""
    rates = Rates(problem(mu, 0.03, 2.0), order)
    points, record = record_of(rates, [COLUMN / 16])
    assert points == [(0, COLUMN, COLUMN / 16)]
    h, weight = rates.layout.grids[0].h_y, float(rates.path.layers[0].end_weight)
    q, f = rates.gas[-1, COLUMN], rates.gas_rates[-1, COLUMN]
    solid, of_solid = rates.solid[0, COLUMN], rates.solid_rates[0, COLUMN]
    m_f, m_s, alpha, cv = h * weight * q[1], h * weight * 2.0, 1.5, 2.5
    D = np.zeros(16)  # slope of the interface
    for k, w in enumerate(rates.layout_operator().interior, start=1):
        D[COLUMN + k], D[COLUMN - k] = float(w) * 16, -float(w) * 16
    N = np.array([-D @ rates.solid[0, :, 1], 1 + D @ rates.solid[0, :, 0]])
    length, u = np.hypot(*N), q[2:4] / q[1]
    a_f, a_s = (f[2:4] - u * f[1]) / q[1], of_solid[2:4]
    unloaded = (f[4] - u @ f[2:4] + 0.5 * u @ u * f[1]) / q[1] / cv - (q[4] / q[1] - 0.5 * u @ u) * f[1] / q[1] / cv
    traction = np.array([record["t_x_point"][0], record["t_y_point"][0]]) * length
    if mu > 0:
        assert np.allclose(traction, (a_f - a_s) / (1 / m_f + 1 / m_s), rtol=1e-10, atol=1e-12)
    else:
        assert abs(traction[0] * N[1] - traction[1] * N[0]) < 1e-12 * length
        turned = np.array([-D @ rates.solid[0, :, 3], D @ rates.solid[0, :, 2]])
        assert abs(N @ (a_s - a_f) - turned @ (u - solid[2:4])) < 1e-9  # the rates, loaded, keep one normal velocity
        rates.path.part(1).evaluate(0.0)  # what is in the path without the traction
        free = rates.layout.local(1, rates.path._rates)[0, COLUMN, 2:4]
        assert np.allclose(a_s - free, traction / m_s, rtol=1e-10, atol=1e-10) and np.abs(traction).max() > 1e-3
    heat = (unloaded - of_solid[4]) / (1 / (m_f * cv) + 1 / (m_s * alpha))
    assert abs(record["q_point"][0] * length - heat) < 1e-9 * max(1.0, abs(heat)) and abs(heat) > 1e-4
    assert np.allclose([record[f"{name}_point"][0] for name in ("u", "v", "T")], solid[2:5], rtol=0, atol=1e-15)
    assert record["x_point"][0] == COLUMN / 16 + solid[0] and record["y_point"][0] == 1.0 + solid[1]
    rates.close()


def test_it_converges(tmp_path):
    """To the traction and the heat flux of the manufactured solution."""
    case = load_case("plane_mms")
    gas = plane_mms.build({**defaults(case)}).layers[0].material
    errors = []
    for n in (16, 32):
        options = ("-fsi_h", 1 / n, "-fsi_points", "0.25,0.8", "-ts_max_time", 0.1)
        result = computed(tmp_path, f"{n}.h5", "plane_mms", *options)
        X = np.array([X for _, X in result.points])
        assert np.allclose(X, [0.25, round(0.8 * n) / n]) and {name for name, _ in result.points} == {"gas | solid"}
        series, worst = result.series, np.zeros(4)
        for i, t in enumerate(series["t"]):
            exact, m = plane_mms.gas_point(gas, X, np.ones(2), t), plane_mms.motion(X, np.ones(2), t)
            length = np.hypot(1 + m.x_X, m.y_X)
            known = exact.across[2] / length, exact.across[3] / length, exact.heat / length, X + m.x
            found = (series[f"{name}_point"][i] for name in ("t_x", "t_y", "q", "x"))
            worst = np.maximum(worst, [np.abs(a - b).max() for a, b in zip(found, known, strict=True)])
        errors.append(worst)
    assert (errors[1] < (5e-5, 5e-5, 1e-5, 2e-6)).all() and (np.log2(errors[0] / errors[1]) > 3.3).all(), errors


def test_fused_steps_have_the_same(tmp_path):
    """Their states stand elsewhere from stage to stage."""
    options = ("blast", "-fsi_h", 0.125, "-fsi_points", "0.25,0.5", "-ts_dt", 0.005, "-ts_max_steps", 40)
    fused, plain = (computed(tmp_path, f"{kind}.h5", *options, "-ts_type", kind) for kind in ("fused", "rk"))
    for name in NAMES:
        close = 1e-11 if name in ("x_point", "y_point") else 1e-8  # solids get heat in fused steps alone, by which p rises
        assert np.allclose(fused.series[name], plain.series[name], rtol=close, atol=close), name
    assert np.ptp(fused.series["t_y_point"][:, 1]) > 0.1


def test_where_there_is_no_interface(tmp_path):
    for case, place, said in (("panel", 1.2, "no interface at this X"), ("mms", 0.5, "two dimensions")):
        done = solve(case, "-fsi_points", place, "-ts_max_steps", 1, cwd=tmp_path)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1) and said in done.stderr and "-fsi_points" in done.stderr
    assert not list(tmp_path.glob("*.h5"))


def test_only_points_of_interfaces():
    rates = Rates(problem(0.02, 0.03, 2.0), 4)
    assert chosen(rates.case, rates.layout, [1.0, 0.0, 0.03]) == [(0, 0, 0.0)]  # periodic, and the nearest ones
    with pytest.raises(InputError, match=r"-fsi_points 1\.5: there is no interface"):
        chosen(rates.case, rates.layout, [1.5])
    rates.close()
