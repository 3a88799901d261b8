"""What tests cost: seconds of processors by file, and kernels that were compiled, said at the end
of a session.
"""

from __future__ import annotations

import resource
import time
from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest
from kept_ranks import KEPT

#: files that are named
_DEAREST = 12
#: test file -> seconds of processors: of its tests and fixtures, and of what they start
_spent: Counter[str] = Counter()
_start, _before = time.time(), 0.0


def _processors() -> float:
    """Seconds of processors that this process, those that it has seen the end of, and jobs of those
    that it keeps have had.
    """
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return KEPT.cost + sum(u.ru_utime + u.ru_stime for u in used)


def pytest_runtest_logstart() -> None:
    global _before
    _before = _processors()


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport() -> Iterator[None]:
    """Set-up, call and clean-up of a test each make a report, which takes what it cost to the
    process that sums up.
    """
    global _before
    outcome: Any = yield
    now = _processors()
    outcome.get_result().cost, _before = now - _before, now


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    _spent[report.nodeid.split("::")[0]] += getattr(report, "cost", 0.0)


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """(In the process that sums up alone: those that it shares the tests among have
    no terminal.)
    """
    if sum(_spent.values()) < 60.0:
        return
    terminalreporter.section("costs")
    dearest = ", ".join(
        f"{name.split('test_')[-1][:-3]} {cost:.0f}" for name, cost in _spent.most_common(_DEAREST)
    )
    whole, wall = _processors(), time.time() - _start
    say = terminalreporter.line
    say(f"{whole:.0f} s of processors in {wall:.0f} s; {_compiled()} kernels compiled")
    say(f"tests and fixtures {sum(_spent.values()):.0f} s, the dearest files: {dearest}")


def _compiled() -> int:
    """Files of kernels that have come into the cache since the session began."""
    try:
        from fsipetsc.operators.kernel_cache import use_kernel_cache
    except ModuleNotFoundError:
        return 0
    return sum(path.stat().st_mtime > _start for path in use_kernel_cache().rglob("*.nbc"))
