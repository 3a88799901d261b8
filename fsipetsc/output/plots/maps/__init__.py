"""Pictures of a result in two dimensions: maps on the grids as they are, lines of the interfaces, what is kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

from fsipetsc.output.plots import steps
from fsipetsc.output.plots.maps import interfaces, ledgers, panels, stresses
from fsipetsc.output.plots.maps.quantities import MAPS
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def pictures(run: Run, times: Sequence[float] | None = None) -> Iterator[tuple[str, Callable[[Figure], None]]]:
    """Names and drawing functions of the pictures that this run has the data for."""
    if run.nframes:
        for pair in MAPS:
            yield pair.name, partial(panels.draw, run=run, pair=pair, times=times)
        if any(layer.kind == "solid" for layer in run.layers):
            yield "stress", partial(stresses.draw, run=run, times=times)
    if run.nframes > 2 and run.interfaces:
        yield "interfaces", partial(interfaces.draw, run=run)
    if len(run.series.get("t", ())) > 1:
        yield "ledgers", partial(ledgers.draw, run=run)
        yield "steps", partial(steps.draw, run=run)
