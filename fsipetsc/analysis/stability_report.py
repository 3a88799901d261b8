"""Tables and the picture of the stability analysis."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.analysis.stability_measures import ENERGY_TOLERANCE, MODE_TOLERANCE, Result
from fsipetsc.analysis.stability_state import Constant, described_law
from fsipetsc.operators import operator
from fsipetsc.output.plots.style import drawing
from fsipetsc.output.plots.titles import set_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_THEORY = {
    "energy": "orthogonal projection, all four conditions at once (Theorem 4.1)",
    "projection": "temperatures first, then u, sigma, rho (Theorem 4.2)",
    "conservative": "the end points are one particle; mass, momentum and energy are kept",
    "traditional": "the solid moves the fluid, the fluid loads the solid",
}

#: color of the cells where all is well, and size of the numbers in the picture
WELL, NUMBERS = "#cfe3f3", 10
#: rows of the picture: label, number, and when all is well
_ROWS = (
    ("energy growth  [1/s]", "energy_growth", "estimate"),
    ("fastest mode  [1/s]", "mode_growth", "stable"),
    ("RK4 step by that without coupling", "step_ratio", "step_kept"),
)


def heading(opt: Mapping[str, Any], state: Constant) -> str:
    """What is analysed, in a few lines."""
    gas, solid, p = state.gas, state.solid, state.p
    n, h, coupling = opt["stability_points"], opt["fsi_h"], opt["fsi_coupling"]
    speed, eos = state.sound_speed, f"p = G rho eps, G = {solid.gruneisen:.4g}" if solid.gruneisen else "elastic, p = 0"
    if solid.pressing is not None:
        eos = f"pressure by {described_law(solid.pressing)}"
    laws = "".join(f"; {described_law(law)}" for law in (gas.law, gas.transport) if law is not None)
    rest = f"x_X {state.stretch:g}, pressure of the solid {state.solid_pressure:g} Pa, sigma {state.stress:g} Pa\n"
    rest += f"           sound in the gas {speed:.3g} m/s"
    if opt["sweep"]:
        body = f"m0 and K from the ratios, alpha m0 {solid.alpha * solid.m0:g} J/(m3 K)"
    else:
        waves = solid.sound_speed(state.stretch, state.T, state.stress)
        rest += f", waves in the solid {waves:.3g} m/s"
        body = f"m0 {solid.m0:g} kg/m3, K {solid.K:g} Pa, alpha {solid.alpha:g} J/(kg K)"
        rest += f"\n  ratios   m0/rho {solid.m0 / state.rho:g}, K/p {solid.K / p:g}"
    return f"""\
stability of {coupling}: {_THEORY[coupling]}
solid | gas, linearised at rest (4.2); {n} points of h = {h:g} m in each, {opt["fsi_viscous"]} second derivatives

  gas      rho {state.rho:g} kg/m3, T {state.T:g} K, p {p:g} Pa, gamma {gas.gamma:g}, R {gas.R:g} J/(kg K)
           mu {state.mu:g} Pa s, kappa {state.kappa:g} W/(m K){laws}
  solid    {body}
           kappa {solid.kappa_e:g} W/(m K); {eos}
  at rest  {rest}
"""


def verdict(result: Result) -> str:
    """One phrase about a result."""
    if not result.stable:
        return "a mode grows"
    if not result.step_kept:
        return "stable, but at smaller steps"
    return "energy never grows" if result.estimate else "stable, but the energy may grow for a while"


def one_state(results: Sequence[Result]) -> str:
    """A line for each order."""
    heated = any(r.heated_energy_growth != r.energy_growth for r in results)
    head = ("order", "energy grows", "fastest mode", "largest |lambda|", "RK4 step up to", "of uncoupled")
    units = ("", "[1/s]", "[1/s]", "[1/s]", "[s]", "")
    rows = [
        (
            operator(r.order).name,
            _rate(r.energy_growth, r.estimate),
            _rate(r.mode_growth, r.stable),
            f"{r.radius:.4g}",
            f"{r.step:.4g}",
            f"{r.step_ratio:.4f}",
        )
        for r in results
    ]
    widths = [max(map(len, column)) for column in zip(head, units, *rows, strict=True)]
    lines = ["  ".join(f"{text:>{w}}" for text, w in zip(row, widths, strict=True)) for row in (head, units, *rows)]
    lines[2:] = [f"{line}   {verdict(r)}" for line, r in zip(lines[2:], results, strict=True)]
    worst = max(results, key=lambda r: r.energy_growth / r.radius)
    growth = f"{max(worst.energy_growth, 0.0) / worst.radius:.1e} |lambda|"
    if worst.estimate:
        lines += ["", f"0 stands for round-off: the energy grows by {growth} at most."]
    else:
        lines += ["", f"The energy estimate does not hold: the energy grows by up to {growth}."]
    if heated:
        lines += ["", *_heating(results)]
    return "\n".join(lines) + "\n"


def _rate(value: float, nothing: bool) -> str:
    return "0" if nothing else f"{value:.3g}"


def _heating(results: Sequence[Result]) -> list[str]:
    """What the stress at rest adds."""
    growing = [r for r in results if not r.heated_stable]
    lines = [
        "These numbers leave out the heat that the stress at rest sets free, sigma u_X/(alpha m0), which is not the",
        f"interface's doing. With it the energy grows at up to {max(r.heated_energy_growth for r in results):.3g} 1/s",
    ]
    fastest = max(r.heated_mode_growth for r in results)
    lines[-1] += (
        f", and a mode at up to {fastest:.3g} 1/s ({len(growing)} of {len(results)})." if growing else ", but no mode does."
    )
    return lines


def sweep_tables(results: Sequence[Result]) -> str:
    """A block for each order: energy growth, fastest mode and step limit over the ratios."""
    limits = f"{ENERGY_TOLERANCE:.0e} |lambda| for the energy, {MODE_TOLERANCE:.0e} |lambda| for modes"
    lines = [f"Rates in 1/s; · is round-off, below {limits}."]
    densities, stiffnesses = ratios(results)
    columns: tuple[tuple[str, Callable[[Result], str]], ...] = (
        ("energy grows", lambda r: "·" if r.estimate else f"{r.energy_growth:.1e}"),
        ("fastest mode", lambda r: "·" if r.stable else f"{r.mode_growth:.1e}"),
        ("RK4 step / uncoupled", lambda r: f"{r.step_ratio:.2f}"),
    )
    cell, gap = 8, "  |"
    for order, block in by_order(results).items():
        width = cell * len(stiffnesses)
        titles = gap.join(f"{title:^{width}}" for title, _ in columns)
        lines += ["", f"order {operator(order).name:<6}{titles}".rstrip()]
        k = "".join(f"{s:>{cell}g}" for s in stiffnesses)
        lines.append("  m0/rho    " + gap.join([k] * len(columns)) + "  = K/p")
        for i, density in enumerate(densities):
            cells = ["".join(f"{show(block[i][j]):>{cell}}" for j in range(len(stiffnesses))) for _, show in columns]
            lines.append(f"{density:>8g}    " + gap.join(cells))
        lines.append(_count([r for row in block for r in row]))
    if any(r.heated_energy_growth != r.energy_growth for r in results):
        lines += ["", *_heating(results)]
    return "\n".join(lines) + "\n"


def _count(block: Sequence[Result]) -> str:
    counts = [sum(getattr(r, name) for r in block) for name in ("estimate", "stable", "step_kept")]
    growth = max(r.energy_growth / r.radius for r in block)
    steps = [r.step_ratio for r in block]
    return (
        f"  of {len(block)}: energy never grows in {counts[0]} (at most {growth:.1e} |lambda|), no mode grows in "
        f"{counts[1]}, step kept in {counts[2]} ({min(steps):.3f} to {max(steps):.3f})"
    )


def ratios(results: Sequence[Result]) -> tuple[list[float], list[float]]:
    """The density and the stiffness ratios of a sweep, in their order."""
    densities, stiffnesses = ([getattr(r, name) for r in results] for name in ("density_ratio", "stiffness_ratio"))
    return list(dict.fromkeys(densities)), list(dict.fromkeys(stiffnesses))


def by_order(results: Sequence[Result]) -> dict[int, list[list[Result]]]:
    """Order -> results [density][stiffness]."""
    width = len(ratios(results)[1])
    blocks: dict[int, list[Result]] = {}
    for result in results:
        blocks.setdefault(result.order, []).append(result)
    return {order: [block[i : i + width] for i in range(0, len(block), width)] for order, block in blocks.items()}


def write_table(path: str, results: Sequence[Result]) -> None:
    """All numbers of all results as CSV. OSError if it cannot be written."""
    derived = ("estimate", "stable", "step_kept", "heated_stable", "step_ratio")
    names = [*(field.name for field in fields(Result)), *derived]
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows([getattr(result, name) for name in names] for result in results)


def draw(path: str, results: Sequence[Result]) -> None:
    """The sweep as a picture (PNG): a column for each order, rows for energy, modes and step."""
    drawing()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.figure import Figure

    blocks = by_order(results)
    figure = Figure(figsize=(1.6 + 2.4 * len(blocks), 9.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(3, len(blocks), squeeze=False, sharex=True, sharey=True)
    for i, (label, attribute, holds) in enumerate(_ROWS):
        fields = {k: np.array([[getattr(r, attribute) for r in row] for row in block]) for k, block in blocks.items()}
        good = {k: np.array([[getattr(r, holds) for r in row] for row in block]) for k, block in blocks.items()}
        bad = np.concatenate([field[~good[order]] for order, field in fields.items()])
        if i == 2:
            norm = Normalize(0.0, 1.0)
        else:
            norm = LogNorm(*_decades(bad))
        for j, order in enumerate(blocks):
            image = _panel(axes[i, j], np.ma.array(fields[order], mask=good[order]), results, norm, i == 2)
            if i == 0:
                axes[i, j].set_title(f"order {operator(order).name}")
        if bad.size:
            figure.colorbar(image, ax=axes[i, :], label=label, aspect=18, pad=0.01)
        axes[i, 0].set_ylabel(f"{label}\n\ndensity ratio $m_0/\\hat\\rho$")
    for ax in axes[-1]:
        ax.set_xlabel("stiffness ratio $K/\\hat p$")
    coupling = results[0].coupling
    title = f"Interface treatment “{coupling}”: {_THEORY[coupling]}\nblue: nothing grows, the step is kept"
    set_title(figure, title)
    figure.savefig(path, dpi=160)


def _decades(values: np.ndarray) -> tuple[float, float]:
    """Powers of ten around the values."""
    if not values.size:
        return 0.1, 1.0
    high = 10.0 ** np.ceil(np.log10(values.max()))
    return min(high / 10, 10.0 ** np.floor(np.log10(values.min()))), high


def _panel(ax: Axes, field: np.ma.MaskedArray, results: Sequence[Result], norm: Any, steps: bool) -> Any:
    """One map over the ratios with its numbers; masked cells, where all is well, are blue."""
    from matplotlib import colormaps

    densities, stiffnesses = ratios(results)
    palette = colormaps["Oranges_r" if steps else "Oranges"].copy()  # beside blue: told apart without red and green
    palette.set_bad(WELL)
    image = ax.imshow(field, cmap=palette, norm=norm, origin="lower", aspect="auto")
    for (i, j), value in np.ndenumerate(field.data):
        fine = bool(np.ma.getmaskarray(field)[i, j])
        if fine and not steps:
            continue
        text = f"{value:.2f}" if steps else f"{value:.0e}".replace("e+0", "e").replace("e-0", "e-")
        red, green, blue, _ = palette(norm(value))
        dark = not fine and 0.3 * red + 0.6 * green + 0.1 * blue < 0.5
        ax.text(j, i, text, ha="center", va="center", fontsize=NUMBERS, color="white" if dark else "black")
    ax.set_xticks(range(len(stiffnesses)), [f"{s:g}" for s in stiffnesses])
    ax.set_yticks(range(len(densities)), [f"{d:g}" for d in densities])
    return image
