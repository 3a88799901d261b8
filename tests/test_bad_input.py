"""What cannot be: exit status, one message that helps, and nothing is written."""

import pytest
from helpers import KEPT, REPOSITORY, Done, computed, environment, message, mpirun, solve

import fsipetsc
from fsipetsc.output.file_layout import write_checkpoint

FILES = {
    "bad.opts": "-fsi_h 0.1\nfsi_order 6\n",
    "mine.py": "precious",
    "text.h5": "a text, longer than the signature of HDF5",
}
#: arguments, status, the message, with … for what stands between; rod.h5 is a result
LINES = [
    # cases, commands, arguments
    ("rood", 2, "'rood'; did you mean 'rod'? There are rod, "),
    ("rod.h5", 2, "'rod.h5' is no case; results are for commands: info rod.h5"),
    ("info", 2, "RUN.h5 is missing"),
    ("plot a.h5 -o", 2, "-o needs a value…plot RUN.h5 [-o DIR"),
    ("modes rod", 2, "the blocks are not in a steady state"),
    ("modes heat -modes_near 0", 2, "bad value '0' for -modes_near"),
    ("verify turek", 2, "there is no entry 'turek': expected vortex"),
    ("geometry", 2, "geometry: CASE is missing: python -m fsipetsc geometry CASE"),
    # options
    ("rod -fsi_ordr 4", 2, "-fsi_ordr…did you mean -fsi_order?"),
    ("rod -fsi_cfl abc", 2, "'abc' for -fsi_cfl…a number above 0"),
    ("rod -fsi_h=0.1", 2, "did you mean -fsi_h?"),
    ("rod -fsi_h 0.1 0.2", 2, "unexpected argument '0.2'"),
    ("rod -fsi_order 5", 2, "-fsi_order…2, 4, 6, 8"),
    ("rod -ts_max_steps 1e3", 2, "-ts_max_steps…a whole number"),
    ("rod -fsi_output_times 1,0.5", 2, "-fsi_output_times…increase"),
    ("box -fsi_output_times 7", 2, ": 7 would not be reached…-ts_max_time 2"),
    ("rod -snes_type 2.0", 2, "unknown option -snes_type"),
    ("rod -options_file bad.opts", 2, "bad.opts line 2"),
    ("rod -options_file no.opts", 4, "no.opts"),
    ("modes panel -panel_mach 0.9", 2, "a number above 1"),
    # grids, methods, ranks
    ("rod -fsi_h 0.03", 2, "-fsi_h 0.03…'rod'…0.02941176…0.03030303"),
    ("rod -fsi_order 8 -fsi_h 0.1", 2, "'rod' has 11 nodes…at least 16: take 15 cells"),
    ("rod -fsi_h 1e-9 -fsi_coupling projection", 2, "'below'…cells…-fsi_h…too many"),
    ("rod -fsi_coupling projection -fsi_mapping stretched", 2, "-fsi_coupling conservative"),
    ("rod -fsi_coupling projection -fsi_dissipation 1", 2, "-fsi_dissipation"),
    ("piston -fsi_coupling projection", 2, "a wall moves…-fsi_coupling conservative"),
    ("blast -fsi_coupling energy", 2, "this case is made of blocks, …: expected conservative"),
    ("blast -fsi_probes 0.5,9", 2, "no block is there; the nearest node is 7.75 away"),
    ("convergence rod -fsi_hs 0.1,0.05", 2, "rod has no exact solution: its grids are compared"),
    ("stability -stability_points 10", 2, "-stability_points…a whole number above 15"),
    # files
    ("rod -fsi_output x.parts", 2, "-fsi_output: expected the name of a file that does not end in"),
    ("rod -fsi_output no/such/x.h5", 4, "no/such: No such file or directory"),
    ("rod -fsi_output /proc/x.h5", 4, "no file can be written in the directory /proc: "),
    ("rod -fsi_output b.h5 -fsi_checkpoint b.h5", 2, "b.h5…that is where the result goes"),
    ("rod -fsi_checkpoint text.h5", 4, "text.h5: exists, and is no checkpoint of fsipetsc, or"),
    ("rod -fsi_restart rod.h5", 4, "rod.h5: …is not a checkpoint"),
    ("rod -fsi_restart none.h5", 4, "none.h5: there is no such file"),
    ("mms -fsi_restart auto", 4, "mms.checkpoint.h5: the file is damaged"),
    ("new mine.py", 4, "mine.py: File exists"),
    ("new rod.py", 2, "'rod.py' is no name of a case file"),
    ("new run.h5", 2, "expected one that ends in .py"),
    ("new two.py -blocks -water", 2, "-blocks and -water are given: expected one of them"),
    ("info no.h5", 4, "no.h5: there is no such file"),
    ("plot text.h5", 4, "text.h5: the file is damaged, or none of fsipetsc"),
    ("diff a.checkpoint.h5 no.h5", 4, "a.checkpoint.h5: is not a result of fsipetsc"),
    # pictures
    ("plot rod.h5 -fields q", 2, "-fields q: expected some of u, T, p, rho, sigma, strain"),
    ("plot rod.h5 -o text.h5/x.png", 4, "cannot write the "),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bad")
    for name, text in FILES.items():
        (folder / name).write_text(text)
    write_checkpoint(folder / "a.checkpoint.h5", {}, {})
    damaged = bytearray((folder / "a.checkpoint.h5").read_bytes())
    damaged[len(damaged) // 2] ^= 1
    (folder / "mms.checkpoint.h5").write_bytes(damaged)
    computed(folder, "rod.h5", *"rod -fsi_coupling projection -fsi_h 0.1 -ts_max_steps 1".split())
    return folder


@pytest.mark.parametrize(("line", "status", "said"), LINES)
def test_one_message_and_one_status(line, status, said, folder):
    """On two ranks, of which none waits for the other, unless one process does the work alone."""
    before = {path.name: path.stat().st_mtime for path in folder.iterdir()}
    ranks = 1 if line.split()[0] in ("info", "plot", "report", "diff", "new", "stability") else 2
    (answer,) = KEPT.do(ranks, folder, environment(), [line.split()])
    message(Done(line, *answer), status, *said.split("…"))
    assert {path.name: path.stat().st_mtime for path in folder.iterdir()} == before


def test_in_processes_of_their_own(tmp_path):
    done = mpirun(2, "-m", "fsipetsc", *"rod -fsi_ordr 4".split(), cwd=tmp_path)
    message(done, 2, "did you mean -fsi_order?")
    assert "MPI_ABORT" not in done.stderr and not list(tmp_path.iterdir())


RIGHT = (REPOSITORY / "fsipetsc" / "cases" / "template.py").read_text()
RIGHT_GAS = 'FluidLayer("right", air, (RIGHT, END), right_gas'
LATER = ', forcing=lambda X, t: (0.0, 0.0 if t < 1.5e-5 else float("nan"), 0.0)'
#: text of RIGHT, what stands there instead, words of the message; LINE: the line of the new text
FAULTS = {
    "syntax": ("str, Any]) ->", "str, Any] ->", ("case file faulty.py", "LINE")),
    "no return": ("return Problem(", "Problem(", ("nothing", "Problem")),
    "an option": (
        'Option("plate_density"',
        'Option("ts_time_step"',
        ("-ts_time_step", "none of fsi_, ts_"),
    ),
    "a material": ("gamma=GAMMA", "gamma=1", ("LINE", "gamma is 1", "above 1")),
    "not a number": (
        "speed * (END - X)",
        "(0.8 - X) ** 0.5",
        ("initial of block 'right'", "expected", "u = nan at X = 0.8"),
    ),
    "later": (RIGHT_GAS, RIGHT_GAS + LATER, ("LINE", "forcing of block 'right'", "nan")),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_one_message_that_says_where_and_what(name, tmp_path):
    old, new, words = FAULTS[name]
    assert RIGHT.count(old) == 1, name
    text = RIGHT.replace(old, new)
    (tmp_path / "faulty.py").write_text(text)
    line = "faulty.py -fsi_quiet -ts_max_steps 4 -ts_dt 1e-5"
    said = message(solve(*line.split(), cwd=tmp_path), 2)
    place = f"line {text[: text.index(new)].count(chr(10)) + 1}"
    assert all(word.replace("LINE", place) in said for word in words), said
    assert "unexpected" not in said
    assert (tmp_path / "faulty.h5").exists() == (name == "later")
    if name == "later":
        with fsipetsc.open_run(tmp_path / "faulty.h5") as result:
            assert result.summary["status"] == "failed" and result.nframes >= 1
            assert len(result.series["t"]) == result.summary["steps"] >= 1
