"""What is recorded of each step: an entry for each series. What must not change of it.

An entry has all that is known of a series but what computes it. Sums over nodes are computed by
name in fsipetsc.scheme.gas_terms and solid_procedures. Columns of records, units, labels of
pictures, what `diff` adds up, and the table of the site follow from the entries.
"""

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import numpy as np

#: letters of axes, of positions and of velocities
PLACES, VELOCITIES = "xyz", "uvw"
#: a component of momentum less than this part of sqrt(energy times mass) is round-off
LEAST_COMPONENT = 1e-3
TINY = np.finfo(float).tiny


class Entry(NamedTuple):
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
        axes = zip(PLACES[:d], VELOCITIES[:d], strict=True)
        return list(dict.fromkeys(self.name.replace("*", x).replace("@", u) for x, u in axes))


STEP, EXTREME, INTEGRAL, PLACE, GAIN = "step", "extreme", "integral", "place", "gain"
_AT_ENDS, _MOVED = "at an interface in one dimension", "displacement of the interface"
_LOSSY = 'kinetic and elastic energy of solids with `heat="elastic"`'
_MISSED = "velocities", "stresses", "temperatures", "heat fluxes"
_PAPERS = "in the paper's method"
_APART = {name: f"by how much {name} are apart there, {_PAPERS}" for name in _MISSED}
_LINE, _PAPER = (PLACE, "interface", "line"), (PLACE, "interface", "paper")
_POINT, _MEAN = (PLACE, "point", ""), "of a solid minus its mean normal stress"
#: in the order of the columns of a record of blocks
TABLE = (
    Entry("t", "s", "time after the step", STEP),
    Entry("dt", "s", "length of the step", STEP),
    Entry("least_J", "1", "smallest J", EXTREME, "layer", label="least J"),
    Entry("J_error", "1", "|J − det D x|/J, the largest", EXTREME, "layer", label="departure of J"),
    Entry("mass", "kg", "mass", INTEGRAL, "gas", label="change of mass"),
    Entry("energy", "J", "energy", INTEGRAL, label="change of energy"),
    Entry("momentum_*", "N s", "momentum", INTEGRAL, label="change of momentum *"),
    Entry("entropy", "J K-1", "entropy of gases", INTEGRAL, label="change of entropy"),
    Entry("angular_momentum", "J s", "angular momentum about the origin", INTEGRAL, needs="plane"),
    Entry("angular_momentum_*", "J s", "the same in three dimensions", INTEGRAL, needs="space"),
    Entry("solid_energy", "J", _LOSSY, INTEGRAL, needs="lossy"),
    Entry("potential_energy", "J", "−Σ m f·x with a constant force f", INTEGRAL, needs="pulled"),
    Entry("x_interface", "m", f"position of the solid {_AT_ENDS}", *_LINE, label=_MOVED),
    Entry("u_interface", "m s-1", f"its velocity {_AT_ENDS}", *_LINE, label="velocity u"),
    Entry("sigma_interface", "Pa", f"its stress σ {_AT_ENDS}", *_LINE, label="stress σ"),
    Entry("T_interface", "K", f"its temperature {_AT_ENDS}", *_LINE, label="temperature T"),
    Entry("residual_u", "m s-1", _APART["velocities"], *_PAPER, label="|residual|, velocity"),
    Entry("residual_stress", "Pa", _APART["stresses"], *_PAPER, label="|residual|, stress"),
    Entry("residual_T", "K", _APART["temperatures"], *_PAPER, label="|residual|, temperature"),
    Entry("residual_flux", "W m-2", _APART["heat fluxes"], *_PAPER, label="|residual|, heat flux"),
    Entry("momentum", "N s", f"momentum, {_PAPERS}", INTEGRAL, needs="paper", label="momentum"),
    Entry("*_point", "m", "position of a node that is recorded", *_POINT, label="change of *"),
    Entry("@_point", "m s-1", "its velocity", *_POINT, label="velocity *"),
    Entry("T_point", "K", "its temperature", *_POINT, label="temperature T"),
    Entry("p_point", "Pa", f"its pressure; {_MEAN}", *_POINT, label="pressure p"),
    Entry("mass_in", "kg", "mass that came in", GAIN, "gas"),
    Entry("lost_energy", "J", "what the step lost of `solid_energy`", GAIN, needs="lossy"),
    Entry("force_work", "J", "work of constant forces", GAIN, needs="pulled"),
    Entry("impulse_*", "N s", "momentum that came in", GAIN),
    Entry("energy_face", "J", "energy that came in through a face", GAIN, "face"),
    Entry("heat_face", "J", "what of it was heat by `T` or `heat_flux`", GAIN, "face"),
    Entry("energy_in", "J", "all energy that came in", GAIN),
)
#: name -> entry
SERIES: Mapping[str, Entry] = {name: one for one in TABLE for name in one.names(3)}


def record(names: Collection[str], counts: Mapping[str, int]) -> list[tuple[Any, ...]]:
    """Columns of doubles of these names, for a numpy dtype; counts: how many of each ``of``."""
    shapes = ((name, (counts[of],) if (of := SERIES[name].of) else ()) for name in names)
    return [(name, "f8", shape) for name, shape in shapes if 0 not in shape]


@np.errstate(all="ignore")  # a drift that is no number says so itself
def drifts(
    held: Mapping[str, Any], first: Mapping[str, Any], series: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Relative drifts of the invariants that must hold, after each step: name -> (steps,).

    On blocks these are masses, all components of momentum, and energy, less all that comes in; the
    entropy of gases where nothing comes in and solids take no heat from them.

    held: which ones must hold (fsipetsc.blocks.block_problem.BlockProblem.invariants). first: the
    integrals before the first step of the series. Entropy counts only where it decreases. Momentum
    is relative to the impulse that has passed, of either sign, energy to itself, entropy to itself
    or to the heat capacity, whatever is more.
    """
    found: dict[str, np.ndarray] = {}
    if not held or not len(series.get("dt", ())):
        return found
    for name, columns in held["masses"]:  # several of blocks of gas that are joined
        mass, came = (series[of][:, columns].sum(axis=1) for of in ("mass", "mass_in"))
        before = sum(first["mass"][column] for column in columns)
        found[f"mass of '{name}'"] = (mass - np.cumsum(came)) / before - 1
    mass_of_all = held.get("inertia", 0.0) + sum(np.asarray(first.get("mass", ())).tolist())
    momentum_of_all = np.sqrt(max(first.get("energy", 0.0), 0.0) * mass_of_all)
    for axis in held.get("momentum", ""):
        name, given = f"momentum_{axis}", series[f"impulse_{axis}"]
        passed, came = np.cumsum(np.abs(given)), np.cumsum(given)
        least = max(abs(first[name]), LEAST_COMPONENT * momentum_of_all, TINY)
        change = series[name] - first[name] - came
        found[f"momentum along {axis}"] = change / np.maximum(passed, least)
    if held["energy"]:
        found["energy"] = (series["energy"] - np.cumsum(series["energy_in"])) / first["energy"] - 1
    if held.get("entropy"):
        produced = series["entropy"] - first["entropy"]
        most = np.maximum(np.maximum.accumulate(produced), 0.0)
        scale = max(abs(first["entropy"]), held["heat_capacity"], TINY)
        found["entropy"] = (most - produced) / scale
    return found
