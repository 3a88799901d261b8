"""Earlier names of modules of fsipetsc.materials, for case files that import them."""

from __future__ import annotations

import sys
from types import SimpleNamespace

from fsipetsc.materials import fluid, line_solid, own, power_law, solid_pressure, sutherland

_stiffened = SimpleNamespace(stiffened_gas=solid_pressure.stiffened_pressure)
for _name, _module in {
    "fluid": fluid,
    "solid": line_solid,
    "own_laws": own,
    "power_law": power_law,
    "sutherland": sutherland,
    "mie_gruneisen": solid_pressure,
    "stiffened_gas": _stiffened,
}.items():
    sys.modules[f"{__name__}.{_name}"] = _module  # type: ignore[assignment]
