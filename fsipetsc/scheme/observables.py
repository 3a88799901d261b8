"""What is recorded of each step: an entry for each series.

An entry has all that is known of a series but what computes it. Sums over nodes are computed by
name in fsipetsc.scheme.gas_procedures and solid_procedures. Columns of records, units, labels of
pictures, what `diff` adds up, and the table of the site follow from the entries.
"""

from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

#: letters of axes, of positions and of velocities
PLACES, VELOCITIES = "xyz", "uvw"


class Observable(NamedTuple):
    """A series. name: a * in it stands for each of x, y, z, an @ for each of u, v, w.

    what: it is, in words. unit: of integrals that in three dimensions. kind: of the step itself;
    an extreme of all ranks; else ranks' shares are added up: an integral over space; a place's; a
    gain in the step, which is an integral, too. of: what has a number each: layer, gas, interface,
    point, face; "" where it is one number. needs: what a problem must have for it. label: of
    pictures; one that begins with "change" is drawn less its value at t = 0.
    """

    name: str
    unit: str
    what: str
    kind: str
    of: str = ""
    needs: str = ""
    label: str = ""

    def names(self, d: int) -> list[str]:
        """The names of the series in d dimensions."""
        axes = zip(PLACES[:d], VELOCITIES[:d], strict=True)
        found = (self.name.replace("*", x).replace("@", u) for x, u in axes)
        return list(dict.fromkeys(found))


STEP, EXTREME, INTEGRAL, PLACE, GAIN = "step", "extreme", "integral", "place", "gain"
_AT_ENDS, _MISSED = "at an interface in one dimension", "are apart there, in the paper's method"
#: in the order of the columns of a record of blocks
TABLE = (
    Observable("t", "s", "time after the step", STEP),
    Observable("dt", "s", "length of the step", STEP),
    Observable("least_J", "1", "smallest J", EXTREME, "layer", label="least J"),
    Observable(
        "J_error", "1", "|J − det D x|/J, the largest", EXTREME, "layer", label="departure of J"
    ),
    Observable("mass", "kg", "mass", INTEGRAL, "gas", label="change of mass"),
    Observable("energy", "J", "energy", INTEGRAL, label="change of energy"),
    Observable("momentum_*", "N s", "momentum", INTEGRAL, label="change of momentum *"),
    Observable("entropy", "J K-1", "entropy of gases", INTEGRAL, label="change of entropy"),
    Observable(
        "angular_momentum", "J s", "angular momentum about the origin", INTEGRAL, needs="plane"
    ),
    Observable(
        "angular_momentum_*", "J s", "the same in three dimensions", INTEGRAL, needs="space"
    ),
    Observable(
        "solid_energy",
        "J",
        'kinetic and elastic energy of solids with `heat="elastic"`',
        INTEGRAL,
        needs="lossy",
    ),
    Observable(
        "potential_energy", "J", "−Σ m f·x with a constant force f", INTEGRAL, needs="pulled"
    ),
    Observable(
        "x_interface",
        "m",
        f"position of the solid {_AT_ENDS}",
        PLACE,
        "interface",
        "line",
        "displacement of the interface",
    ),
    Observable(
        "u_interface", "m s-1", f"its velocity {_AT_ENDS}", PLACE, "interface", "line", "velocity u"
    ),
    Observable(
        "sigma_interface",
        "Pa",
        f"its stress σ {_AT_ENDS}",
        PLACE,
        "interface",
        "line",
        "stress σ",
    ),
    Observable(
        "T_interface",
        "K",
        f"its temperature {_AT_ENDS}",
        PLACE,
        "interface",
        "line",
        "temperature T",
    ),
    *(
        Observable(name, unit, f"by how much {what} {_MISSED}", PLACE, "interface", "paper", label)
        for name, unit, what, label in (
            ("residual_u", "m s-1", "velocities", "|residual|, velocity"),
            ("residual_stress", "Pa", "stresses", "|residual|, stress"),
            ("residual_T", "K", "temperatures", "|residual|, temperature"),
            ("residual_flux", "W m-2", "heat fluxes", "|residual|, heat flux"),
        )
    ),
    Observable(
        "momentum", "N s", "momentum, in the paper's method", INTEGRAL, "", "paper", "momentum"
    ),
    Observable("*_point", "m", "position of a node that is recorded", PLACE, "point"),
    Observable("@_point", "m s-1", "its velocity", PLACE, "point"),
    Observable("T_point", "K", "its temperature", PLACE, "point"),
    Observable(
        "p_point", "Pa", "its pressure; of a solid minus its mean normal stress", PLACE, "point"
    ),
    Observable("t_*_point", "Pa", "traction on the solid there, at an interface", PLACE, "point"),
    Observable("mass_in", "kg", "mass that came in", GAIN, "gas"),
    Observable("lost_energy", "J", "what the step lost of `solid_energy`", GAIN, needs="lossy"),
    Observable("force_work", "J", "work of constant forces", GAIN, needs="pulled"),
    Observable("impulse_*", "N s", "momentum that came in", GAIN),
    Observable("energy_face", "J", "energy that came in through a face", GAIN, "face"),
    Observable("heat_face", "J", "what of it was heat by `T` or `heat_flux`", GAIN, "face"),
    Observable("energy_in", "J", "all energy that came in", GAIN),
)
#: name -> entry
SERIES: Mapping[str, Observable] = {name: one for one in TABLE for name in one.names(3)}


def record(names: Collection[str], counts: Mapping[str, int]) -> list[tuple[Any, ...]]:
    """Columns of doubles of these names, for a numpy dtype; counts: how many there are of each
    ``of``. A column of none is left out.
    """
    found: list[tuple[Any, ...]] = []
    for name in names:
        of = SERIES[name].of
        if counts.get(of, 1):
            found.append((name, "f8", (counts[of],)) if of else (name, "f8"))
    return found


def of_blocks(has: Collection[str], d: int, kinds: Collection[str]) -> Iterator[str]:
    """Names of the series of these kinds of blocks in d dimensions; has: what the problem has."""
    for one in TABLE:
        if one.kind in kinds and (not one.needs or one.needs in has):
            yield from one.names(d)
