"""How tests are run; what many of them use."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from kept_ranks import KEPT

#: files of tests that take longest where nothing is compiled yet, the longest first
DEAREST = (
    *("kills", "documents", "ranks", "block_ledgers", "orders", "failures", "radial"),
    *("block_oracle", "shell", "shock", "time", "flutter", "stability", "process"),
)
#: files of tests with many kernels, in this process, and few nodes
FEW_NODES = (
    *("block_oracle", "radial", "gravity", "gases_apart", "block_ledgers", "block_conditions"),
    *("where_faces_meet", "block_monitor"),
)
ORDERS = (2, 4, 6, 8)


def pytest_configure(config: pytest.Config) -> None:
    """Interrupts reach what the tests start, also where a shell in the background ignores them."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    # else Open MPI starts a process of its own for the tests that use MPI in this one, and ends
    # this one when that has gone
    os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Processes that share many tests share the processors: ranks wait for each other alone."""
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


@pytest.fixture(scope="module", autouse=True)
def kernels_of_few_nodes(request: pytest.FixtureRequest) -> Iterator[None]:
    """Kernels of FEW_NODES are compiled in an eighth of the time, without optimisation, which
    changes no bit (tests/test_bits.py); those of other processes as always.
    """
    few = request.path.stem.removeprefix("test_") in FEW_NODES and "CFLAGS" not in os.environ
    if few:
        os.environ["CFLAGS"] = "-O0"
    yield
    if few:
        del os.environ["CFLAGS"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty directory as the working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
