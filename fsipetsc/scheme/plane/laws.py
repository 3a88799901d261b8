"""The physics of the layers of a problem in two dimensions, with what the scheme does with each of them.

Entries (fsipetsc.scheme.plane.entries) name GAS and SOLID, the laws of most problems; for another law they are compiled
once more with it in the place of these (fsipetsc.operators.variants), layer by layer.
"""

from __future__ import annotations

from typing import Any

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.variants import Variants, digest
from fsipetsc.physics.constant_transport import constant_transport
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.own_laws import check
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.physics.plane.log_solid import log_solid
from fsipetsc.physics.plane.solid import plane_solid
from fsipetsc.physics.plane.two_point import two_point_gas
from fsipetsc.scheme.plane.dissipation import dissipate_across, dissipate_along
from fsipetsc.scheme.plane.edges import amend_gas, amend_solid
from fsipetsc.scheme.plane.geometry import lay, no_grid
from fsipetsc.scheme.plane.kinetic import keep_power, leave_power
from fsipetsc.scheme.plane.pairs import give_pairs
from fsipetsc.scheme.plane.sums import complete, meet, no_sums


def law(equations: Formulas) -> Formulas:
    """Equations of ``fsipetsc.physics.plane`` and the work of the scheme on the edges of their layer."""
    pairs, dissipation = hasattr(equations, "pair"), hasattr(equations, "dissipation")
    work = {
        "amend": amend_gas if equations.kind == FLUID else amend_solid,
        "keep": leave_power if equations.kind == FLUID else keep_power,
        "looks_ahead": int(dissipation or len(equations.differentiated) > 0),
        "lay": lay if equations.kind == FLUID else no_grid,
        "meet": meet if equations.sums else no_sums,
        "give": give_pairs if pairs else complete,
        "dissipate_across": dissipate_across if dissipation else no_sums,
        "dissipate_along": dissipate_along if dissipation else no_sums,
    }
    return Formulas(**vars(equations), **work)


GAS, SOLID = law(two_point_gas(perfect_gas, constant_transport, True)), law(plane_solid(log_solid))
#: digest -> what has been compiled for the law
_VARIANTS: dict[str, Variants] = {}
_BUILT_IN = {digest(GAS), digest(SOLID)}


def compiled(entry: Any, equations: Formulas) -> Any:
    """An entry for a layer of these equations, which may be those that it names. InputError for formulas of a stress that
    cannot be compiled.
    """
    wanted = law(equations)
    name = digest(wanted)
    if name in _BUILT_IN:
        return entry
    if name not in _VARIANTS:
        elastic: Any = getattr(wanted, "elastic", None)
        if getattr(elastic, "own", False) and not Variants.on_disk(f"plane-{name}"):
            check(elastic.plain, "elastic")
        _VARIANTS[name] = Variants(((GAS if wanted.kind == FLUID else SOLID, wanted),), f"plane-{name}")
    return _VARIANTS[name].of(entry)
