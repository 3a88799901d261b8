"""Compiled functions that only compiled code calls: they become machine code as parts of those that call them, once.

numba optimises each function with all that it calls, and makes machine code of that, before it does the same with who calls
it. Of a function that Python never calls neither is needed: its intermediate code is kept as it is, and goes, with that of all
that it calls, into the function that Python calls, to be optimised there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from llvmlite import binding
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class _NoEnvironment:
    """In the place of the engine that would be told where the Python objects of a function's machine code are."""

    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        """Nothing: there is no such code."""


class _Part(JITCodeLibrary):
    """The intermediate code of a function, and whose it needs."""

    @property
    def codegen(self) -> Any:
        return _NoEnvironment

    def _optimize_functions(self, ll_module: Any) -> None:
        """Only as part of others."""
        ll_module.data_layout = super().codegen._data_layout

    def finalize(self) -> None:
        """Nothing is to be added any more."""
        self._raise_if_finalized()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """0: there is no machine code."""
        self._ensure_finalized()
        return 0

    def _get_module_for_linking(self) -> Any:
        """The code with that of all that it needs, all of it to be dropped where nobody calls it."""
        self._ensure_finalized()
        if self._shared_module is None:
            self._shared_module = self._final_module.clone()
            for library in _needed(self, {id(self)}):
                module = library._final_module if isinstance(library, _Part) else library._get_module_for_linking()
                self._shared_module.link_in(module, preserve=True)
            for function in self._shared_module.functions:
                if not function.is_declaration and function.linkage == binding.Linkage.external:
                    function.linkage = "linkonce_odr"
        return self._shared_module


def _needed(library: Any, seen: set[int]) -> Iterator[Any]:
    """What a library refers to, and those refer to, each once; ``seen`` are the ids of those that have been met."""
    for other in library._linking_libraries:
        if id(other) not in seen:
            seen.add(id(other))
            yield other
            if isinstance(other, _Part):
                yield from _needed(other, seen)


class Part(Compiler):
    """numba's compiler for a function that only compiled code calls."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        self.state.library = _Part(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)


#: what ``njit`` is told of such a function
PART = {"pipeline_class": Part, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}
