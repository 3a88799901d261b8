"""What can be drawn of a run: its labels, and how it follows from what is stored."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fsipetsc.checks import Array
from fsipetsc.errors import InputError
from fsipetsc.output.reader import Run
from fsipetsc.output.units import FIELDS, unit_of, written
from fsipetsc.scheme.observables import GAIN, SERIES

#: series of what a step brought, not of what there is after it
GAINS = [name for name, one in SERIES.items() if one.kind == GAIN]
#: fields of blocks whose mean is drawn beside the pressure
_NORMAL = "s_xx", "s_yy", "s_zz", "sigma_theta"


class Quantity(NamedTuple):
    """What can be drawn: a name, and kind of layer -> label."""

    name: str
    labels: dict[str, str]

    @property
    def unit(self) -> str:
        return written(unit_of(self.name))

    @property
    def title(self) -> str:
        """What is shown of gases, then of solids if that is something else."""
        return "; ".join(dict.fromkeys(self.labels.values()))

    def signed(self, kind: str) -> bool:
        """Whether its sign means something: not of pressures, densities and temperatures."""
        return "stress" in self.labels[kind] or self.name not in ("p", "rho", "T", "schlieren")

    def values(self, kind: str, fields: Mapping[str, Array]) -> Array:
        """From the fields of a layer of this kind and X; beside the pressure of gases stands what
        a solid pushes with, in one dimension, or the mean of its normal stresses.
        """
        if self.name == "p" and kind == "solid" and "sigma" in fields:
            return fields["p"] - fields["sigma"]
        if self.name == "p" and kind == "solid":
            return np.mean([fields[name] for name in _NORMAL if name in fields], axis=0)
        if self.name == "schlieren":
            return np.sqrt(np.linalg.norm(_gradient(fields["rho"], fields), axis=-1))
        if self.name == "strain":  # by differences of second order
            return np.gradient(fields["x"], fields["X"], axis=-1, edge_order=2) - 1.0
        return fields[self.name]


def _gradient(values: Array, fields: Mapping[str, Array]) -> Array:
    """(…, d) in space, of values on a curved grid, by differences of second order."""
    places = [fields[x] for x in "xyz" if x in fields]
    along = [np.stack(np.gradient(v, edge_order=2), axis=-1) for v in (*places, values)]
    return np.linalg.solve(np.stack(along[:-1], axis=-1), along[-1][..., None])[..., 0]


def there(run: Run) -> list[Quantity]:
    """What can be drawn of this run."""
    stored = {layer.kind: {*layer.fields} for layer in run.layers}
    found = []
    for name, (label, _) in FIELDS.items():
        labels = {
            kind: label for kind in ("fluid", "solid") if label and name in stored.get(kind, ())
        }
        if name == "schlieren" and run.dimension > 1 and "fluid" in stored:
            labels["fluid"] = label
        if "solid" in stored and name == "p":
            labels["solid"] = f"{'p − σ' if run.dimension == 1 else 'mean stress'} in solids"
        if "solid" in stored and name == "strain" and run.dimension == 1:
            labels["solid"] = label
        found += [Quantity(name, labels)] * bool(labels)
    return found


def chosen(run: Run, names: Sequence[str]) -> list[Quantity]:
    """Those of these names, or what a page shows where there are none. InputError."""
    known = {quantity.name: quantity for quantity in there(run)}
    for name in names:
        if name not in known:
            raise InputError(f"-fields {name}: expected some of {', '.join(known)}")
    usual = ("u", "T", "p") if run.dimension == 1 else ("p",)
    return [known[name] for name in names or usual if name in known]
