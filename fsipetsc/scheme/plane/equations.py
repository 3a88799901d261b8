"""The equations that the material of a layer in two dimensions asks for, and the forms that they may have."""

from __future__ import annotations

from typing import NamedTuple

from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas
from fsipetsc.physics.dissipation import IN_LOOPS
from fsipetsc.physics.material_law import formulas_of
from fsipetsc.physics.own_laws import check
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.physics.plane.dissipation import dissipative
from fsipetsc.physics.plane.gas import plane_gas
from fsipetsc.physics.plane.solid import plane_solid
from fsipetsc.physics.plane.two_point import two_point_gas
from fsipetsc.plane import PlaneFluidLayer, PlaneSolidLayer


class PlaneForm(NamedTuple):
    """How the equations are put in discrete terms.

    convection: of gases, "entropy" (two-point form, which conserves entropy; of perfect gases) or "divergence".
    dissipation: sigma of fsipetsc.physics.plane.dissipation, shocks: S, 0 for none.
    """

    convection: str = "entropy"
    dissipation: float = 0.0
    shocks: float = 0.0


USUAL = PlaneForm()


def equations_of(layer: PlaneFluidLayer | PlaneSolidLayer, form: PlaneForm) -> Formulas:
    """Those of a layer's material. InputError if there is no such form of them."""
    material, dissipates = layer.material, form.dissipation > 0.0 or form.shocks > 0.0
    if isinstance(layer, PlaneSolidLayer):
        if dissipates:
            return dissipative(plane_solid(material.formulas))
        return plane_solid(material.formulas, material.heat == "elastic" and material.kappa_e == 0.0)
    gas, transport = formulas_of(material.law), formulas_of(material.transport)
    if dissipates and not getattr(gas, "knows_entropy", True):
        what = "no formula entropy(c, rho, T), which -fsi_dissipation and -fsi_shock need"
        raise InputError(f"layer '{layer.name}': its gas law has {what}")
    if dissipates and getattr(gas, "own", False):
        check(gas, "gas", IN_LOOPS)
    viscous = material.mu > 0.0 or material.kappa > 0.0
    if form.convection == "divergence":
        found = plane_gas(gas, transport, viscous)
    elif gas is perfect_gas:
        found = two_point_gas(gas, transport, viscous)
    else:
        raise InputError(
            f"layer '{layer.name}': -fsi_convection entropy needs a perfect gas, and this one has a law of its own: "
            "expected -fsi_convection divergence"
        )
    return dissipative(found) if dissipates else found


def materials_of(layer: PlaneFluidLayer | PlaneSolidLayer) -> Formulas:
    """The same where the form does not matter, but for what the material is: so that less has to be compiled."""
    material = layer.material
    if isinstance(layer, PlaneSolidLayer):
        return plane_solid(material.formulas)
    return two_point_gas(formulas_of(material.law), formulas_of(material.transport), True)
