"""Writes results as the solver does; run by test_output.py under mpiexec: MODE FILE [frames]."""

from __future__ import annotations

import signal
import sys

import numpy as np

H = 0.05
LAYERS = [
    {"name": "left", "kind": "fluid", "fields": ["rho", "u", "T", "p"], "shape": [26]},
    {"name": "rod", "kind": "solid", "fields": ["u", "sigma", "T", "x", "p"], "shape": [21]},
    {"name": "right", "kind": "fluid", "fields": ["rho", "u", "T", "p"], "shape": [25]},
]
HEADER = {
    "case": "demo",
    "options": {"fsi_h": H, "fsi_order": 4, "fsi_output_times": [0.0, 0.5]},
    "versions": {"petsc": "3.18.5"},
    "ranks": 1,
    "interfaces": ["left/rod", "rod/right"],
    "layers": LAYERS,
}
GROWTH = 7  # more of the fluids' points are active from this frame on
SERIES_STEPS = 3  # time steps per frame


def grid(layer: int) -> np.ndarray:
    """Indices of the grid points of a layer."""
    first, last = [(-5, 20), (20, 40), (40, 64)][layer]
    return np.arange(first, last + 1)


def values(layer: int, frame: int, indices: np.ndarray) -> np.ndarray:
    """Made-up columns, (npoints, 5); NaN at a point of the fluids, as in an inactive part."""
    columns = np.arange(5)
    result = np.sin(1.0 + indices[:, None] + 100.0 * columns + 1e4 * layer + 0.37 * frame)
    if layer != 1:
        active = (indices >= 0) & (indices <= 60) | (frame >= GROWTH)
        result[~active | (indices == 7)] = np.nan
    result[:, 3 if layer == 1 else -1] = indices * H + 0.01 * frame
    return result


def series(first: int, end: int) -> np.ndarray:
    """Records of the steps first .. end-1."""
    steps = np.arange(first, end)
    arrays = [("x_interface", "f8", (2,)), ("mass", "f8", (1,))]
    rows = np.empty(len(steps), [("t", "f8"), ("dt", "f8"), *arrays, ("energy", "f8")])
    rows["t"], rows["dt"], rows["energy"] = 0.1 * steps, 0.1, 7.0 + steps
    rows["x_interface"], rows["mass"] = np.outer(steps, [1.0, 2.0]), 5.0 - steps[:, None]
    return rows


def owned(layer: int, indices: np.ndarray, rank: int, size: int, split: str) -> np.ndarray:
    """The part of a layer that a rank owns: a block of every layer, or whole layers."""
    if split == "blocks":
        return np.array_split(indices, size)[rank]
    owner = [0, 1, 2][layer] if size >= 3 else [0, 1, 0][layer] % size
    return indices if owner == rank else indices[:0]


def write(
    path: str,
    nframes: int,
    split: str,
    header: dict = HEADER,
    join: bool = True,
) -> None:
    """join: the pieces into one file, at the end."""
    from fsipetsc.output import writer as module
    from fsipetsc.process.launch import start_mpi

    comm = start_mpi()
    whole = [grid(i) for i in range(3)]
    mine = [owned(i, whole[i], comm.rank, comm.size, split) for i in range(3)]
    grids = [{"local": len(m), "n": len(w), "X": m * H} for m, w in zip(mine, whole)]
    module.FRAMES = 4  # in a piece
    writer = module.RunWriter(comm, path, header, grids)
    taken = made = 0

    def take() -> np.ndarray:
        nonlocal taken
        rows, taken = series(taken, made), made
        return rows

    def fields() -> dict[int, np.ndarray]:
        return {i: values(i, frame, w)[np.isin(w, mine[i])] for i, w in enumerate(whole)}

    writer.take_series = take
    for frame in range(nframes):
        made += SERIES_STEPS
        if frame % 3 == 0:  # else they go with the frames
            writer.write_series()
        writer.write_frame(0.3 * frame, fields())
    summary = {"steps": SERIES_STEPS * nframes, "wall_time": np.float64(1.5)}
    writer.finish(summary, {"fluid": {"rho": 1e-3}}, join)
    if comm.rank == 0:
        print("kept as", *(name.name for _, name in writer.moved))


def refuse(path: str) -> None:
    """Every rank must get the same FileError."""
    from mpi4py import MPI

    from fsipetsc.errors import FileError
    from fsipetsc.output.writer import RunWriter

    comm = MPI.COMM_WORLD
    try:
        RunWriter(comm, path, HEADER, [{"n": 0}] * 3)
    except FileError as error:
        answers = comm.gather((error.status, str(error)))
        if comm.rank == 0:
            print(len(set(answers)), *answers[0])


def full_disk(path: str) -> None:
    """Writing fails after some frames: the file may not become larger than 600 kB."""
    import resource

    from mpi4py import MPI

    from fsipetsc.errors import FileError

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, 600_000))
    message = None
    try:
        write(path, 400, "blocks")
    except FileError as error:
        message = str(error)
    answers = MPI.COMM_WORLD.gather(message)
    if MPI.COMM_WORLD.rank == 0:
        print(len(set(answers)), answers[0])


if __name__ == "__main__":
    mode, file, *rest = sys.argv[1:]
    if mode == "refuse":
        refuse(file)
    elif mode == "full_disk":
        full_disk(file)
    else:
        write(file, int(rest[0]), mode)
