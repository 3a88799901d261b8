"""Runs that several tests look at: computed once in a session, several in one process, when the
first test asks; fixtures.
"""

from __future__ import annotations

import fcntl
import importlib.util
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from helpers import REPOSITORY, compute
from kept_ranks import KEPT
from stub_case import CASE, DRIVER

import fsipetsc
from fsipetsc.output.reader import Run

#: files of tests that take longest where nothing is compiled yet, the longest first
DEAREST = (
    *("kills", "documents", "ranks", "block_ledgers", "failures", "radial", "block_oracle"),
    *("shell", "shock", "signals", "time", "flutter", "stability", "process", "orders"),
)
_SHORT = "-fsi_h 0.1 -ts_max_steps 2"
#: runs that compile what most tests need; all tests wait for them
FIRST = {
    "fused": ("rod", _SHORT),
    "rk": ("rod", f"{_SHORT} -ts_type rk"),
    "forced": ("mms", "-ts_max_steps 2"),
}
#: tests of a session whose processes have processors of their own
MANY = 300
ORDERS = (2, 4, 6, 8)
PULSE_SPACINGS = (0.0125, 0.00625)
#: gases whose viscosity or conduction the grids resolve, or that have one of the two
VISCOUS = {
    "both": "-fluid_mu 0.1 -fluid_kappa 0.3",
    "mu": "-fluid_mu 0.1 -fluid_kappa 0",
    "kappa": "-fluid_mu 0 -fluid_kappa 0.3",
}
#: orders with which each is computed: each order once
VISCOUS_ORDERS = {"both": (4, 8), "mu": (6,), "kappa": (2,)}
#: where the pulse starts, in the gas or in the solid -> time at which both waves are inside
PULSE_STARTS = {0.75: 0.0035, -0.75: 0.003}
#: order -> where it starts in the tests of orders
START_OF = {2: 0.75, 4: -0.75, 6: 0.75, 8: -0.75}
#: orders of the rod that bounces three times
BOUNCES = (4, 8)
#: name -> density and modulus; the wave speed is 500 m/s in all. The gas: 1.16 kg/m3, 347 m/s
SOLIDS = {"light": (1.0, 2.5e5), "middle": (4.0, 1e6), "heavy": (4e4, 1e10)}
#: of a solid with pressure, four times K, strained to a quarter of its length: waves of 1109 m/s,
#: without p 500 m/s
PRESSED = (
    "-solid_gruneisen 0.2 -solid_stretch 0.25 -solid_modulus 2.5e5 "
    "-fsi_order 8 -fsi_cfl 0.8 -pulse_width 0.2"
)

#: (-ts_type, -ts_rk_type) -> order
METHODS = {
    ("euler", ""): 1,
    ("ssp", ""): 2,
    **{("rk", name): order for name, order in (("2a", 2), ("3bs", 3), ("4", 4))},
    **{("rk", name): 5 for name in ("5dp", "8vr")},
}
#: of the test of their orders [s]
STEPS = (1e-4, 5e-5)
#: 3 % of the pressure of the gas, and a solid that reflects it all
_SHORT_FALL = "-fsi_h 0.1 -ts_max_time 0.004 -fsi_output_dt 1"


def fixed(method: tuple[str, str], dt: float) -> str:
    """Name of the run with a method of METHODS and a fixed step."""
    return f"{''.join(method)}_{dt}"


def _fixed_step(method: tuple[str, str], dt: float) -> str:
    rk_type = f" -ts_rk_type {method[1]}" if method[1] else ""
    dt = dt if METHODS[method] > 1 else dt / 8
    return f"{_SHORT_FALL} -ts_dt {dt} -ts_type {method[0]}{rk_type}"


#: cases in which the fused method is compared with PETSc's
FUSED = {
    "rod": "rod -fsi_h 0.05 -ts_max_time 0.05 -fsi_output_dt 0.05",
    "mms": "mms -fsi_h 0.05 -fsi_order 6 -ts_max_time 0.2 -fsi_output_dt 0.1",
    "pulse": "pulse -fsi_h 0.05 -fsi_order 8 -ts_max_time 0.003 -pulse_amplitude 1000 "
    "-fsi_output_dt 0.001",
    "piston": f"{REPOSITORY / 'runs' / 'piston.py'} -fsi_order 2 -ts_max_time 0.02 "
    "-fsi_output_dt 0.01",
    "box": "box -fsi_h 0.05 -ts_max_time 0.1",
}

_MMS = "mms -fsi_output_dt 1"
_QUIET_PULSE = "pulse -pulse_amplitude 0.01 -fsi_output_dt 1"
#: group -> name -> case and options
GROUPS: dict[str, dict[str, str]] = {
    "rod": {
        f"order{q}": f"rod -fsi_h 0.025 -fsi_order {q} -fsi_output_dt 0.1 -ts_max_time 3"
        for q in BOUNCES
    },
    "rest": {
        f"order{q}": f"rod -fsi_h 0.05 -fsi_order {q} -rod_gravity 0 -ts_max_time 0.2"
        for q in ORDERS
    },
    "mms": {
        f"order{q}_h{h}": f"{_MMS} -fsi_h {h} -fsi_order {q}"
        for h in (0.00625, 0.0125)
        for q in ORDERS
    },
    "viscous": {
        f"order{q}_h{h}_{name}": f"{_MMS} -fsi_h {h} -fsi_order {q} {options}"
        for h in (0.05, 0.025)
        for name, options in VISCOUS.items()
        for q in VISCOUS_ORDERS[name]
    },
    "fused": {
        f"{name}_{kind}": f"{words} -ts_type {kind}"
        for name, words in FUSED.items()
        for kind in ("fused", "rk")
    },
    "methods": {
        **{fixed(m, dt): f"rod {_fixed_step(m, dt)}" for m in METHODS for dt in STEPS},
        "reference": f"rod {_SHORT_FALL} -ts_dt 6.25e-6 -ts_rk_type 5dp",
    },
    "times": {
        "listed": "rod -fsi_h 0.1 -fsi_output_times 0,0.0011,0.00234567,0.005,0.0071,0.0071003 "
        "-ts_max_time 0.01",
    },
    "pulse": {
        **{
            f"order{q}_h{h}": f"{_QUIET_PULSE} -fsi_order {q} -fsi_h {h} -pulse_start {x} "
            f"-ts_max_time {PULSE_STARTS[x]}"
            for q, x in START_OF.items()
            for h in PULSE_SPACINGS
        },
        **{
            f"{name}_{x}": f"{_QUIET_PULSE} -fsi_order 6 -pulse_start {x} -ts_max_time {t} "
            f"-solid_density {m0} -solid_modulus {K}"
            for name, (m0, K) in SOLIDS.items()
            for x, t in PULSE_STARTS.items()
        },
        **{f"out_{x}": f"{_QUIET_PULSE} -pulse_start {x} -ts_max_time 0.01" for x in PULSE_STARTS},
        "pressed_in": f"{_QUIET_PULSE} {PRESSED} -pulse_start -0.75 -ts_max_time 0.0011",
        "pressed_out": f"{_QUIET_PULSE} {PRESSED} -pulse_start -0.75 -ts_max_time 0.01",
    },
}


class Computed:
    """Results of the groups; what is asked for is computed if need be."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._open: dict[Path, Run] = {}

    def __call__(self, group: str, name: str) -> Run:
        """A result by group and name; the test fails with the error if the run ended with one."""
        folder = self._root / group
        if not folder.exists():
            compute(1, folder, {n: tuple(w.split(" ", 1)) for n, w in GROUPS[group].items()})
        error, path = folder / f"{name}.txt", folder / f"{name}.h5"
        assert not error.exists(), error.read_text()
        if path not in self._open:
            self._open[path] = fsipetsc.open_run(path)
        return self._open[path]


def pytest_configure(config: pytest.Config) -> None:
    """Interrupts reach what the tests start, where a shell has started them in the background and
    told them to ignore those.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    # else Open MPI starts a process of its own for the tests that use MPI in this one, and ends
    # this one when that has gone
    os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Where several processes share MANY tests, each of them has processors of its own, and so has
    all that it starts.

    Ranks on the same ones offer them to each other at once while they wait, and take half of what
    they take where each waits for one that another process's rank has. Of few tests one process may
    have all: it would leave processors idle.
    """
    shared = getattr(session.config, "workerinput", None)
    if shared is not None and len(session.items) > MANY and hasattr(os, "sched_setaffinity"):
        which, every = int(shared["workerid"].removeprefix("gw")), sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, every[which % len(every) :: shared["workercount"]])


def pytest_sessionfinish() -> None:
    """What the ranks have cost is known when they have ended; before who sums up ends
    this process.
    """
    KEPT.close()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The dearest files first: where files are shared out between processes, none is left with one
    of them at the end.
    """
    place = {name: k for k, name in enumerate(DEAREST)}
    items.sort(key=lambda item: place.get(item.path.stem.removeprefix("test_"), len(place)))


@pytest.fixture(scope="session", autouse=True)
def kernels(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Compile what is not compiled yet, once, so that no test waits for it longer than it can."""
    if importlib.util.find_spec("petsc4py") is None or importlib.util.find_spec("numba") is None:
        return
    import numba
    from llvmlite import binding

    from fsipetsc.operators.kernel_cache import use_kernel_cache

    processor = numba.config.CPU_NAME or binding.get_host_cpu_name(), numba.config.CPU_FEATURES
    what = repr((FIRST, sys.version, numba.__version__, processor))  # kernels are of these
    cache = use_kernel_cache()
    done = cache / "tests.done"
    with (cache / "tests.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # several processes of one session may come here at once
        if not done.exists() or done.read_text() != what:
            folder = tmp_path_factory.mktemp("kernels")
            made = compute(1, folder, FIRST)
            wrong = [(folder / f"{name}.txt").read_text() for name in FIRST if name not in made]
            assert not wrong, f"the kernels that all tests need cannot be compiled: {wrong[0]}"
            done.write_text(what)


@pytest.fixture(scope="session")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str, str], Run]]:
    """computed(group, name): the result of one of the runs in GROUPS."""
    yield Computed(tmp_path_factory.mktemp("runs"))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty directory with the driver and a case file, as the working directory."""
    (tmp_path / "driver.py").write_text(DRIVER)
    (tmp_path / "stub.py").write_text(CASE)
    monkeypatch.chdir(tmp_path)
    return tmp_path
