"""The program with a stand-in for the solver, and a case file for it; see the fixture ``here``."""

from __future__ import annotations

import subprocess
from pathlib import Path

from helpers import PATIENCE, environment, run
from kept_ranks import KEPT

#: a stand-in for the solver: it prints the options, or does what the case's option -do says
STAND_IN = """
import json
from fsipetsc.options import read_options

def run_given(case, given, comm):
    options = read_options(case, given)
    exec(options["do"], {"comm": comm, "case": case, "options": options})
    if comm.rank == 0:
        print(json.dumps(options), flush=True)
"""
#: the program with it
DRIVER = f"""{STAND_IN}
import sys, types
for name in ("fsipetsc.stepping", "fsipetsc.stepping.run"):
    sys.modules[name] = types.ModuleType(name)
sys.modules["fsipetsc.stepping.run"].run_given = run_given
from fsipetsc.cli import main
sys.exit(main())
"""
CASE = """
from fsipetsc.options import Option

SUMMARY = "a stub"
OPTIONS = (Option("solid_force", float, 0.0, "N", "force"), Option("do", str, "", "", "what to do"))
DEFAULTS = {"fsi_h": 0.1, "ts_max_time": 1.0}


def build(opt):
    return opt["no_such_option"]
"""


def run_stub(*args, ranks=1, petsc_options=None):
    """The program with the stand-in and the case file, by ranks that are there already."""
    words = ["stub.py", *map(str, args)]
    more = {} if petsc_options is None else {"petsc_options": petsc_options}
    place = Path.cwd(), PATIENCE, environment()
    (answer,) = KEPT.do(ranks, *place, [words], stand_in=STAND_IN, **more)
    return subprocess.CompletedProcess(words, *answer)


def start_stub(*args, **more):
    """The same in a process of its own."""
    return run("driver.py", "stub.py", *args, **more)
