"""The command `verify`: its table, its references, and entries as a user runs them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers import REPOSITORY, program, rows_of, solve, well

from fsipetsc.cases import load_case
from fsipetsc.options import defaults
from fsipetsc.studies.trials import Row, reference
from fsipetsc.studies.verify.command import problem
from fsipetsc.studies.verify.entries import ENTRIES


def test_orders_and_verdicts():
    row = Row("u", 4, 4.0, None, (0.1, 0.05, 0.025), (16e-4, 2e-4, 1e-5))
    assert row.observed == pytest.approx((3.0, np.log2(20.0)))
    for changed, verdict in (
        ({}, "converges"),
        ({"rate": 4.7}, "converges"),
        ({"rate": 4.8}, "falls short"),
        ({"rate": 4.8, "most": 2e-5}, "holds"),
        ({"rate": None, "most": 9e-6}, "falls short"),
        ({"errors": (1.0, 1.0, np.nan), "most": 1.0}, "falls short"),
        ({"spacings": (0.1,), "errors": (1e-5,)}, "falls short"),
        ({"spacings": (0.1,), "errors": (0.0,), "rate": None, "most": 0.0}, "holds"),
    ):
        assert replace(row, **changed).verdict == verdict
    said = [
        replace(row, rate=a, most=b).expected for a, b in ((2.8, None), (None, 2e-4), (3, 0.01))
    ]
    assert said == ["order 2.8", "error 0.0002", "order 3 or error 0.01"]
    small = replace(row, errors=(1e-10, 4e-16, 1e-16)).observed
    assert small[0] > 10.0 and np.isnan(small[1]), "round-off over round-off is no order"


#: reference -> program and its function
PROGRAMS = {
    **{name: (name, "columns") for name in ("riemann_problems", "superseismic", "oblique")},
    "large_deformation": ("large_deformation", "columns"),
    "normal_modes": ("modes", "columns"),
    "beam": ("beams", "columns"),
    "panel_flutter": ("beams", "flutter_columns"),
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.long if n == "panel_flutter" else ()) for n in PROGRAMS],
)
def test_references_are_what_their_programs_make(name):
    source, function = PROGRAMS[name]
    kept, made = reference(name), getattr(program(source), function)()
    assert list(kept) == list(made)
    for column, values in made.items():
        np.testing.assert_allclose(kept[column], values, rtol=1e-8, atol=1e-12, err_msg=column)


def test_the_superseismic_case_has_the_states_of_its_reference():
    """Behind the shock; in the solid behind both waves, and behind the P wave alone."""
    case, table = load_case("superseismic"), reference("superseismic")
    solid, gas = (layer.exact for layer in case.build(defaults(case)).layers)
    behind_p = "solid u behind P", "solid v behind P"
    places = (gas, 0.2, 0.1, ("rho", "u", "v", "T")), (solid, 0.1, -0.02, ("solid u", "solid v"))
    for exact, X, Y, names in (*places, (solid, 0.02, -0.2, behind_p)):
        found = exact(np.array([X]), np.array([Y]), 0.5)
        assert np.ravel(found[: len(names)]) == pytest.approx([table[of][0] for of in names], 1e-9)


def test_entries_say_all_that_another_code_needs():
    for name, (_, full, _) in ENTRIES.items():
        title, _, *text = problem(name).splitlines()
        assert full and title.startswith("# ") and 5 < len(text) <= 44
        assert "\n\nReference: " in problem(name) and "Expected: " in " ".join(text)
        page = (REPOSITORY / "docs" / "verify" / f"{name}.md").read_text()
        assert page.startswith(problem(name)) and len(page.splitlines()) <= 60


def test_entries_as_they_run(tmp_path):
    """The elastic piston; beams, whose frequencies have no steps; a tube that has but a page."""
    words = "verify elastic_piston beam shock_on_panel -verify_docs pages".split()
    done = well(solve(*words, cwd=tmp_path, ranks=2))
    assert "only with -verify_level full" in done.stdout
    rows = rows_of(tmp_path / "verify.csv")
    assert "6 converge, 4 hold, 0 fall short of 10 rows" in done.stdout
    for row in rows:
        published = row["quantity"].startswith("receding")
        assert row["verdict"] == ("holds" if published else "converges")
        compared = row["case"] == "beam"
        assert bool(row["value"]) == bool(row["reference"]) == compared
        if compared:
            error = abs(float(row["value"]) / float(row["reference"]) - 1.0)
            assert float(row["error"]) == pytest.approx(error, rel=1e-6)
    for coarse, fine in pairwise(rows):
        if fine["rate"] and fine["case"] == "elastic_piston":
            (h, error), (half, less) = ((float(r["h"]), float(r["error"])) for r in (coarse, fine))
            assert 0.0 < less < error / 2.5 < 1e-2, "an order above 1.3"
            assert float(fine["rate"]) == pytest.approx(np.log(error / less) / np.log(h / half))
    assert sum(bool(row["rate"]) for row in rows) >= 8  # of four quantities, there and back
    pages = {path.name: path.read_text() for path in (tmp_path / "pages").glob("*.md")}
    assert "| receding, stress | 4 |" in pages["elastic_piston.md"]
    assert set(pages) == {"elastic_piston.md", "beam.md"}
    assert all(len(text.splitlines()) <= 60 for text in pages.values())
    assert (tmp_path / "pages" / "elastic_piston.png").stat().st_size > 10_000
    assert not list(tmp_path.glob("verify-*"))
