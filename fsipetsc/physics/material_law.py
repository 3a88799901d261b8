"""A law of a material and its numbers: what a layer's ``law``, ``transport`` or ``pressing`` may be.

The formulas of a law are compiled. Its numbers are data: ``constants(record)`` finds them in the record of a layer or an
interface, as record.gas_numbers, record.transport_numbers or record.pressing_numbers. So other numbers need no compiler, and
layers with the same formulas and other numbers share what is compiled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fsipetsc.checks import described, formulas, number
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas
from fsipetsc.physics.layer import NUMBERS


@dataclass(frozen=True)
class Law:
    """Formulas and numbers, at most NUMBERS of them. InputError for what is no finite number, or too many."""

    formulas: Formulas
    numbers: tuple[float, ...]

    def __post_init__(self) -> None:
        given = self.numbers
        if isinstance(given, str) or not isinstance(given, Sequence) or len(given) > NUMBERS:
            raise InputError(f"numbers of a law: {described(given)}: expected a tuple of at most {NUMBERS} numbers")
        checked = tuple(number(value, f"numbers of a law: numbers[{k}]") for k, value in enumerate(given))
        object.__setattr__(self, "numbers", checked)


def formulas_of(law: Formulas | Law) -> Formulas:
    """The formulas of a law."""
    return law.formulas if isinstance(law, Law) else law


def numbers_of(law: Formulas | Law) -> tuple[float, ...]:
    """The numbers of a law as they stand in a record: NUMBERS of them, zeros behind its own."""
    own = law.numbers if isinstance(law, Law) else ()
    return (*own, *(0.0,) * (NUMBERS - len(own)))


def check_law(law: Formulas | Law, what: str, member: str, form: str) -> None:
    """InputError if a value is no law that has this formula; form: where one comes from."""
    formulas(formulas_of(law), what, member, form)
