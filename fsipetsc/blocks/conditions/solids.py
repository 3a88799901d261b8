"""Conditions of solids. Their nodes get forces per unit of the reference coordinates."""

from dataclasses import dataclass

from fsipetsc.blocks.conditions.condition import Condition, Datum, Moving, Warm
from fsipetsc.equations.vectors import along, scale


@dataclass(frozen=True)
class Clamped(Warm, Moving):
    """A face of a solid that is held, or moves as given.

    Heat as of `Warm`, motion as of `Moving`. With a velocity and no x the face moves so from where
    it is at first.
    """

    of = ("solid",)
    part = "clamp"
    holds = True


@dataclass(frozen=True)
class Free(Warm):
    """A face of a solid under a pressure that follows it.

    Args:
        pressure: pressure [Pa], a number or a function of (*X, t).
        T, heat_flux: as of `Warm`.
    """

    pressure: Datum = 0.0
    of = ("solid",)
    loaded = True

    @property
    def acts(self) -> bool:
        """Whether there is a pressure."""
        return self.pressure != 0.0


@dataclass(frozen=True)
class Absorbing(Warm):
    """A face beyond which the solid goes on: waves along the normal n leave, of pressure and of
    shear; of oblique ones a part is reflected.

    The traction per area at rest is stress n - Z v, Z = sqrt(m0 Q) with the acoustic tensor Q along
    n at the strain there; unstrained, Z has m0 c_p along n and m0 c_s across.

    Source: Lysmer and Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859-877.

    Args:
        stress: normal stress of the solid beyond [Pa], a tension if above 0, a number or a function
            of (*X, t).
        T, heat_flux: as of `Warm`.
    """

    stress: Datum = 0.0
    of = ("solid",)
    loaded = True
    passes = "waves"

    @staticmethod
    def pull(solid, F, T, N, v, stress):
        """stress N - Z v per area at rest."""
        return along(scale(stress, N), -1.0, solid.resistance(F, T, N, v))


@dataclass(frozen=True)
class Roller(Warm):
    """A face of a solid that slides in its plane without friction; also a plane of symmetry.

    Heat as of `Warm`.
    """

    of = ("solid",)
    part = "roller"
    holds = True


@dataclass(frozen=True)
class Hinge(Condition):
    """A point of a solid's face that is held, in `points` of a `BlockProblem`; the solid may turn
    about it.
    """

    of = ()  # no condition of a face
