"""A benchmark as text: the model in words, and the tables of a Markdown file, which stand between markers

    <!-- bench: NAME -->
    <!-- end -->

with NAME machine, steps, parts, scaling, around, model, expected or, of two dimensions, plane. What stands between is replaced.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from fsipetsc.bench.cost_model import Model, half_speed, message, moved_bytes, relative_errors, scaling
from fsipetsc.bench.plane import table
from fsipetsc.bench.table import BenchStudy, entry, markdown
from fsipetsc.errors import FileError, InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.stepping.counts import step_traffic

#: latency [µs] of a message between the nodes of a cluster, for comparison with the one fitted within this machine
NETWORK = 1.5
_MANY = (2, 8, 32, 128, 512, 1000)
_GRIDS = (10_000, 100_000, 1_000_000, 10_000_000)


def renew(path: Path, study: BenchStudy, model: Model | None) -> Path:
    """Replace the tables of a Markdown file; FileError if it cannot be read or written, InputError for unknown names."""
    blocks: dict[str, Callable[[], str]] = {
        "machine": lambda: machine(study),
        "steps": lambda: steps(study),
        "parts": lambda: parts(study),
        "scaling": lambda: scaled(study),
        "around": lambda: around(study),
        "model": lambda: model_text(model, study),
        "expected": lambda: expected(model, study),
        "plane": lambda: table(study.plane),
    }

    measured = {name for name in blocks if (study.plane if name == "plane" else study.rows or name == "machine")}

    def replace(match: re.Match[str]) -> str:
        name = match.group(1)
        if name in blocks and name not in measured:
            return match.group(0)  # of another dimension than what was measured
        if name not in blocks:
            raise InputError(f"{path}: there is no table '{name}' in a benchmark; there are {', '.join(blocks)}")
        return f"<!-- bench: {name} -->\n\n{blocks[name]()}\n\n<!-- end -->"

    try:
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(r"<!-- bench: (\w+) -->.*?<!-- end -->", replace, text, flags=re.DOTALL), encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from error
    return path


def machine(study: BenchStudy) -> str:
    """What was measured on, and the bandwidth of its memory."""
    about, facts = study.about, study.facts
    lines = [
        f"{about.get('processor', 'unknown processor')}, {facts.get('cores', 0):.0f} cores; {about.get('date', '')}; "
        f"PETSc {about.get('petsc')}, {about.get('mpi')}, Python {about.get('python')}, numba {about.get('numba')}; "
        f"load of the machine before {facts.get('load before', 0):.2f}."
    ]
    triads = [(int(n.split()[1]), int(n.split()[2]), v) for n, v in facts.items() if n.startswith("triad ")]
    counts = sorted({ranks for ranks, _, _ in triads})
    sizes = sorted({size for _, size, _ in triads})
    found = {(ranks, size): value for ranks, size, value in triads}
    rows = [[_bytes(size), *(entry("{:.1f}", found.get((ranks, size), float("nan"))) for ranks in counts)] for size in sizes]
    lines.append(markdown(["three arrays of a rank", *(f"GB/s a rank, {ranks} at once" for ranks in counts)], rows))
    return "\n\n".join(lines)


def steps(study: BenchStudy) -> str:
    """Cost on one rank."""
    rows = [
        [
            operator(r.order).name,
            f"{r.points:d}",
            f"{r.step:.4g}",
            f"{r.best:.4g}",
            f"{r.ns:.3g}",
            f"{r.bound:.3g}",
            entry("{:.4g}", r.yardstick),
            *(entry("{:.2f}", value) for value in (r.ratio, r.stretched, r.entropy)),
        ]
        for r in study.at(ranks=1)
    ]
    names = ["order", "points", "µs per step", "best", "ns per point and RHS", "traffic at triad speed, µs"]
    return markdown([*names, "yardstick, µs", "ratio", "stretched", "entropy form"], rows)


def parts(study: BenchStudy) -> str:
    """Where a step goes, in µs."""
    rows = [
        [
            operator(r.order).name,
            f"{r.points:d}",
            f"{r.ranks:d}",
            *(f"{v:.3g}" for v in (r.best, r.inner, r.ends, r.exchange, r.petsc, r.python)),
        ]
        for r in study.at()
    ]
    names = ["order", "points", "ranks", "step", "at the points", "ends and interfaces", "exchange"]
    return markdown([*names, "PETSc", "Python"], rows)


def scaled(study: BenchStudy) -> str:
    """Strong and weak scaling as measured."""
    rows = [
        [
            operator(r.order).name,
            *(f"{value:d}" for value in (r.points, r.ranks, r.share)),
            f"{r.step:.4g}",
            entry("{:.2f}", r.speedup),
            entry("{:.0f} %", 100 * r.speedup / r.ranks),
            *(f"{value:d}" for value in (r.sends, r.reductions)),
        ]
        for r in study.at()
        if r.ranks > 1
    ]
    if not rows:
        return "Only one rank was measured."
    names = ["order", "points", "ranks", "most on a rank", "µs per step", "speed-up", "efficiency"]
    tables = [markdown([*names, "messages sent by a rank", "reductions or turns"], rows)]
    weak = [(*n.split()[1:], f"{v:.0f} %") for n, v in study.facts.items() if n.startswith("weak ")]
    if weak:
        tables.append("Weak scaling, order 4/2: the step of one rank by that of more ranks with as many points each.")
        tables.append(markdown(["points a rank", "ranks", "efficiency"], weak))
    return "\n\n".join(tables)


def around(study: BenchStudy) -> str:
    """Output, start and memory."""
    rows = []
    for name, value in study.facts.items():
        words = name.split()
        if name.startswith("output default"):
            rows.append([f"output at the default interval, {words[2]} points, {words[3]} rank(s)", f"{value:.2f} % of the run"])
        elif name.startswith("output often"):
            rows.append([f"a frame every 10 steps, {words[2]} points, {words[3]} rank(s)", f"{value:.0f} % of the run"])
    names = {
        "usage": "`python -m fsipetsc`",
        "one step": "a run of one step, whole process",
        "first run": "the same, with no kernel compiled before",
    }
    for key, text in names.items():
        if f"start {key} wall" in study.facts:
            wall, cpu = study.facts[f"start {key} wall"], study.facts[f"start {key} cpu"]
            rows.append([text, f"{wall:.2f} s, of which {cpu:.2f} s of the processor"])
    if "memory doubles" in study.facts:
        rows.append(["memory of a run, output included", f"{study.facts['memory doubles']:.1f} doubles per point"])
    return markdown(["what", "cost"], rows) if rows else "Not measured."


def model_text(model: Model | None, study: BenchStudy) -> str:
    """The model's constants and how well it fits."""
    if model is None:
        return "no model: it takes scipy, and more measurements than it has constants"
    works = ", ".join(f"{1e3 * value:.1f} ns (order {order})" for order, value in model.work.items())
    row, worst = max(relative_errors(model, study), key=lambda pair: abs(pair[1]))
    moved, where = step_traffic(), f"order {row.order}, {row.points} points, {row.ranks} rank{'s' * (row.ranks > 1)}"
    lines = (
        f"overhead of a step {model.overhead:.2f} µs",
        f"work per point and step {works}",
        f"{moved_bytes():.0f} bytes moved per point and step ({moved.fetched:.1f} doubles fetched and {moved.written:.1f} "
        f"written per unknown), of whose time {100 * model.overlap:.0f} % is not hidden behind the work",
        f"{model.latency:.2f} µs for each message, or turn at the mailboxes, that others wait for",
        f"fitted to {len(study.rows)} measurements: rms error {100 * model.error:.0f} %, largest "
        f"{100 * worst:+.0f} % ({where})",
    )
    return "\n".join(f"- {line}" for line in lines)


def expected(model: Model | None, study: BenchStudy) -> str:
    """Speed-ups on up to 1,000 ranks by the model: with this machine's messages and with those of a network."""
    if model is None:
        return "No model."
    order, tables = (4 if 4 in model.work else study.orders[0]), []
    for latency, where in ((message(model, study), "as MPI's on this machine"), (NETWORK, "as in a cluster")):
        rows = []
        for points in _GRIDS:
            table = scaling(model, study, order, 1 / round(points / 6), (1, *_MANY), latency)
            texts = [f"{table[n][1]:.3g} ({100 * table[n][2]:.0f} %)" if n in table else "–" for n in _MANY]
            rows.append([f"{points:d}", f"{table[1][0]:.4g}", *texts])
        half = half_speed(model, order, 1000, latency)
        tables.append(
            f"Speed-up (efficiency), order {operator(order).name}, {latency:.2f} µs a message, {where}. On 1,000 ranks "
            f"messages take as long as the work at {half:.0f} points a rank."
        )
        tables.append(markdown(["points", "µs on 1 rank", *(f"{n} ranks" for n in _MANY)], rows))
    return "\n\n".join(tables)


def _bytes(size: int) -> str:
    return f"{size >> 20} MiB" if size >= 1 << 20 else f"{size >> 10} KiB"
