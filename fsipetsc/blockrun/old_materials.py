"""Materials of layers as those for blocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.solid_pressure import Gruneisen


def gas_of(material: Fluid, force: Sequence[float]) -> Fluid:
    """A gas under a body force per mass [m/s2], or its own."""
    return replace(material, force=tuple(force)) if any(force) else material


def line_solid_of(material: Solid, p_ref: float) -> ElasticSolid:
    """A solid in one dimension, whose stress is K ln x_X - p_ref less its pressure."""
    pressure = material.pressing
    if pressure is None and material.gruneisen > 0.0:
        pressure = Gruneisen(material.gruneisen)
    numbers = material.kappa_e, material.m0, material.alpha, p_ref
    return ElasticSolid(0.0, material.K, *numbers, force=material.force, pressing=pressure)
