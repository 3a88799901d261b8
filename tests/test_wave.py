"""The case wave: a normal mode of a gas over an elastic layer, followed by the scheme."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import computed

from fsipetsc.cases import wave

DEFAULT = {option.name: option.default for option in wave.OPTIONS}
#: as published with the scheme, by another method
KNOWN = -0.367881432498 + 4.726877249787j


def known(density):
    return wave.both_of({**DEFAULT, "solid_density": density}).mode(2 * np.pi).s


def test_the_spectral_solution():
    assert abs(known(1.0) - KNOWN) < 1e-8


def measured(t, X, displacement):
    """s of a displacement of the interface, by a line through the logarithms of its amplitudes."""
    amplitudes = displacement @ np.exp(-2j * np.pi * np.arange(len(X)) / len(X))
    logs = np.stack([np.log(np.abs(amplitudes)), np.unwrap(np.angle(amplitudes))], axis=1)
    return complex(*np.polyfit(t, logs, 1)[0])


LIGHT = pytest.param(1e-3, 2e-2, marks=pytest.mark.long)


@pytest.mark.parametrize(("density", "most"), [(1.0, 8e-3), LIGHT])
def test_the_scheme_follows_it(tmp_path, density, most):
    """Rates by 16 and 24 columns, order 4: near, and nearer."""
    errors = []
    for n in (16, 24):
        words = f"wave -solid_density {density} -fsi_h {1 / n} -ts_max_time 0.4".split()
        with computed(tmp_path, f"{n}.h5", *words) as result:
            layer = result.layers[0]
            s = measured(result.time, layer.X, layer["y"][:, -1] - layer.Y[-1])
        errors.append(abs(s - known(density)) / abs(s))
    assert errors[0] < most and np.log(errors[0] / errors[1]) / np.log(1.5) > 3.0, errors
