"""Gases of different laws with solids between them (gases.py): each has its own temperature."""

import gases
import numpy as np
from helpers import computed


def test_a_steady_flow_of_heat_stays(tmp_path):
    """Through all layers, from a wall of T = 1 to one of T = 2."""
    errors = []
    for cells in (12, 24):
        words = "-gases_T", "1,2", "-fsi_order", "6", "-fsi_h", f"{1 / cells}"
        run = computed(tmp_path, f"{cells}.h5", gases.__file__, *words)
        frames = [layer.frame(-1) for layer in run.layers]
        x, T = (np.concatenate([frame[name] for frame in frames]) for name in ("x", "T"))
        errors.append(np.abs(T - gases.profile(x, (1.0, 2.0))).max())
    assert errors[1] < min(1e-6, errors[0] / 8)
