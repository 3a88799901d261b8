"""Runs that tests share, each made once in a session; fixtures."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from helpers import REPOSITORY
from helpers import computed as result
from kept_ranks import KEPT

from fsipetsc.output.reader import Run

#: files of tests that take longest where nothing is compiled yet, the longest first
DEAREST = (
    *("kills", "documents", "ranks", "block_ledgers", "failures", "radial", "block_oracle"),
    *("shell", "shock", "time", "flutter", "stability", "process", "orders"),
)
ORDERS = (2, 4, 6, 8)
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
#: orders of the rod that bounces three times
BOUNCES = (4, 8)
#: name -> density and modulus; the wave speed is 500 m/s in all. The gas: 1.16 kg/m3, 347 m/s
SOLIDS = {"light": (1.0, 2.5e5), "middle": (4.0, 1e6), "heavy": (4e4, 1e10)}

#: (-ts_type, -ts_rk_type) -> order
METHODS = {("euler", ""): 1, ("ssp", ""): 2, ("rk", "3bs"): 3, ("rk", "4"): 4, ("rk", "5dp"): 5}
#: of the test of their orders [s]
STEPS = (1e-4, 5e-5)
_SHORT_FALL = "rod -fsi_h 0.1 -ts_max_time 0.004 -fsi_output_dt 1"


def fixed(method: tuple[str, str], dt: float) -> str:
    """Name of the run with a method of METHODS and a fixed step."""
    return f"{''.join(method)}_{dt}"


def _fixed_step(method: tuple[str, str], dt: float) -> str:
    rk_type = f"-ts_rk_type {method[1]}" if method[1] else ""
    return f"-ts_dt {dt / (8 if METHODS[method] == 1 else 1)} -ts_type {method[0]} {rk_type}"


#: cases in which the fused method is compared with PETSc's
FUSED = {
    "rod": "rod -fsi_h 0.05 -ts_max_time 0.05 -fsi_output_dt 0.05",
    "mms": "mms -fsi_h 0.05 -fsi_order 6 -ts_max_time 0.2 -fsi_output_dt 0.1",
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
        **{fixed(m, dt): f"{_SHORT_FALL} {_fixed_step(m, dt)}" for m in METHODS for dt in STEPS},
        "reference": f"{_SHORT_FALL} -ts_dt 6.25e-6 -ts_rk_type 5dp",
    },
    "times": {
        "listed": "rod -fsi_h 0.1 -ts_max_time 0.01 "
        "-fsi_output_times 0,0.0011,0.00234567,0.005,0.0071,0.0071003"
    },
    "pulse": {
        **{
            f"{name}_{x}": f"{_QUIET_PULSE} -fsi_order 6 -pulse_start {x} -ts_max_time {t} "
            f"-solid_density {m0} -solid_modulus {K}"
            for name, (m0, K) in SOLIDS.items()
            for x, t in PULSE_STARTS.items()
        },
        **{f"out_{x}": f"{_QUIET_PULSE} -pulse_start {x} -ts_max_time 0.01" for x in PULSE_STARTS},
    },
}


def pytest_configure(config: pytest.Config) -> None:
    """Interrupts reach what the tests start, also where a shell in the background ignores them."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    # else Open MPI starts a process of its own for the tests that use MPI in this one, and ends
    # this one when that has gone
    os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Of processes that share many tests each has a part of the processors, so that its ranks wait
    for each other alone.
    """
    shared = getattr(session.config, "workerinput", None)
    if shared is not None and len(session.items) > 300:
        which, every = int(shared["workerid"].removeprefix("gw")), sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, every[which % len(every) :: shared["workercount"]])


def pytest_sessionfinish() -> None:
    KEPT.close()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The dearest files first: no process is left with one of them at the end."""
    place = {name: k for k, name in enumerate(DEAREST)}
    items.sort(key=lambda item: place.get(item.path.stem.removeprefix("test_"), len(place)))


@pytest.fixture(scope="session")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Run]:
    """computed(group, name): the result of one of the runs in GROUPS, made once."""
    folder = tmp_path_factory.mktemp("runs")

    @cache
    def get(group: str, name: str) -> Run:
        return result(folder, f"{group}_{name}.h5", *GROUPS[group][name].split())

    return get


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty directory as the working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
