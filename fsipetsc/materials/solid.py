"""What a case says of a solid: ElasticSolid of blocks, Solid of layers."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, described, numbers
from fsipetsc.equations.elasticity import Solid as Equations
from fsipetsc.equations.elasticity import pressure_slopes
from fsipetsc.errors import InputError
from fsipetsc.materials import own
from fsipetsc.materials.fluid import force_in
from fsipetsc.materials.hyperelastic import LinearElastic, Log, NeoHookean, StVenantKirchhoff
from fsipetsc.materials.solid_pressure import NoPressure, gruneisen

#: laws by name
LAWS = {"log": Log, "neo-hookean": NeoHookean, "svk": StVenantKirchhoff, "linear": LinearElastic}


@dataclass(frozen=True)
class ElasticSolid:
    """A hyperelastic solid of blocks, with heat conduction.

    In two dimensions the strain is plane, but around an axis; in one it is uniaxial.
    [Materials](materials.md) has the stresses with their sources.

    Args:
        mu_e: Lamé's constant of shear [Pa].
        lambda_e: Lamé's other constant [Pa], not below -2/3 mu_e.
        kappa_e: heat conductivity [W/(m K)].
        m0: density in the reference state [kg/m3].
        alpha: specific heat [J/(kg K)].
        p_ref: pressure under which the solid is free of strain [Pa].
        law: "log", "neo-hookean", "svk", "linear", or what `solid_law` returns, which knows its own
            constants.
        heat: "coupled": the work of stresses becomes heat; "elastic": the elastic energy is stored
            beside the heat.
        force: body force per mass [m/s2], a number in one dimension, else d numbers.
        pressing: None, or a law such as `gruneisen` or `mie_gruneisen`, which adds -p cof F to the
            stress.
    """

    mu_e: float
    lambda_e: float
    kappa_e: float
    m0: float
    alpha: float
    p_ref: float = 0.0
    law: Any = "log"
    heat: str = "coupled"
    force: float | tuple[float, ...] = 0.0
    pressing: Any = None
    kind = "solid"

    def __post_init__(self) -> None:
        ranges = {"mu_e": NONNEGATIVE, "lambda_e": ANY, "kappa_e": NONNEGATIVE}
        numbers(self, "ElasticSolid", {**ranges, "m0": POSITIVE, "alpha": POSITIVE, "p_ref": ANY})
        if 3.0 * self.lambda_e < -(2.0 + 1e-12) * self.mu_e:  # K of a sphere is below 0
            wrong = f"lambda_e is {self.lambda_e:g}: expected a number not below -2/3 mu_e"
            raise InputError(f"ElasticSolid: {wrong}")
        if self.heat not in ("coupled", "elastic"):
            wanted = "expected 'coupled' or 'elastic'"
            raise InputError(f"ElasticSolid: heat is {described(self.heat)}: {wanted}")
        object.__setattr__(self, "force", force_in(self.force, 0, "ElasticSolid"))
        law, _ = self.solid_law, self.pressure_law
        if self.heat == "elastic" and not own.knows_energy(law):
            raise InputError("ElasticSolid: no formula energy(F), which heat='elastic' needs")

    @property
    def solid_law(self) -> Any:
        if not isinstance(self.law, str):
            return own.checked_law(self.law, "ElasticSolid: law", own.SOLID)
        if self.law not in LAWS:
            known = f"{', '.join(map(repr, LAWS))} or what solid_law(…) returns"
            raise InputError(f"ElasticSolid: law is {described(self.law)}: expected {known}")
        if not self.K > 0.0:
            raise InputError("ElasticSolid: mu_e and lambda_e are 0: expected one of them above 0")
        return LAWS[self.law](self.mu_e, self.lambda_e, self.p_ref)

    @property
    def pressure_law(self) -> Any:
        law = NoPressure() if self.pressing is None else self.pressing
        return own.checked_pressure(law, "ElasticSolid: pressing")

    @property
    def K(self) -> float:
        """2 mu_e + lambda_e [Pa]."""
        return 2.0 * self.mu_e + self.lambda_e

    def equations(self, d: int, symmetry: int = 0) -> Equations:
        """Its equations, also around an axis (1) or a centre (2); InputError if force has not d
        numbers. In three dimensions, around an axis or a centre, and of a law of a case faces have
        p_ref, not the stress (fsipetsc.stepping.block_part): under it a solid is at rest exactly.
        """
        force, law = force_in(self.force, d, "ElasticSolid"), self.solid_law
        if isinstance(self.law, str) and (symmetry or d == 3):
            law = law._replace(p_ref=0.0)
        own.check_solid_law(law, d + symmetry)
        numbers = self.m0, self.alpha, self.kappa_e, self.heat == "coupled", force
        at_faces = self.p_ref if symmetry else 0.0
        return Equations(law, self.pressure_law, *numbers, (0.0,) * symmetry, at_faces)


class Elastic(NamedTuple):
    """The solid of the paper in one dimension, (4.19), as formulas (fsipetsc.paper.rates).

    law: of the pressure p [Pa] of J = x_X, T, m0 and alpha; the rest is as in ``Solid``.
    """

    law: Any
    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float

    def pressure(self, T, x_X):
        return self.law.pressure(x_X, T, self.m0, self.alpha)

    def pressure_slopes(self, T, x_X):
        """dp/dx_X [Pa] and dp/dT [Pa/K]."""
        return pressure_slopes(self.law, x_X, T, self.m0, self.alpha)

    def wave_modulus(self, T, p, sigma, x_X):
        """m0 c^2 [Pa] of elastic waves in Lagrangian coordinates: what (3.1b-d) make of
        (sigma - p)_t over u_X, (K - x_X p_x + x_X p_T (p - sigma)/(alpha m0))/x_X."""
        p_x, p_T = self.pressure_slopes(T, x_X)
        return (self.K - x_X * p_x + x_X * p_T * (p - sigma) / (self.alpha * self.m0)) / x_X


@dataclass(frozen=True)
class Solid:
    """The elastic material of a layer in one dimension, whose stress sigma grows as K ln x_X.

    It also has a pressure p, which is 0 unless a law is given: the stress is sigma - p.

    Source: B. Sjögreen and J. W. Banks, Commun. Comput. Phys. 13 (2013), (3.1) and (4.19).

    Args:
        K: 2 mu_e + lambda_e [Pa].
        kappa_e: heat conductivity [W/(m K)].
        m0: density in the reference state [kg/m3].
        alpha: specific heat [J/(kg K)].
        force: body force per mass [m/s2].
        gruneisen: G of the pressure p = G rho alpha T; 0: p = 0.
        pressing: its law without gruneisen, such as `mie_gruneisen`.
    """

    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float = 0.0
    gruneisen: float = 0.0
    pressing: Any = None

    def __post_init__(self) -> None:
        ranges = {"K": POSITIVE, "kappa_e": NONNEGATIVE, "m0": POSITIVE, "alpha": POSITIVE}
        numbers(self, "Solid", {**ranges, "force": ANY, "gruneisen": NONNEGATIVE})
        if self.pressing is not None and self.gruneisen != 0.0:
            raise InputError(f"Solid: gruneisen is {self.gruneisen:g} beside pressing: expected 0")
        self.pressure(1.0)  # refuses a law that is none

    @property
    def pressure_law(self) -> Any:
        if self.pressing is not None:
            return own.checked_pressure(self.pressing, "Solid: pressing")
        return gruneisen(self.gruneisen) if self.gruneisen > 0.0 else NoPressure()

    @property
    def elastic(self) -> Elastic:
        return Elastic(self.pressure_law, self.K, self.kappa_e, self.m0, self.alpha, self.force)

    def pressure(self, T: Any, x_X: Any = 1.0) -> Any:
        """The pressure p [Pa] at T [K] and the stretch x_X, numbers or arrays of one shape."""
        return self.elastic.pressure(T, x_X)

    def sound_speed(self, x_X: float = 1.0, T: float = 0.0, sigma: float = 0.0) -> float:
        """Speed of small waves in Lagrangian coordinates [m/s], without conduction, at the stretch
        x_X, the temperature T [K] and the stress sigma [Pa].
        """
        solid = self.elastic
        return float(solid.wave_modulus(T, solid.pressure(T, x_X), sigma, x_X) / self.m0) ** 0.5
