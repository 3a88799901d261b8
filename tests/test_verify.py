"""The command `verify`: its table, its references, and an entry as a user runs it."""

from __future__ import annotations

import csv
import importlib.util
from math import inf

import numpy as np
import pytest
from helpers import REPOSITORY, message, mpirun, solve

from fsipetsc.verify import ENTRIES
from fsipetsc.verify.entry import Bound, Row, reference


def program(name):
    """An independent program of the folder `verify`."""
    spec = importlib.util.spec_from_file_location(name, REPOSITORY / "verify" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_orders_and_verdicts():
    row = Row("a", "u", 4, (0.1, 0.05, 0.025), (16e-4, 2e-4, 1e-5), Bound(4.0, 2e-5))
    assert row.observed == pytest.approx((3.0, np.log2(20.0)))
    assert row.verdict == "holds"
    assert row._replace(bound=Bound(4.5, 1e-6)).verdict == "order 4.32 < 4.5; error 1.00e-05 > 1.00e-06"
    assert row._replace(errors=(1.0, 1.0, np.nan)).verdict.startswith("order nan < 4; error nan")
    of_grids = row._replace(bound=Bound(at={0.05: 1e-4, 0.025: 1e-4}))
    assert of_grids.verdict == "error 2.00e-04 > 1.00e-04"
    alone = Row("a", "u", 4, (0.1,), (1e-5,), Bound(error=inf))
    assert alone.observed == () and alone.verdict == "holds"
    assert alone._replace(bound=Bound(1.0)).verdict == "order unknown < 1"


def test_references_are_what_their_programs_make():
    made = program("elastic_piston").columns(points=5)
    kept = reference("elastic_piston")
    for name, values in made.items():
        assert kept[name][::100] == pytest.approx(values, rel=1e-10, abs=1e-12), name
    made, kept = program("riemann_problems").columns(), reference("riemann_problems")
    assert list(kept) == list(made)
    for name, values in made.items():
        assert kept[name] == pytest.approx(np.array(values), rel=1e-10), name


def test_entries_say_all_that_another_code_needs():
    for name in ENTRIES:
        entry = importlib.import_module(f"fsipetsc.verify.{name}").ENTRY
        assert entry.name == name and set(entry.levels) == {"quick", "full"}
        assert len(entry.text.splitlines()) <= 40 and entry.source and entry.bounds
        orders = {order for level in entry.levels.values() for order in level}
        assert {order for _, order in entry.bounds} <= orders


def test_a_name_that_there_is_not(tmp_path):
    done = solve("verify", "turek", cwd=tmp_path)
    message(done, 2, "there is no entry 'turek': expected elastic_piston")


@pytest.mark.mpi
def test_the_elastic_piston_on_two_ranks(tmp_path):
    done = mpirun(2, "-m", "fsipetsc", "verify", "elastic_piston", "-verify_docs", "pages", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    with (tmp_path / "verify.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["verdict"] for row in rows} == {"holds"}
    of_stress = [float(row["error"]) for row in rows if row["quantity"] == "receding, stress"]
    assert len(of_stress) == 2 and 0.0 < of_stress[1] < of_stress[0] < 1e-3
    text = (tmp_path / "pages" / "elastic_piston.md").read_text()
    assert "| receding, stress | 4 |" in text and len(text.splitlines()) <= 60
    assert (tmp_path / "pages" / "elastic_piston.png").stat().st_size > 10_000
    assert not list(tmp_path.glob("verify-*"))
