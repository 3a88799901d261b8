"""Conditions of solids. Their nodes get forces per unit of the reference coordinates:

    free       p_b n(x), n(x) the area vector of the face where it is now: a pressure that follows
               it
    absorbing  (stress N - Z v) |A|, N the unit normal and |A| the area at rest, Z the tensor
               sqrt(m0 Q) of the acoustic tensor Q along N (fsipetsc.equations.solid)
"""

from dataclasses import dataclass
from types import MappingProxyType

from fsipetsc.blocks.conditions.condition import Datum, Function, OfSolid
from fsipetsc.checks import ANY
from fsipetsc.equations.vectors import along, scale


@dataclass(frozen=True)
class Clamped(OfSolid):
    """The solid is held where it is, or moved to x(*X, t) -> d positions [m]; heat as of a NoSlip.

    With velocity(*X, t) -> d velocities [m/s] alone it moves so from where it is at first.
    """

    x: Function | None = None
    T: Datum = None
    heat_flux: Datum = None
    velocity: Function | None = None
    part = "clamp"
    holds = free_velocity = True


@dataclass(frozen=True)
class Free(OfSolid):
    """A pressure [Pa] that follows the face of the solid; heat as of a NoSlip."""

    pressure: Datum = 0.0
    T: Datum = None
    heat_flux: Datum = None
    ranges = OfSolid.ranges | {"pressure": ANY}
    at_faces = MappingProxyType({**OfSolid.at_faces, "pressure": ("pressure",)})
    loaded = True

    @property
    def acts(self) -> bool:
        """Whether there is a pressure."""
        return self.pressure != 0.0


@dataclass(frozen=True)
class Absorbing(OfSolid):
    """The solid goes on beyond the face, under a stress [Pa], a tension if above 0: waves along the
    normal n pass, of pressure and of shear; of oblique ones a part is reflected. The traction per
    area at rest is stress n - Z v, Z = sqrt(m0 Q) with the acoustic tensor Q along n at the strain
    there; unstrained, Z has m0 c_p along n and m0 c_s across. Heat as of a NoSlip.

    Source: Lysmer and Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859-877.
    """

    stress: Datum = 0.0
    T: Datum = None
    heat_flux: Datum = None
    ranges = OfSolid.ranges | {"stress": ANY}
    at_faces = MappingProxyType({**OfSolid.at_faces, "stress": ("stress",)})
    loaded = True
    passes = "waves"

    @staticmethod
    def pull(solid, F, T, N, v, stress):
        """stress N - Z v per area at rest."""
        return along(scale(stress, N), -1.0, solid.resistance(F, T, N, v))


@dataclass(frozen=True)
class Roller(OfSolid):
    """The solid slides along the face's plane without friction; or a plane of symmetry. Heat as of
    a NoSlip.
    """

    T: Datum = None
    heat_flux: Datum = None
    part = "roller"
    holds = True


@dataclass(frozen=True)
class Hinge(OfSolid):
    """A point of a solid's face that is held, among a problem's points; the solid may turn."""
