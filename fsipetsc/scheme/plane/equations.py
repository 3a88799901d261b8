"""The equations that the material of a layer in two dimensions asks for."""

from __future__ import annotations

from fsipetsc.operators.formulas import Formulas
from fsipetsc.physics.material_law import formulas_of
from fsipetsc.physics.plane.gas import plane_gas
from fsipetsc.physics.plane.solid import plane_solid
from fsipetsc.plane import PlaneFluidLayer, PlaneSolidLayer


def equations_of(layer: PlaneFluidLayer | PlaneSolidLayer) -> Formulas:
    """Those of a layer: without friction and conduction where the gas has none."""
    material = layer.material
    if isinstance(layer, PlaneSolidLayer):
        return plane_solid(material.formulas)
    return plane_gas(formulas_of(material.law), formulas_of(material.transport), material.mu > 0 or material.kappa > 0)
