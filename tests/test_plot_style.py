"""Colors and titles of pictures, whatever they show."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("petsc4py")
import matplotlib
from matplotlib.figure import Figure

from fsipetsc.output.plots import style, titles


def test_colors_differ_in_lightness_or_hue():
    """For eyes that see no difference between red and green, too."""
    for colors in (list(style.COLORS.values()), [color for color, _ in style.ORDERS.values()], style.SERIES):
        for i, a in enumerate(colors):
            assert all(np.abs(seen(a) - seen(b)).max() > 0.12 for b in colors[:i]), colors


def seen(color):
    """A color as eyes with deuteranopia see it, by a linear model."""
    model = np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]])
    return np.clip(model @ np.power(matplotlib.colors.to_rgb(color), 2.2), 0, 1) ** (1 / 2.2)


@pytest.mark.parametrize(
    "title", ["short", "Fig. 7: errors over wall time  (--quick: coarser grids)", 40 * "word "]
)
def test_titles_are_not_cut_off(title):
    figure = Figure(figsize=(4.8, 3.8))
    titles.set_title(figure, title)
    box = figure._suptitle.get_window_extent(figure.canvas.get_renderer())
    assert 0 <= box.x0 and box.x1 <= figure.bbox.width
    assert figure._suptitle.get_text().split() == title.split()


def test_sweep_can_be_read_and_told_apart():
    """Cells where all is well differ from every color of the others, for all eyes, and the numbers are no fine print."""
    from fsipetsc.output.plots.stability import NUMBERS, WELL

    shades = [seen(matplotlib.colormaps["Oranges"](value)[:3]) for value in np.linspace(0, 1, 20)]
    assert min(np.abs(seen(WELL) - shade).max() for shade in shades) > 0.06 and NUMBERS >= 9
