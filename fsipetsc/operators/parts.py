"""Compiled functions that only compiled code calls: they become machine code as parts of those that call them, once.

numba optimises each function with all that it calls, and makes machine code of that, before it does the same with who calls
it. Of a function that Python never calls neither is needed: its intermediate code is kept as it is, and goes, with that of all
that it calls, into the function that Python calls, to be optimised there.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import Any

from llvmlite import binding
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import PassManager, _pass_registry
from numba.core.transforms import canonicalize_cfg
from numba.core.typed_passes import DumpParforDiagnostics
from numba.core.untyped_passes import WithLifting


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
            _link(self._shared_module, self, ())
        return self._shared_module


class _Whole(JITCodeLibrary):
    """The machine code of a function that Python calls, made of all parts that it needs."""

    def finalize(self) -> None:
        """Take in each part once, optimise, and make machine code. (numba would take in what each part needs for itself.)"""
        own = {function.name for function in self._final_module.functions if not function.is_declaration}
        _link(self._final_module, self, own)
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._linking_libraries.clear()
        super().finalize()


def _link(module: Any, library: Any, own: Collection[str]) -> None:
    """Link into a module all that its library needs; what is not named in ``own`` is dropped where nobody calls it."""
    for other in _needed(library, {id(library)}):
        module.link_in(other._final_module if isinstance(other, _Part) else other._get_module_for_linking(), preserve=True)
    for function in module.functions:
        if not function.is_declaration and function.linkage == binding.Linkage.external and function.name not in own:
            function.linkage = "linkonce_odr"


def _needed(library: Any, seen: set[int]) -> Iterator[Any]:
    """What a library refers to, and those refer to, each once; ``seen`` are the ids of those that have been met."""
    for other in library._linking_libraries:
        if id(other) not in seen:
            seen.add(id(other))
            yield other
            if isinstance(other, _Part):
                yield from _needed(other, seen)


#: what is not for code without "with" and parallel loops
_UNUSED = (WithLifting, DumpParforDiagnostics)


class _Options(Flags):
    """numba's options of a compilation, which it looks for in dictionaries all the time."""

    __slots__ = ()
    _HASH = hash(Flags())  # that of all: numba makes it of the names

    def __hash__(self) -> int:
        return self._HASH

    def __eq__(self, other: object) -> Any:
        return self is other or (type(other) is _Options and self._values == other._values) or super().__eq__(other)


class _Passes(PassManager):
    """The passes of a compilation, one after the other, and nothing between them."""

    def _runPass(self, index: int, pss: Any, state: Any) -> None:
        """Run one, and put its blocks in order. (numba writes down all arguments, too, and how long variables live.)"""
        pss.analysis = self._analysis
        mutated = pss.run_initialization(state)
        mutated |= pss.run_pass(state)
        mutated |= pss.run_finalizer(state)
        if mutated and _pass_registry.get(type(pss)).mutates_CFG:
            state.func_ir.blocks = canonicalize_cfg(state.func_ir.blocks)


class Part(Compiler):
    """numba's compiler for a function that only compiled code calls."""

    def define_pipelines(self) -> list[PassManager]:
        (usual,) = super().define_pipelines()
        passes = _Passes(usual.pipeline_name)
        passes.passes = [each for each in usual.passes if each[0] not in _UNUSED]
        passes.finalize()
        return [passes]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        self.state.flags = _Options(self.state.flags)
        self.state.library = _Part(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)


class Whole(Compiler):
    """numba's compiler for a function that Python calls."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        self.state.library = _Whole(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


#: what ``njit`` is told of a function that only compiled code calls
PART = {"pipeline_class": Part, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}
