"""A box of many arrays, which a compiled function takes like one number.

A NamedTuple of forty arrays costs 5 us at each call from Python, its box 0.7 us. Compiled code gets
the fields of a box one by one: it loads those that it names, and counts references to no others.

Functions in a box are called by address, which takes some 5 ns. A function that is called by name
is optimised once more in each caller: of a chain of callers the whole chain.
"""

import warnings
from collections.abc import Iterable
from hashlib import sha256
from typing import Any

from numba import njit, typeof, types
from numba.core.errors import NumbaExperimentalFeatureWarning
from numba.experimental import structref
from numba.extending import overload

from fsipetsc.operators.loops import CALL

# numba says of calls by address that they are experimental, to whoever compiles a case
warnings.filterwarnings("ignore", "First-class function", NumbaExperimentalFeatureWarning)


@structref.register
class BoxType(types.StructRef):
    """numba's type of a box: names and types of its fields.

    numba calls compiled functions by the names of the types that they take, and would put all
    fields of all boxes within into each: so a type has a short name.
    """

    def __init__(self, fields: Any) -> None:
        super().__init__(fields)
        self.name = f"Box{sha256(self.name.encode()).hexdigest()[:16]}"


class Box(structref.StructRefProxy):
    """Has the fields of ``record``, a NamedTuple; compiled code changes its arrays."""

    def __new__(cls, record: Any) -> Any:
        return boxed(record)


structref.define_boxing(BoxType, Box)
structref.define_attributes(BoxType)


@overload(Box, jit_options={"no_cpython_wrapper": True, "no_cfunc_wrapper": True})
def _box(record):
    kind = BoxType(tuple(zip(record.fields, record.types, strict=True)))
    lines = [f" box.{name} = record.{name}\n" for name in record.fields]
    space: dict[str, Any] = {"new": structref.new, "kind": kind}
    exec("def box(record):\n box = new(kind)\n" + "".join(lines) + " return box\n", space)
    return space["box"]


@njit(**CALL)
def boxed(record):
    """A box of a NamedTuple."""
    return Box(record)


def with_calls(kind: Any, box: Any, calls: Iterable[tuple[Any, tuple[Any, ...]]]) -> Any:
    """A box of a ``kind``, a NamedTuple class: of a box and functions of it.

    calls: compiled functions, examples of what they take after ``box``. None returns anything.
    """
    functions, examples = zip(*calls, strict=True)
    signatures = [types.void(typeof(box), *map(typeof, more)) for more in examples]
    takes = types.NamedTuple((typeof(box), *map(types.FunctionType, signatures)), kind)
    boxed.compile((takes,))
    # called for just these types: numba would look for them among those of other boxes, and fail
    return boxed.get_overload((takes,))(kind(box, *functions))
