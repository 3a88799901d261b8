"""Whether results agree, bit for bit, whatever must not matter: ranks, partitions, storage, bursts, monitors, checkpoints.

Not all combinations: of each case there is, for each pair of settings, a run that has both. `scripts/soak matrix [SEED] [CASE]`
makes them, of all cases or of some; a line for each says how many were made, and what differed.
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from pathlib import Path

from helpers import REPOSITORY, mpirun, solve
from test_restart import differences

LAYERS = str(REPOSITORY / "tests" / "layers.py")
#: what is computed: these results may differ from each other, not from themselves
CASES = {
    **{
        f"{mapping} {coupling} {order}": (
            LAYERS,
            f"-fsi_mapping {mapping} -fsi_coupling {coupling} -fsi_order {order} -ts_max_steps 60",
        )
        for mapping, coupling, order in (
            ("rigid", "conservative", 2),
            ("rigid", "energy", 4),
            ("rigid", "projection", 6),
            ("rigid", "traditional", 8),
            ("stretched", "conservative", 8),
            ("stretched", "energy", 6),
            ("stretched", "projection", 4),
            ("stretched", "traditional", 2),
        )
    },
    "rod": ("rod", "-fsi_h 0.025 -ts_max_steps 600 -fsi_output_dt 0.01"),
    "rod 5dp": ("rod", "-fsi_h 0.05 -ts_max_steps 100 -ts_rk_type 5dp"),
    "blast": ("blast", "-fsi_h 0.0625 -ts_max_steps 40 -fsi_output_dt 0.05"),
    "panel": ("panel", "-fsi_h 0.0625 -ts_max_steps 40 -fsi_output_dt 0.05"),
}
#: what must not matter. half: a checkpoint after about half of the steps, from which another run goes on
FACTORS: dict[str, Sequence[str]] = {
    "ranks": ("1", "2", "3", "4", "6"),
    "partition": ("-fsi_partition auto", "-fsi_partition physics", "-fsi_partition balanced"),
    "burst": ("-fsi_burst 64", "-fsi_burst 1", "-fsi_burst 7"),
    "said": ("", "-log_view :log.txt", "-ts_monitor"),
    "half": ("", "-fsi_checkpoint_steps {half}"),
}


def pairwise(factors: Mapping[str, Sequence[str]], chance: random.Random) -> Iterator[dict[str, str]]:
    """Choices of one level of each factor, so that each pair of levels of two factors is in one of them."""
    names = list(factors)
    open_pairs = {
        ((a, i), (b, j)) for a, b in combinations(names, 2) for i in range(len(factors[a])) for j in range(len(factors[b]))
    }
    while open_pairs:
        best: tuple[int, dict[str, int]] = (-1, {})
        for _ in range(40):
            first = chance.choice(sorted(open_pairs))
            picked = {name: chance.randrange(len(factors[name])) for name in names} | dict(first)
            covered = sum(all(picked[name] == level for name, level in pair) for pair in open_pairs)
            best = max(best, (covered, picked), key=lambda entry: entry[0])
        picked = best[1]
        open_pairs = {pair for pair in open_pairs if not all(picked[name] == level for name, level in pair)}
        yield {name: factors[name][level] for name, level in picked.items()}


def made(folder: Path, name: str, case: str, text: str, setting: Mapping[str, str]) -> Path | None:
    """The result of a case with a setting, perhaps in two runs; None if so many ranks cannot be fed. AssertionError."""
    words = text.split()
    steps = int(words[words.index("-ts_max_steps") + 1])
    half = setting["half"].format(half=steps // 2 + 1)
    more = [word for key in ("partition", "memory", "burst", "said") for word in setting[key].split()]
    line = [case, *words, "-fsi_quiet", "-fsi_output", f"{name}.h5", *more]
    parts = [[*line, *half.split(), "-ts_max_steps", steps // 2 + 1], [*line, "-fsi_restart", "auto"]] if half else [line]
    for part in parts:
        if setting["said"].startswith("-log_view"):  # PETSc logs from its start on
            done = mpirun(int(setting["ranks"]), "-m", "fsipetsc", *part, cwd=folder)
        else:
            done = solve(*part, cwd=folder, ranks=int(setting["ranks"]))
        if done.returncode == 2 and "ranks are more than" in done.stderr:
            return None
        assert done.returncode == 0, (part, done.stderr)
    return folder / f"{name}.h5"


def agreement(folder: Path, cases: Mapping[str, tuple[str, str]], seed: int) -> Iterator[tuple[str, int, list[str]]]:
    """(case, runs that were compared, what differed) of each case, with a plain run on one rank."""
    plain = {key: levels[0] for key, levels in FACTORS.items()}
    for number, (name, (case, text)) in enumerate(cases.items()):
        here = folder / str(number)
        here.mkdir()
        one, found = made(here, "plain", case, text, plain), []
        assert one is not None
        count = 0
        for k, setting in enumerate(pairwise(FACTORS, random.Random(seed + number))):
            other = made(here, f"run{k}", case, text, setting)
            if other is not None:
                different, count = differences(one, other, same_ranks=False), count + 1
                found += [f"{setting}: {different}"] if different else []
        yield name, count, found


if __name__ == "__main__":
    words, wrong = sys.argv[1:], 0
    seed = int(next((word for word in words if word.isdigit()), "1"))
    chosen = set(words) & CASES.keys()
    cases = {name: case for name, case in CASES.items() if name in chosen or not chosen}
    with tempfile.TemporaryDirectory() as place:
        for name, count, found in agreement(Path(place), cases, seed):
            wrong += len(found)
            print(f"{name}: {count} runs, {len(found)} differ {json.dumps(found) if found else ''}".rstrip(), flush=True)
    sys.exit(wrong != 0)
