"""Runs of problems of blocks: their state, steps, snapshots and what is saved.

The function ``fsipetsc.run`` has the same name as this package, which takes its place when it is
imported; so the package can be called, too.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _Callable(ModuleType):
    """A package that is called as the function ``fsipetsc.run``."""

    def __call__(self, case: Any, *, comm: Any = None, **options: Any) -> Any:
        from fsipetsc.api import run

        return run(case, comm, options)


sys.modules[__name__].__class__ = _Callable
