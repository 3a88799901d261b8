"""How tests are run; what many of them use."""

import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from kept_ranks import KEPT

#: files of tests that take longest, the longest first
DEAREST = (
    *("kills", "documents", "block_oracle", "bits", "ranks", "orders", "kernels", "plots"),
    *("stability", "time", "restart", "failures", "studies", "shell", "gravity"),
)
#: files of tests with runs of many steps
MANY_STEPS = (
    *("kills", "line_cases", "orders", "shock", "shell", "topics", "new_case", "verify"),
    *("studies", "ranks", "restart"),
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
    gc.freeze()  # what is there by now stays: the collector need not visit it again and again
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
def flags_of_kernels(request: pytest.FixtureRequest) -> Iterator[None]:
    """Kernels are compiled in an eighth of the time, without optimisation, which changes no bit
    (tests/test_bits.py), but not for MANY_STEPS, nor in processes that tests start themselves."""
    many = request.path.stem.removeprefix("test_") in MANY_STEPS
    with pytest.MonkeyPatch.context() as patch:
        if not many and "CFLAGS" not in os.environ:
            patch.setenv("CFLAGS", "-O0")
        yield


@pytest.fixture
def quick_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures, on which nothing is looked for, without what takes longest to draw."""
    from fsipetsc.output import drawing

    quick = {"figure.constrained_layout.use": False, "axes.formatter.use_mathtext": False}
    for name, value in {**quick, "savefig.dpi": 40}.items():
        monkeypatch.setitem(drawing.STYLE, name, value)
    for name in ("FILM_DPI", "HTML_DPI"):
        monkeypatch.setattr(f"fsipetsc.output.page.{name}", 40)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty directory as the working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
