"""Rates of gas have the same bits however a block is cut: in tiles of other sizes, in parts of
ranks, in the first call of a part and in later ones."""

import ctypes
from itertools import pairwise, product

import numpy as np
import pytest

from fsipetsc.equations.gas import Gas
from fsipetsc.kernels import build
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.power_law import ConstantTransport
from fsipetsc.operators.bands import NO_AXIS, Patch, band
from fsipetsc.scheme import gas_volume
from fsipetsc.scheme.gas_force import NoForce, PairForce
from fsipetsc.scheme.gas_forms import EntropyForm

#: dimension, order, nodes, whether there are a viscosity and a force
BLOCKS = {
    "line": (1, 8, (150,), True, False),
    "plane": (2, 4, (60, 30), True, True),
    "plane of order 8": (2, 8, (40, 40), False, True),
    "cube": (3, 4, (36, 20, 18), True, False),
}
#: nodes of a tile along the first axis, its rows in three dimensions, parts along each axis
CUTS = (168, 24, (1, 1, 1)), (72, 8, (1, 1, 1)), (16, 4, (1, 1, 1)), (16, 3, (2, 2, 1))


class Cut:
    """Rates of a block at states, cut in parts and tiles."""

    def __init__(self, name):
        self.d, order, shape, self.viscous, forced = BLOCKS[name]
        d, rng = self.d, np.random.default_rng(1)
        mu, force = 0.02 * self.viscous, (0.1, -0.3, 0.2)[:d] if forced else (0.0,) * d
        self.gas = Gas(PerfectGas(1.4, 287.0), ConstantTransport(), mu, 1.5 * mu, force)
        self.form = EntropyForm(PairForce() if forced else NoForce())
        self.n = (*shape, *(1,) * (3 - d))
        self.bands = [band(order, n - 1) for n in shape] + [NO_AXIS] * (3 - d)
        N = int(np.prod(shape))
        self.metrics, self.potential = rng.normal(size=(d * d + d + 1, N)), rng.normal(size=N)
        self.states = []
        for _ in range(3):  # neighbours are near one another and far apart
            rho, T, J = rng.uniform(1.0, 1.3, N), rng.uniform(0.5, 1.5, N), rng.uniform(0.5, 2.0, N)
            q = self.gas.conserved(J, rho, tuple(rng.normal(size=(d, N))), T)
            self.states.append(np.array(q))

    def rates(self, parts):
        """Of each state, one part after the other."""
        text = gas_volume.gas_text(self.gas, self.d, self.form, self.viscous)
        name = build.name_of(text)
        library = build.loaded(build.kept(name) or build.keep(name, build.made(text)))
        found = [np.full((self.d + 3, *self.n[::-1]), np.nan) for _ in self.states]
        cuts = [list(pairwise(range(0, n + 1, n // c))) for n, c in zip(self.n, parts)]
        for box in product(*cuts):
            reach = [(1 + self.viscous) * band.reach for band in self.bands]
            ends = zip(box, reach, self.n, strict=True)
            ghosted = [(max(a - r, 0), min(b + r, n)) for (a, b), r, n in ends]
            of_part = tuple(slice(*ends) for ends in ghosted[::-1])
            own = tuple(b - a for a, b in box)
            sizes = tuple(b - a for a, b in ghosted)
            patch = Patch(own, sizes, tuple(a - g for (a, _), (g, _) in zip(box, ghosted)))
            bands = [of.part(*ends) for of, ends in zip(self.bands, ghosted)]
            metrics = self.metrics.reshape(-1, *self.n[::-1])[(slice(None), *of_part)]
            metrics = np.ascontiguousarray(metrics.reshape(len(metrics), -1))
            of_kernels = self.gas, self.d, self.form, self.viscous, bands, patch, metrics
            part = gas_volume.GasVolume(*of_kernels)
            if part.potential.size:
                part.potential[:] = self.potential.reshape(self.n[::-1])[of_part].ravel()
            for q, out in zip(self.states, found):
                here = q.reshape(-1, *self.n[::-1])[(slice(None), *of_part)].copy()
                rates = np.full((self.d + 3, *own[::-1]), np.nan)
                inside = tuple(slice(f, f + n) for f, n in zip(patch.first, own))[::-1]
                known = here[(slice(None), *inside)].copy()
                here[(slice(None), *inside)] = np.nan  # a halo alone is enough
                addresses = part.address, known.ctypes.data, here.ctypes.data, rates.ctypes.data
                library.gas_sweep(*map(ctypes.c_void_p, addresses))
                out[(slice(None), *(slice(*ends) for ends in box[::-1]))] = rates
        return found


@pytest.mark.parametrize("name", BLOCKS)
def test_bits_do_not_depend_on_tiles_parts_and_calls(name, monkeypatch):
    cut, expected = Cut(name), None
    for tile, depth, parts in CUTS:
        monkeypatch.setitem(gas_volume.TILES, cut.d, tile)
        monkeypatch.setattr(gas_volume, "DEPTH", depth)
        found = cut.rates([c if n > 1 else 1 for c, n in zip(parts, cut.n)])
        expected = expected or found
        for one, other in zip(expected, found):
            assert np.isfinite(other).all()
            assert np.array_equal(one, other), (tile, depth, parts)
