"""Counts what a step does, for tests/test_counts.py: "MODE options" ...; prints JSON, a list for each of the ranks' counts.

traffic      arrays moved between a small cache and memory, by running the kernels' source, uncompiled, in a simulation
             of the cache; wants NUMBA_DISABLE_JIT=1
messages     calls of MPI functions by compiled code, through functions that count put in their place
path         what the right-hand side of PETSc's own methods sends, by PETSc's log and through communicators that count
allocations  of compiled code, by numba's own count (wants NUMBA_NRT_STATS=1), and of Python; calls of compiled code
"""

from __future__ import annotations

import ctypes
import importlib
import json
import pkgutil
import sys
import tracemalloc
from collections import Counter, OrderedDict
from types import ModuleType
from typing import Any

import numpy as np

from fsipetsc.operators.vectors import LANES

#: the simulated cache: lines of eight doubles, and how many of them
LINE, LINES = 8, 512
#: points that a kernel treats at once and that make a tile, in the simulation: so few that all of it fits into the cache
BLOCK = 48


def main(*tasks: str) -> None:
    """Each task: "MODE options"."""
    modes = [task.split()[0] for task in tasks]
    shims = count_mpi() if "messages" in modes else None
    from fsipetsc.process.launch import start_mpi, start_petsc

    comm = start_mpi()
    start_petsc([], comm)
    from fsipetsc.cases import load_case
    from fsipetsc.options import read_options
    from fsipetsc.options.sources import given_options

    case, every = load_case("rod"), []
    for mode, task in zip(modes, tasks):
        opt = read_options(case, given_options(task.split()[1:], {}))
        if mode == "messages":
            result = messages(case, opt, comm, shims)
        else:
            result = {"traffic": traffic, "path": path, "allocations": allocations}[mode](case, opt, comm)
        every.append(comm.gather(result))
    if comm.rank == 0:
        print(json.dumps(every))


# --- traffic


class Memory:
    """Stands for the plan's memory: a cache that keeps the lines used last counts what it fetches and writes back."""

    def __init__(self, memory: np.ndarray) -> None:
        self._memory = memory
        self._lines: OrderedDict[int, bool] = OrderedDict()  # line -> changed
        self.fetched, self.written = Counter(), Counter()

    def _touch(self, i: int, change: bool) -> None:
        line = i // LINE
        changed = self._lines.pop(line, None)
        if changed is None:
            self.fetched[line] += 1
            changed = False
        self._lines[line] = changed or change
        if len(self._lines) > LINES:
            old, dirty = self._lines.popitem(last=False)
            self.written[old] += int(dirty)

    def __getitem__(self, i: int) -> float:
        self._touch(i, False)
        return float(self._memory[i])

    def __setitem__(self, i: int, value: float) -> None:
        self._touch(i, True)
        self._memory[i] = value


class Record:
    """A record as compiled code sees it: fields are attributes."""

    def __init__(self, record: np.void) -> None:
        object.__setattr__(self, "_record", record)

    def __getattr__(self, name: str) -> Any:
        value = self._record[name]
        if isinstance(value, np.void):
            return Record(value)
        return value.item() if isinstance(value, np.generic) else value

    def __setattr__(self, name: str, value: Any) -> None:
        self._record[name] = value


class Records:
    """An array of them."""

    def __init__(self, array: np.ndarray) -> None:
        self._array, self.size = array, array.size

    def __getitem__(self, i: int) -> Record:
        return Record(self._array[i])


def traffic(case: Any, opt: dict[str, Any], comm: Any) -> dict[str, float]:
    """Doubles fetched and written back per unknown in a step, with the part of what is only scratch and messages."""
    from fsipetsc.scheme import runge_kutta
    from fsipetsc.stepping.counts import step_traffic
    from fsipetsc.stepping.solve import make_state

    interpret()
    run_task = runge_kutta.run_task

    def interpreted(task: int, heads: Any, layers: Any, faces: Any, memory: Any, *arguments: Any) -> None:
        run_task(task, Records(heads), Records(layers), Records(faces), memory, *arguments)

    runge_kutta.run_task = interpreted
    state = make_state(case.build(opt), opt, comm)
    state.set_initial()
    plan, memory = state.plan, Memory(state.plan.memory)
    for _ in range(2):  # the first fills the cache
        memory.fetched.clear(), memory.written.clear()
        runge_kutta.make_steps(plan._replace(memory=memory), 1e-9)
    unknowns = state.layout.local_size
    fetched, written = (LINE * sum(c.values()) / unknowns for c in (memory.fetched, memory.written))
    said = step_traffic()
    return {"fetched": fetched, "written": written, "said_fetched": said.fetched, "said_written": said.written}


def interpret() -> None:
    """Give the kernels Python's numbers, and stand-ins for what only compiled code has."""
    plain = {
        "U64": int,
        "load": load_lanes,
        "store": store_lanes,
        "store_interlaced": lambda s, i, values: store_lanes(s, i, np.stack(values, axis=-1).ravel()),
        "numbers_from": lambda i: i + np.arange(LANES, dtype=float),
        "spread": lambda value: np.full(LANES, value),
        "lane": lambda v, j: v[j],
        "masked": lambda v, n, other: np.where(np.arange(LANES) < n, v, other),
        "mirrored": lambda v: v[::-1],
        "centred_difference": difference,
        "fma": lambda a, b, c: a * b + c,
        "maximum": np.maximum,
        "minimum": np.minimum,
        "root": np.sqrt,
        "magnitude": np.abs,
        "rows_at": lambda memory, at, rows, columns: getattr(memory, "_memory", memory)[at : at + rows * columns].reshape(
            rows, columns
        ),
        "BLOCK": BLOCK,
        "TILE": BLOCK,
        "LEAST_MIDDLE": BLOCK,
        "LEAST_TILED": 0,
    }
    for module in compiled_modules():
        for name, stand_in in plain.items():
            if hasattr(module, name):
                setattr(module, name, stand_in)


def load_lanes(s: Any, i: int) -> np.ndarray:
    """As memory.load, of the simulated memory or an array seen as flat."""
    s = s.ravel() if isinstance(s, np.ndarray) else s
    return np.array([s[i + j] for j in range(LANES)])


def store_lanes(s: Any, i: int, values: np.ndarray) -> None:
    """As memory.store."""
    for j, value in enumerate(values):
        s[i + j] = value


def difference(before: np.ndarray, v: np.ndarray, after: np.ndarray, k: int) -> np.ndarray:
    """As lanes.centred_difference."""
    row = np.concatenate([before, v, after])
    return row[LANES + k : 2 * LANES + k] - row[LANES - k : 2 * LANES - k]


def compiled_modules() -> list[ModuleType]:
    """Every module with kernels."""
    found = []
    for folder in ("operators", "physics", "boundaries", "coupling", "parallel", "scheme"):
        package = importlib.import_module(f"fsipetsc.{folder}")
        found.append(package)
        for entry in pkgutil.iter_modules(package.__path__):
            found.append(importlib.import_module(f"fsipetsc.{folder}.{entry.name}"))
    return found


# --- messages

#: what sends messages; a probe, with which a rank that waits lets MPI work, does not
_PROTOTYPES = {
    "MPI_Allreduce": ctypes.CFUNCTYPE(ctypes.c_int, *[ctypes.c_void_p] * 2, ctypes.c_int, *[ctypes.c_void_p] * 3),
    "MPI_Startall": ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_void_p),
    "MPI_Waitall": ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, *[ctypes.c_void_p] * 2),
}
#: which argument says how many
_NUMBER = {"MPI_Allreduce": 2, "MPI_Startall": 0, "MPI_Waitall": 0}


def count_mpi() -> dict[str, Counter[str]]:
    """Have functions that count take the place of MPI's in compiled code; before any is loaded."""
    from llvmlite import binding

    calls: dict[str, Counter[str]] = {"calls": Counter(), "numbers": Counter()}
    add_symbol, kept = binding.add_symbol, []

    def add(name: str, address: int) -> None:
        if name in _PROTOTYPES:
            real = _PROTOTYPES[name](address)

            def counted(*arguments: Any) -> int:
                calls["calls"][name] += 1
                calls["numbers"][name] += arguments[_NUMBER[name]]
                return real(*arguments)

            shim = _PROTOTYPES[name](counted)
            kept.append((real, shim))
            address = ctypes.cast(shim, ctypes.c_void_p).value
        add_symbol(name, address)

    binding.add_symbol = add
    calls["kept"] = kept  # type: ignore[assignment]
    return calls


def messages(case: Any, opt: dict[str, Any], comm: Any, calls: Any) -> dict[str, Any]:
    """Calls in ten steps, what they were given, and what the plan says of a step."""
    from fsipetsc.scheme.runge_kutta import STAGES
    from fsipetsc.stepping.counts import completion_traffic, stage_traffic
    from fsipetsc.stepping.solve import make_state

    state = make_state(case.build(opt), opt, comm)
    state.set_initial()
    world = state.plan.head[0]["world"]
    mailbox = int(world["mailboxes"] + world["rank"] * world["mailbox"])

    def turns() -> int:
        return ctypes.c_int64.from_address(mailbox).value if world["mailboxes"] else 0

    calls["calls"].clear(), calls["numbers"].clear()
    before = turns()
    for _ in range(10):
        state.step(0.0, 1e-9, True)
    made = turns() - before
    stage, completion = stage_traffic(state.plan), completion_traffic(state.plan)
    said = [(STAGES - 1) * a + b for a, b in zip(stage, completion)]
    return {"calls": dict(calls["calls"]), "numbers": dict(calls["numbers"]), "said": said, "turns": made}


class CountingComm:
    """A communicator whose calls are counted."""

    def __init__(self, comm: Any, calls: Counter[str]) -> None:
        self._comm, self._calls = comm, calls

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._comm, name)
        if name not in ("Sendrecv", "Bcast"):
            return value

        def counted(*arguments: Any, **named: Any) -> None:
            self._calls[name] += 1
            self._calls[f"{name} bytes"] += arguments[0].nbytes
            value(*arguments, **named)

        return counted


def path(case: Any, opt: dict[str, Any], comm: Any) -> dict[str, Any]:
    """Of ten right-hand sides: calls and bytes of each kind, and what the plan says of one."""
    from petsc4py import PETSc

    from fsipetsc.stepping import phases, solve
    from fsipetsc.stepping.counts import path_traffic

    solve.LoggedState = solve.State  # PETSc's counters are to count what PETSc sends, and nothing else
    PETSc.Log.begin()
    state, calls = solve.make_state(case.build(opt), opt, comm), Counter()
    state.set_initial()
    y = state.solution.getArray().copy()
    f = np.empty_like(y)
    state.right_hand_side(y, f)  # the first exchange tells the ranks what they will get
    for part in (*state.path._layers, *state.path._interfaces):
        part._comm = CountingComm(part._comm, calls)
    sent, event = phases._counter("isend"), PETSc.Log.Event("VecScatterBegin")
    before = event.getPerfInfo()["count"], sent[0].value, sent[1].value
    for _ in range(10):
        state.right_hand_side(y, f)
    after = event.getPerfInfo()["count"], sent[0].value, sent[1].value
    scatters = [int(b - a) for a, b in zip(before, after)]
    return {"petsc": scatters, "calls": dict(calls), "said": path_traffic(state.layout, state.plan)._asdict()}


# --- allocations


def allocations(case: Any, opt: dict[str, Any], comm: Any) -> dict[str, float]:
    """Per step: allocations of compiled code beyond those of an empty call, calls, growth of Python's memory [bytes]."""
    from numba.core.runtime import rtsys

    from fsipetsc.scheme import runge_kutta
    from fsipetsc.stepping.integrator import Integrator
    from fsipetsc.stepping.solve import make_state

    calls, run_task = Counter(), runge_kutta.run_task

    def counted(*arguments: Any) -> None:
        calls["tasks"] += 1
        run_task(*arguments)

    runge_kutta.run_task = counted
    state = make_state(case.build(opt), opt, comm)
    integrator = Integrator(
        state, opt, [opt["ts_max_time"]], *(lambda *a: None,) * 2, lambda steps, t, dt: note(steps), lambda: None
    )
    seen: list[tuple[int, int]] = []

    def note(steps: int) -> None:
        if steps == 50:
            tracemalloc.start()
        if steps in (100, 200):
            seen.append((calls["tasks"], tracemalloc.get_traced_memory()[0]))

    integrator.start()
    integrator.run()
    tracemalloc.stop()

    def allocated(task: Any, *arguments: float) -> float:
        before = rtsys.get_allocation_stats()
        for _ in range(10):
            task(state.plan, *arguments)
        after = rtsys.get_allocation_stats()
        assert after.alloc - before.alloc == after.free - before.free, "what is allocated is freed"
        return (after.alloc - before.alloc) / 10

    (calls_a, bytes_a), (calls_b, bytes_b) = seen
    return {
        "empty_call": (empty := allocated(runge_kutta.do_nothing)),
        "in_kernels": allocated(runge_kutta.make_steps, 1e-9) - empty,
        "calls": (calls_b - calls_a) / 100,
        "python_bytes": (bytes_b - bytes_a) / 100,
    }


if __name__ == "__main__":
    main(*sys.argv[1:])
