"""What a case says of a solid."""

from dataclasses import dataclass
from typing import Any

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, described, numbers
from fsipetsc.equations.solid import AxialSolid, RadialSolid, Solid
from fsipetsc.errors import InputError
from fsipetsc.materials import own
from fsipetsc.materials.compressible import Log, NeoHookean
from fsipetsc.materials.fluid import checked_force, force_in
from fsipetsc.materials.hooke import LinearElastic, StVenantKirchhoff
from fsipetsc.materials.solid_pressure import ConstantPressure

#: laws by name
LAWS = {"log": Log, "neo-hookean": NeoHookean, "svk": StVenantKirchhoff, "linear": LinearElastic}
HEATS = ("coupled", "elastic")


@dataclass(frozen=True)
class ElasticSolid:
    """A hyperelastic solid of blocks, with heat conduction.

    In two dimensions the strain is plane, but around an axis; in one it is uniaxial.
    [Materials](materials.md) has the stresses with their sources.

    Args:
        mu_e: Lamé's constant of shear [Pa].
        lambda_e: Lamé's other constant [Pa].
        kappa_e: heat conductivity [W/(m K)].
        m0: density in the reference state [kg/m3].
        alpha: specific heat [J/(kg K)].
        p_ref: pressure under which the solid is free of strain [Pa].
        law: "log", "neo-hookean", "svk", "linear", or what `solid_law` returns, which knows its own
            constants.
        heat: "coupled": the work of stresses becomes heat; "elastic": the elastic energy is stored
            beside the heat.
        force: body force per mass [m/s2], a number in one dimension, else d numbers.
        pressing: None, or what `gruneisen`, `mie_gruneisen` or `pressure_law` returns, which adds
            -p cof F to the stress.
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
        ranges = {"mu_e": NONNEGATIVE, "lambda_e": NONNEGATIVE, "kappa_e": NONNEGATIVE}
        numbers(self, "ElasticSolid", {**ranges, "m0": POSITIVE, "alpha": POSITIVE, "p_ref": ANY})
        if self.heat not in HEATS:
            expected = " or ".join(map(repr, HEATS))
            raise InputError(f"ElasticSolid: heat is {described(self.heat)}: expected {expected}")
        object.__setattr__(self, "force", checked_force(self.force, "ElasticSolid"))
        law = self.solid_law
        if self.heat == "elastic" and not own.knows_energy(law):
            needs = "its law has no formula energy(F), which heat='elastic' needs"
            raise InputError(f"ElasticSolid: {needs}")
        self.pressure_law  # noqa: B018  (checks it)

    @property
    def solid_law(self) -> Any:
        """The stress as formulas."""
        if not isinstance(self.law, str):
            return own.checked_law(self.law, "ElasticSolid: law", own.SOLID)
        if self.law not in LAWS:
            known = f"{', '.join(map(repr, LAWS))} or what solid_law(…) returns"
            raise InputError(f"ElasticSolid: law is {described(self.law)}: expected {known}")
        if not self.K > 0.0:
            problem = "mu_e and lambda_e are 0: expected one of them above 0"
            raise InputError(f"ElasticSolid: {problem}")
        return LAWS[self.law](self.mu_e, self.lambda_e, self.p_ref)

    @property
    def pressure_law(self) -> Any:
        """The pressure as a formula."""
        law = ConstantPressure() if self.pressing is None else self.pressing
        return own.checked_law(law, "ElasticSolid: pressing", own.PRESSURE)

    @property
    def K(self) -> float:
        """2 mu_e + lambda_e [Pa]."""
        return 2.0 * self.mu_e + self.lambda_e

    def equations(self, d: int) -> Solid:
        """Its equations in d dimensions; InputError if force has not d numbers.

        In three dimensions p_ref is left out of the stress: faces have it (fsipetsc.blockrun.
        face_terms), so that a solid under p_ref is at rest exactly.
        """
        return Solid(*self._in(d, d == 3), force_in(self.force, d, "ElasticSolid"))

    def radial_equations(self, symmetry: int, d: int = 1) -> RadialSolid:
        """Its equations around an axis (1) or a centre (2), without p_ref, too. InputError."""
        force, kind = force_in(self.force, d, "ElasticSolid"), (RadialSolid, AxialSolid)[d - 1]
        p_ref = self.p_ref if isinstance(self.law, str) else 0.0
        return kind(*self._in(symmetry + d, True), force, (0.0,) * symmetry, p_ref)

    def _in(self, d: int, without_p_ref: bool) -> tuple[Any, ...]:
        """The laws and constants that the equations take."""
        law, coupled = self.solid_law, self.heat == "coupled"
        if without_p_ref and isinstance(self.law, str):
            law = law._replace(p_ref=0.0)
        own.check_solid_law(law, d)
        return law, self.pressure_law, self.m0, self.alpha, self.kappa_e, coupled
