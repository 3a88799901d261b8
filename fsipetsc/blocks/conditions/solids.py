"""Conditions of solids. Their nodes get forces per unit of the reference coordinates."""

from dataclasses import dataclass

from fsipetsc.blocks.conditions.condition import Condition, Datum, Function
from fsipetsc.equations.vectors import along, scale


@dataclass(frozen=True)
class Clamped(Condition):
    """A face of a solid that is held, or moves as given.

    Args:
        x: `x(*X, t)` returns d positions [m]; None: by the velocity, or at rest.
        T: temperature [K], a number or a function of (*X, t); None: it is not given.
        heat_flux: heat flux into the solid [W/m2], likewise; without either it is insulated.
        velocity: `velocity(*X, t)` returns d velocities [m/s]; without x the face moves so from
            where it is at first.
    """

    x: Function | None = None
    T: Datum = None
    heat_flux: Datum = None
    velocity: Function | None = None
    of = ("solid",)
    part = "clamp"
    holds = True


@dataclass(frozen=True)
class Free(Condition):
    """A face of a solid under a pressure that follows it.

    Args:
        pressure: pressure [Pa], a number or a function of (*X, t).
        T: temperature [K], likewise; None: it is not given.
        heat_flux: heat flux into the solid [W/m2], likewise; without either it is insulated.
    """

    pressure: Datum = 0.0
    T: Datum = None
    heat_flux: Datum = None
    of = ("solid",)
    loaded = True

    @property
    def acts(self) -> bool:
        """Whether there is a pressure."""
        return self.pressure != 0.0


@dataclass(frozen=True)
class Absorbing(Condition):
    """A face beyond which the solid goes on: waves along the normal n leave, of pressure and of
    shear; of oblique ones a part is reflected.

    The traction per area at rest is stress n - Z v, Z = sqrt(m0 Q) with the acoustic tensor Q along
    n at the strain there; unstrained, Z has m0 c_p along n and m0 c_s across.

    Source: Lysmer and Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859-877.

    Args:
        stress: normal stress of the solid beyond [Pa], a tension if above 0, a number or a function
            of (*X, t).
        T: temperature [K], likewise; None: it is not given.
        heat_flux: heat flux into the solid [W/m2], likewise; without either it is insulated.
    """

    stress: Datum = 0.0
    T: Datum = None
    heat_flux: Datum = None
    of = ("solid",)
    loaded = True
    passes = "waves"

    @staticmethod
    def pull(solid, F, T, N, v, stress):
        """stress N - Z v per area at rest."""
        return along(scale(stress, N), -1.0, solid.resistance(F, T, N, v))


@dataclass(frozen=True)
class Roller(Condition):
    """A face of a solid that slides in its plane without friction; also a plane of symmetry.

    Args:
        T: temperature [K], a number or a function of (*X, t); None: it is not given.
        heat_flux: heat flux into the solid [W/m2], likewise; without either it is insulated.
    """

    T: Datum = None
    heat_flux: Datum = None
    of = ("solid",)
    part = "roller"
    holds = True


@dataclass(frozen=True)
class Hinge(Condition):
    """A point of a solid's face that is held, in `points` of a `BlockProblem`; the solid may turn
    about it.
    """

    of = ()  # no condition of a face
