"""How the programs of this folder write their references."""

from pathlib import Path

FOLDER = Path(__file__).parent.parent / "fsipetsc/studies/verify/references"


def save(name, columns, *about):
    """references/NAME.csv: lines that begin with #, the heads, the numbers in 12 digits."""
    lines = [f"# {line}" for line in about] + [",".join(columns)]
    lines += [",".join(f"{value:.12g}" for value in row) for row in zip(*columns.values())]
    (FOLDER / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
