"""What a case is made of, as a table and a picture: blocks, nodes, spacing, what is at faces."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.blocks.block import mesh
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Periodic
from fsipetsc.blocks.faces import BlockFace
from fsipetsc.checks import Array
from fsipetsc.output import drawing
from fsipetsc.output.info import Rows

LINES = 24  # of the grid that are drawn, about, along the axis with most nodes
#: what is between two blocks -> how it is drawn; conditions have a colour each
BETWEEN: dict[str, dict[str, Any]] = {
    "join": {"color": drawing.BLACK, "linewidth": 1.2, "linestyle": (0, (4, 3)), "zorder": 4},
    "interface": {"color": drawing.BLACK, "linewidth": 2.0, "zorder": 5},
}
COLORS = (drawing.GREEN, drawing.ORANGE, drawing.PURPLE, "#56b4e9", "#f0e442", "#888888", "#8c510a")


def _places(problem: BlockProblem, k: int) -> Array:
    """Return places (n_0, n_1, …, d) of the nodes of a block [m], with the end of periodic axes."""
    return problem.places_at(k, mesh([np.arange(n + 1) for n in problem.blocks[k].cells])).T


def _faces(problem: BlockProblem, k: int) -> dict[tuple[int, int], tuple[str, int | None]]:
    """Return (axis, side) -> what is there, and the number of the block there, if one is; nothing
    on a periodic axis.
    """
    block, found = problem.blocks[k], dict[tuple[int, int], tuple[str, int | None]]()
    for face, met in problem.kinds[k].items():
        found[face] = type(met).__name__, None
        if isinstance(met, BlockFace):
            shifted = isinstance(problem.faces.get((block.name, *face)), Periodic)
            alike = problem.blocks[met.block].kind == block.kind
            found[face] = "periodic" if shifted else "join" if alike else "interface", met.block
    return found


def geometry_rows(problem: BlockProblem) -> Rows:
    """Return what the blocks have, a row for each and for each axis."""

    def span(*sizes: Array) -> str:
        least, most = min(of.min() for of in sizes), max(of.max() for of in sizes)
        more = f" to {most:.4g}" * bool(most > 1.000001 * least)
        return f"spacing {least:.4g}{more}{problem.unit('m')}"

    rows, every = [], []
    for k, block in enumerate(problem.blocks):
        X, faces = _places(problem, k), _faces(problem, k)
        sizes = " x ".join(map(str, block.shape))
        rows.append((block.name, f"{drawing.NAMES[block.kind]}, {sizes} nodes"))
        for axis in range(problem.dimension):
            every.append(np.linalg.norm(np.diff(X, axis=axis), axis=-1))
            there = [faces[axis, side] for side in (0, 1) if (axis, side) in faces]
            stands = [
                what if other is None else f"{what} with {problem.blocks[other].name}"
                for what, other in there
            ]
            text = f"from {' to '.join(stands)}" if stands else "periodic"
            rows.append((f"  axis {axis}", f"{span(every[-1])}; {text}"))
    nodes = sum(int(np.prod(block.shape)) for block in problem.blocks)
    return [*rows, ("all", f"{nodes:,} nodes, {span(*every)}")]


def draw_geometry(problem: BlockProblem, name: str, about: str) -> Path:
    """Write the picture NAME-geometry.png; return its path. FileError."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    d, m = problem.dimension, " [m]" * bool(problem.unit("m"))
    with rc_context(drawing.STYLE):
        figure = Figure(figsize=(10.8, 3.4 if d == 1 else 7.0))
        view = figure.add_subplot(projection="3d" if d == 3 else None)
        seen = {what for k in range(len(problem.blocks)) for what, _ in _faces(problem, k).values()}
        styles = {
            what: {"color": color, "linewidth": 3.0, "zorder": 3}
            for what, color in zip(sorted(seen - {*BETWEEN}), COLORS * 9)
        } | BETWEEN
        for k in range(len(problem.blocks)):
            _draw_block(view, problem, k, styles)
        axes = [*"XYZ"[: d - 1], "r" if problem.symmetry else "XYZ"[d - 1]]
        view.set(**{f"{axis}label": f"{X}{m}" for axis, X in zip("xyz", axes)})
        view.grid(visible=False)
        view.use_sticky_edges = False
        view.margins(0.08)
        if d == 1:
            view.yaxis.set_visible(False)
            view.spines["left"].set_visible(False)
        else:
            view.set_aspect("equal")
        view.set_anchor("NW")
        drawing.legend_above(view, "right", most=12, columns=6)
        figure.suptitle(f"{name}: {about}", **drawing.TITLE)
        return drawing.save(figure, Path(f"{name}-geometry.png"))


def _lines(X: Array, apart: int | None = None) -> Iterator[Array]:
    """Yield lines (n, d) of nodes along each axis, so many nodes apart; None: the edges."""
    for axis in range(X.ndim - 1):
        rows = np.moveaxis(X, axis, -2)
        steps = [(n - 1, min(apart or n, n - 1)) for n in rows.shape[:-2]]
        some = [slice(last % step // 2, None, step) for last, step in steps]
        yield from rows[tuple(some)].reshape(-1, *rows.shape[-2:])


def _draw_block(view: drawing.Axes, problem: BlockProblem, k: int, styles: dict[str, Any]) -> None:
    """Draw a block and its faces; grid lines, or in three dimensions the edges."""
    block, X = problem.blocks[k], _places(problem, k)
    color = drawing.COLORS[block.kind]
    if X.ndim == 2:  # a strip of two dimensions
        X = np.stack(np.broadcast_arrays(X, [0.0, 0.5, 1.0]), axis=-1)
    d, label = X.ndim - 1, drawing.NAMES[block.kind]
    if d == 2:
        view.contourf(*X.T, 0.0 * X[..., 0].T, [-1, 1], colors=[color], alpha=0.15)
    apart = -(-max(max(one.cells) for one in problem.blocks) // LINES) if d == 2 else None
    for line in _lines(X, apart):
        view.plot(*line.T, color=color, linewidth=0.5 * (d - 1), alpha=0.6, label=label)
    for (axis, side), (what, other) in _faces(problem, k).items():
        if what not in BETWEEN or other is None or other >= k:  # else it is drawn
            for line in _lines(X.take(-side, axis)):
                view.plot(*line.T, label=what, **styles[what])
    centre = X[tuple(n // 2 for n in X.shape[:-1])]
    paper = {"color": "white", "alpha": 0.7, "pad": 1.0}
    middle: dict[str, Any] = {"ha": "center", "va": "center", "zorder": 9, "fontsize": 8}
    view.text(*centre, block.name, color=color, weight="bold", bbox=paper, **middle)
