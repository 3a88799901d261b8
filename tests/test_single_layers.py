"""A gas or a solid alone, in any form of the equations: there is no interface, and nothing asks for one."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, solve

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

import fsipetsc
from fsipetsc.boundaries import Wall, clamped
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.physics.sutherland import sutherland
from fsipetsc.problem import FluidLayer, Problem, SolidLayer
from fsipetsc.scheme.laws import Form, ProblemLaws

LAYERS = str(REPOSITORY / "tests" / "layers.py")
FORMS = {
    "plain": Form(),
    "entropy": Form(entropy=True),
    "narrow": Form(narrow=True),
    "dissipation": Form(dissipation=1.0),
    "shocks": Form(shocks=1.0),
}


def gas(**laws) -> Problem:
    def rest(X):
        return 1 + 0 * X, 0 * X, 1 + 0 * X

    return Problem((FluidLayer("gas", Fluid(0.01, 0.03, 1.4, 1.0, **laws), (0.0, 1.0), rest),), Wall(0.0), Wall(1.0))


def solid() -> Problem:
    layer = SolidLayer("bar", Solid(20.0, 0.02, 2.0, 1.0), (0.0, 1.0), lambda X: (0 * X, 0 * X, 1 + 0 * X, X))
    return Problem((layer,), clamped(), clamped())


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("problem", [gas(), gas(transport=sutherland(1.0, 0.4)), solid()], ids=["gas", "own law", "solid"])
def test_compiled_functions_name_a_pair_of_laws_all_the_same(problem, form):
    """numba compiles the call of one, which is never made, and fails where there is none to be named."""
    laws = ProblemLaws(problem, form=FORMS[form])
    assert len(laws.pairs) > 0 and laws.of_interfaces == []


ENTROPY, *OTHERS = "-fsi_convection entropy", "-fsi_viscous narrow", "-fsi_dissipation 1 -fsi_shock 1"
LONG = [(kind, options) for kind in "gs" for options in OTHERS]  # kernels that no other test needs


@pytest.mark.parametrize(("kind", "options"), [("g", ENTROPY), *(pytest.param(*one, marks=pytest.mark.long) for one in LONG)])
def test_it_runs_and_keeps_mass_and_energy(kind, options, tmp_path):
    words = *options.split(), "-layers", kind, "-fsi_h", "0.025", "-ts_max_time", "0.3", "-fsi_output", "alone.h5", "-fsi_quiet"
    done = solve(LAYERS, *words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "alone.h5") as result:
        assert result.complete
        for name in ("mass", "energy"):
            values = result.series.get(name)
            if values is not None and values.size:
                assert np.abs(values / values[0] - 1).max() < 1e-8, name
