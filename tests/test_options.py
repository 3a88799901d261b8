"""The table of options: reading, checking, defaults."""

from types import SimpleNamespace

import pytest

from fsipetsc import options
from fsipetsc.errors import InputError
from fsipetsc.options import Option, read_options

OWN = (
    Option("solid_force", float, 0.0, "N/m³", "body force"),
    Option("solid_parts", "ints", (1, 2), "", "parts"),
    Option("solid_ratio", float, 0.5, "", "", check=lambda v: v < 1 or "a number below 1"),
    Option("solid_law", str, "linear", "-", "law", ("linear", "cubic")),
)


DEFAULTS = {"fsi_h": 0.0125, "ts_max_time": 2, "fsi_output_dt": 0.02}


def make_case(OPTIONS=OWN, DEFAULTS=DEFAULTS):
    return SimpleNamespace(NAME="stub", SUMMARY="a stub", OPTIONS=OPTIONS, DEFAULTS=DEFAULTS)


@pytest.fixture
def read():
    """Reads a case's options from a command line; PETSc's database is left as it was found."""
    before = options.present()

    def reader(text="", case=None):
        given = options.given_options(text.split() if isinstance(text, str) else text)
        return read_options(case or make_case(), given)

    yield reader
    options.put(before)


@pytest.mark.parametrize("name", ["my result.h5", "my' result"])
def test_every_type_is_converted_and_long_lists_and_blanks_arrive_whole(read, name):
    times = [i / 7 for i in range(500)]
    text = "-fsi_order 6 -fsi_h 1e-3 -fsi_quiet -solid_parts 3,-4 -solid_law cubic"
    listed = ",".join(map(repr, times))
    opt = read([*text.split(), "-fsi_output_times", listed, "-fsi_output", name])
    assert (opt["fsi_order"], opt["fsi_h"], opt["fsi_quiet"]) == (6, 1e-3, True)
    assert (opt["solid_parts"], opt["solid_law"], opt["fsi_output"]) == ((3, -4), "cubic", name)
    assert opt["fsi_output_times"] == tuple(times)


def test_options_of_petsc_are_accepted(read):
    from petsc4py import PETSc

    database = PETSc.Options()
    read("-ts_monitor -malloc_debug no")
    assert database.hasName("ts_monitor")
    assert read("-ts_ssp_type rks3")["ts_type"] == "ssp"
    assert not database.hasName("ts_monitor"), "an option of an earlier run"
    opt = read("-ts_rk_type 5dp -ts_view")
    assert (opt["ts_type"], opt["ts_rk_type"]) == ("rk", "5dp") and database.hasName("ts_view")
    assert read("-ts_time_step 0.25")["ts_dt"] == 0.25  # it has the name that this PETSc knows
    new = PETSc.Sys.getVersion() >= (3, 25)
    assert (database.hasName("ts_dt"), database.hasName("ts_time_step")) == (not new, new)


def test_interval_and_times_of_output_replace_each_other(read):
    """And what was not set is not set after a restart, though the case has a default."""
    assert read("-fsi_output_times 0.1,0.2")["fsi_output_dt"] is None
    both = read("-fsi_output_dt 0.5 -fsi_output_times 0.1,0.2")
    assert (both["fsi_output_dt"], both["fsi_output_times"]) == (0.5, (0.1, 0.2))
    again = read_options(make_case(), {}, inherited={"fsi_output_dt": None})
    assert again["fsi_output_dt"] is None
    with pytest.raises(InputError, match="bad default None of -fsi_order"):
        read_options(make_case(), {}, inherited={"fsi_order": None})
