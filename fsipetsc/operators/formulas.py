"""Formulas that are handed to compiled functions: a gas law, the fluxes of a physics.

Compiled functions take a ``Formulas`` as an argument and call its members by name, ``law.pressure(...)``. numba compiles a
version for each one that is handed in, so that a call of a member is a call of that very function, inlined like any other:
nothing is looked up while the program runs.
"""

from __future__ import annotations

from types import CellType, FunctionType
from typing import TYPE_CHECKING, Any

from numba import types
from numba.core.imputils import lower_constant, lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import models, overload, register_model, typeof_impl

from fsipetsc.operators.parts import PART


class Formulas:
    """Compiled functions, numbers, tuples and other formulas, by name."""

    def __init__(self, **members: Any) -> None:
        self.__dict__.update(members)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


class FormulasType(types.Dummy):
    """numba's type of one ``Formulas``: each is a type of its own."""

    def __init__(self, formulas: Formulas) -> None:
        self.formulas = formulas
        super().__init__(f"formulas {id(formulas)}")


@typeof_impl.register(Formulas)
def _type_of(formulas, context):
    return FormulasType(formulas)


register_model(FormulasType)(models.OpaqueModel)


@infer_getattr
class _Members(AttributeTemplate):
    key = FormulasType

    def generic_resolve(self, kind, name):
        return self.context.resolve_value_type(getattr(kind.formulas, name))


@lower_constant(FormulasType)
def _nothing(context, builder, kind, value):
    return context.get_dummy_value()


@lower_getattr_generic(FormulasType)
def _member(context, builder, kind, value, name):
    member = getattr(kind.formulas, name)
    of_kind = context.typing_context.resolve_value_type(member)
    if isinstance(of_kind, types.Dummy):  # a function, or formulas: the type says it all
        return context.get_dummy_value()
    return context.get_constant_generic(builder, of_kind, member)


_UNROLLED = {**PART, "forceinline": True, "error_model": "numpy"}  # whatever the size: vectors stay in registers


def in_python(function: Any) -> Any:
    """A formula as Python has it, for numbers and arrays; so are those that it calls: from its closure, and of this package."""
    plain = getattr(function, "py_func", function)
    if not isinstance(plain, FunctionType):
        return plain
    cells, scope = plain.__closure__ or (), plain.__globals__
    ours = {name: scope[name] for name in plain.__code__.co_names if _is_ours(scope.get(name))}
    if not ours and not any(hasattr(cell.cell_contents, "py_func") for cell in cells):
        return plain
    inner = tuple(CellType(in_python(cell.cell_contents)) for cell in cells)
    scope = {**scope, **{name: in_python(value) for name, value in ours.items()}}
    return FunctionType(plain.__code__, scope, plain.__name__, plain.__defaults__, inner)


def _is_ours(value: Any) -> bool:
    """Whether this is a compiled function of this package: most of those cannot be called from Python."""
    return getattr(getattr(value, "py_func", None), "__module__", "").startswith("fsipetsc.")


def each(function: Any, *arguments: Any) -> tuple[Any, ...]:
    """(function(a[0], ...), function(a[1], ...), ...) of the tuples a among the arguments, each other one given to each call.

    Tuples have the same length. function: a member of formulas.
    """
    count = max(len(a) for a in arguments if type(a) is tuple)
    return tuple(function(*(a[k] if type(a) is tuple else a for a in arguments)) for k in range(count))


@overload(each, strict=False, jit_options=_UNROLLED)
def _each(function, *arguments):
    kinds = arguments[0] if len(arguments) == 1 and isinstance(arguments[0], types.StarArgTuple) else arguments
    tuples = [isinstance(kind, (types.UniTuple, types.Tuple)) for kind in kinds]
    count = max(len(kind) for kind, taken in zip(kinds, tuples, strict=True) if taken)
    calls = (
        f"function({', '.join(f'arguments[{a}][{k}]' if taken else f'arguments[{a}]' for a, taken in enumerate(tuples))})"
        for k in range(count)
    )
    return _made(f"return ({''.join(call + ', ' for call in calls)})", "function, *arguments")


def with_chosen(function: Any, choices: tuple[Any, ...], index: int, *arguments: Any) -> Any:
    """function(choices[index], *arguments): one of some formulas, found when the program runs. function: as in ``each``."""
    return function(choices[index], *arguments)


@overload(with_chosen, strict=False, jit_options=_UNROLLED)
def _with_chosen(function, choices, index, *arguments):
    last = len(choices) - 1
    lines = [f"if index == {k}:\n        return function(choices[{k}], *arguments)" for k in range(last)]
    lines.append(f"return function(choices[{last}], *arguments)")
    return _made("\n    ".join(lines), "function, choices, index, *arguments")


def _made(body: str, parameters: str) -> Any:
    scope: dict[str, Any] = {}
    exec(f"def made({parameters}):\n    {body}", scope)
    return scope["made"]
