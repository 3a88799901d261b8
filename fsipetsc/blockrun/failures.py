"""Where and how a state of blocks became unphysical, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.blockrun.columns import fields_of
from fsipetsc.blockrun.run_problem import PLACES, VELOCITIES
from fsipetsc.stepping.diagnosis import Seen, described

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState
    from fsipetsc.parallel.block_layout import Part


def describe_failure(state: BlockState, t: float, step: int) -> str:
    """Field, block, position, time and step of the first unphysical node. Collective."""
    return described(state, (_seen(state, part) for part in state.layout.parts), t, step)


def _seen(state: BlockState, part: Part) -> Seen:
    problem, d = state.problem, state.problem.dimension
    kind, m = problem.layers[part.k].kind, problem.unit("m")
    columns = dict(zip(fields_of(kind, d, problem.symmetry), state.fields(part.k).T, strict=True))
    names = (
        ("J", "rho", *VELOCITIES[:d], "T")
        if kind == "fluid"
        else (*PLACES[:d], *VELOCITIES[:d], "T")
    )
    if kind == "solid":  # a temperature of a law of J < 0 is no number: J says more
        columns["J"] = state.scheme.volume_ratio(state.y, part.k)
        names = ("J", *names)
    values = {name: columns[name] for name in names}
    X = problem.places(part.k, part.numbers)

    def place(i: int) -> str:
        now = ", ".join(f"{name} = {columns[name][i]:.6g}{m}" for name in PLACES[:d])
        then = ", ".join(f"{c.upper()} = {X[i, axis]:.6g}{m}" for axis, c in enumerate(PLACES[:d]))
        return f"{now} ({then})"

    positive = frozenset(("J", "rho", "T"))
    return Seen(part.k, np.asarray(part.numbers), values, positive, place)
