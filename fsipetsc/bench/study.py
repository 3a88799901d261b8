"""The measurements of the command ``bench``, one after the other; see fsipetsc.bench.command."""

from __future__ import annotations

import math
import os
import platform
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import product
from statistics import median
from typing import Any, TypeVar

from mpi4py import MPI

from fsipetsc.bench import plane
from fsipetsc.bench.around_the_loop import doubles_per_point, output_share, start_costs
from fsipetsc.bench.cost_model import bound
from fsipetsc.bench.measure import Stand, bandwidth, compare, spacing
from fsipetsc.bench.table import FORMS, BenchStudy, Row, heading, line
from fsipetsc.bench.yardstick import ENVIRONMENT, PlaneYardstick, Yardstick
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.options import defaults
from fsipetsc.process.together import wait_asleep
from fsipetsc.scheme.plan import RATE
from fsipetsc.stepping.versions import versions

Result = TypeVar("Result")
Say = Callable[[str], None]

#: bytes of the three arrays of the triad: first-level cache to memory
TRIAD = tuple(1 << k for k in (14, 17, 19, 21, 23, 25, 27, 28))
#: points and steps of the runs with a frame every ten steps
OFTEN = ((480, 20_000), (3840, 4000), (100_000, 300))
#: runs of which the share of output is the median
RUNS = 5
#: points of a rank in weak scaling
WEAK = (10_000, 100_000)
#: length [m] of the problem in which other grids and forms of the gas are compared: the rod, 1 m, is a small part of it
GAS = 20.0
#: name of the column -> what such a run has instead of a rigid grid; nothing is measured where there is no such option
OF_FORM = {"stretched": {"fsi_mapping": "stretched"}, "entropy": {"fsi_mapping": "stretched", "fsi_convection": "entropy"}}
#: load of the machine beyond our own above which a warning is due
_REST = 0.3


class Bench:
    """The ranks, the options and what has been measured so far. All methods are collective."""

    def __init__(self, opt: Mapping[str, Any], world: MPI.Comm, say: Say) -> None:
        self.opt, self.world, self.say = opt, world, say
        self.case = load_case("rod")
        self.study = BenchStudy()
        counts = opt["bench_ranks"] or [*(1 << k for k in range(16) if 1 << k < world.size), world.size]
        if max(counts) > world.size:
            raise InputError(
                f"-bench_ranks {max(counts)} wants more ranks than there are: mpiexec -n {max(counts)} before the command"
            )
        self.ranks = sorted(set(counts))
        self.teams = {n: world.Split(0 if world.rank < n else MPI.UNDEFINED, world.rank) for n in self.ranks}
        folder = opt["bench_yardstick"] or os.environ.get(ENVIRONMENT)
        self.yardstick = self._on_first(lambda: Yardstick(folder)) if folder else None
        of_plane = opt["bench_plane_yardstick"]
        self.plane_yardstick = self._on_first(lambda: PlaneYardstick(of_plane)) if of_plane else None

    def _on_first(self, action: Callable[[], Result]) -> Result | None:
        """What an action gives on rank 0, None on others; its InputError on all."""
        value, fault = None, None
        if self.world.rank == 0:
            try:
                value = action()
            except InputError as error:
                fault = str(error)
        fault = self.world.bcast(fault)
        if fault:
            raise InputError(fault)
        return value

    def options(self, order: int, points: int, **more: Any) -> dict[str, Any]:
        """Options of a run of the rod."""
        chosen = {name: self.opt[name] for name in ("fsi_partition", "fsi_shared_memory")}
        return {**defaults(self.case), "fsi_order": order, "fsi_h": spacing(points), **chosen, **more}

    def alone(self, action: Callable[[], Result]) -> Result | None:
        """Do something on rank 0 while the others sleep."""
        value = action() if self.world.rank == 0 else None
        wait_asleep(self.world)
        return value

    def team(self, ranks: int, action: Callable[[MPI.Comm], Result]) -> Result | None:
        """Do something on the first ranks while the others sleep."""
        comm = self.teams[ranks]
        value = action(comm) if comm != MPI.COMM_NULL else None
        wait_asleep(self.world)
        return value

    def free(self) -> None:
        """Give the communicators back, and what the yardstick took."""
        for comm in self.teams.values():
            if comm != MPI.COMM_NULL:
                comm.Free()
        for program in (self.yardstick, self.plane_yardstick):
            if program is not None:
                program.close()

    # ------------------------------------------------------------------ steps

    def machine(self) -> None:
        """Bandwidths, and what machine this is."""
        self.study.about.update(about())
        self.study.facts["load before"] = os.getloadavg()[0]
        self.study.facts["cores"] = float(os.cpu_count() or 1)
        for ranks, nbytes in product(self.ranks, TRIAD):
            found = self.team(ranks, lambda comm: bandwidth(comm, nbytes, self.opt["bench_seconds"]))  # noqa: B023
            if found:
                self.study.facts[f"triad {ranks} {nbytes}"] = found

    def steps(self) -> None:
        """All rows."""
        self.say(heading())
        for order, points in product(self.opt["bench_orders"], self.opt["bench_points"]):
            with self._stands(order, points) as stands:
                if not stands:
                    continue
                samples, other, steps = self._samples(stands, order, spacing(points))
                for ranks in stands:
                    row = self._row(stands, ranks, samples, other, steps)
                    forms = self._forms(order, points) if ranks == 1 else {}
                    if row is not None:
                        row.stretched, row.entropy = (forms.get(name, math.nan) for name in FORMS)
                        self.study.rows.append(row)
                        self.say(line(row))

    def weak(self) -> None:
        """Weak scaling: the step of one rank by that of more of them with as many points each."""
        for points, ranks in product(WEAK, [n for n in self.ranks if n > 1 and 1 in self.ranks]):
            with self._stands(4, points, [1]) as one, self._stands(4, points * ranks, [ranks]) as many:
                if not (one and many):
                    continue
                a, b = (self._samples(stands, 4, spacing(points), alone=True)[0] for stands in (one, many))
            if self.world.rank == 0:
                efficiency = 100 * median(a[1]) / median(b[ranks])
                self.study.facts[f"weak {points} {ranks}"] = efficiency
                self.say(f"weak scaling, {points} points a rank, {ranks} ranks: {efficiency:.0f} %")

    @contextmanager
    def _stands(self, order: int, points: int, counts: Sequence[int] | None = None) -> Iterator[dict[int, Stand | None]]:
        """Number of ranks -> the problem on these; None on ranks without a part, left out where it does not fit."""
        stands: dict[int, Stand | None] = {}
        for ranks in counts or self.ranks:
            try:
                stands[ranks] = self.team(ranks, lambda comm: Stand(self.case, self.options(order, points), comm, self.say))
                fault = None
            except InputError as error:
                wait_asleep(self.world)
                fault = str(error)
            fault = self.world.bcast(fault)
            if fault:
                stands.pop(ranks, None)
                self.say(f"order {order}, {points} points, {ranks} ranks: {fault}")
        yield stands
        for stand in stands.values():  # not after an error, with which a rank may be alone
            if stand is not None:
                stand.destroy()

    def _samples(
        self, stands: Mapping[int, Stand | None], order: int, h: float, alone: bool = False
    ) -> tuple[dict[int, list[float]], list[float], int]:
        """Times of a step [µs]: ranks -> samples, and the yardstick's unless alone; in turn, in the same minute."""
        samples: dict[int, list[float]] = {ranks: [] for ranks in stands}
        other: list[float] = []
        steps = self.world.bcast(self.team(min(stands), lambda comm: stands[min(stands)].sample(self.opt["bench_seconds"])))
        for ranks, stand in stands.items():
            self.team(ranks, lambda comm: stand.steps(2))  # noqa: B023  for what is loaded at the first use
        for _ in range(self.opt["bench_repeats"]):
            for ranks, stand in stands.items():
                samples[ranks].append(self.team(ranks, lambda comm: stand.steps(steps)))  # noqa: B023
            if self.world.bcast(self.yardstick is not None and not alone):
                other.append(self.alone(lambda: self.yardstick.step(order, h, steps)))
        return samples, other, steps

    def _row(
        self, stands: Mapping[int, Stand | None], ranks: int, samples: dict[int, list[float]], other: list[float], steps: int
    ) -> Row | None:
        """A row on rank 0, and the phases that it takes."""
        stand = stands[ranks]
        phases = self.team(ranks, lambda comm: {**stand.phases(self.opt["bench_seconds"]), **stand.counts})
        if self.world.rank:
            return None
        opt, mine = stand.options, samples[ranks]
        times = {"steps": steps, "step": median(mine), "best": min(mine)}
        row = Row(opt["fsi_order"], opt["fsi_h"], ranks=ranks, bound=0.0, **times, **phases)
        row.bound = bound(self.study, ranks, row.share)
        row.speedup = median(a / b for a, b in zip(samples[min(samples)], mine)) if 1 in samples else row.speedup
        if other:
            row.yardstick, row.ratio = median(other), median(a / b for a, b in zip(mine, other))
        return row

    def _forms(self, order: int, points: int) -> dict[str, float]:
        """What other grids and forms of the gas cost on one rank, by the rigid grid: on rank 0, where they fit."""
        spaced = {"rod_top": GAS, "fsi_h": 1.0 / max(1, round(points / GAS))}
        options = {"rigid": self.options(order, points, **spaced)}
        known = options["rigid"].keys()
        options |= {name: {**options["rigid"], **chosen} for name, chosen in OF_FORM.items() if chosen.keys() <= known}

        def measured(comm: MPI.Comm) -> dict[str, float]:
            try:
                return compare(self.case, options, comm, self.opt["bench_seconds"], self.opt["bench_repeats"])
            except InputError:
                return {}  # a row of the rod may fit where this grid is too coarse

        return self.team(1, measured) or {}

    # ------------------------------------------------------------------ around the steps

    def around(self) -> None:
        """Output, start of the program, memory."""
        facts = self.study.facts
        for ranks in self.ranks:
            opt = self.options(4, 480)
            share = self.team(ranks, lambda comm: output_share(self.case, opt, comm, RUNS))  # noqa: B023
            if share:
                facts[f"output default 480 {ranks}"] = share
                self.say(f"output at the default interval, 483 points, {ranks} ranks: {share:.2f} % of the run")
            for points, steps in OFTEN:
                share = self.team(ranks, lambda comm: self._often(comm, points, steps))  # noqa: B023
                if share:
                    facts[f"output often {points} {ranks}"] = share
                    self.say(f"output every 10 steps, {points} points, {ranks} ranks: {share:.1f} % of the run")
        if max(self.ranks) > 1:
            latency = self.team(max(self.ranks), self._latency)
            if latency:
                facts["message latency"] = latency
                self.say(f"a message of a reduction by MPI: {latency:.2f} µs")
        self.say("start of the program: six short runs and one that compiles the kernels, for about 25 s")
        for name, cost in (self.alone(lambda: start_costs(3)) or {}).items():
            facts[f"start {name} wall"], facts[f"start {name} cpu"] = cost.wall, cost.cpu
            self.say(f"{name}: {cost.wall:.2f} s, of which {cost.cpu:.2f} s of the processor")
        doubles = self.alone(doubles_per_point)
        if doubles:
            facts["memory doubles"] = doubles
            self.say(f"memory of a run: {doubles:.1f} doubles per point")

    def _latency(self, comm: MPI.Comm) -> float:
        """Time [µs] of a message within a reduction by MPI, not in shared memory."""
        stand = Stand(self.case, self.options(4, 3840, fsi_shared_memory=False), comm)
        reduction = stand.reduction(self.opt["bench_seconds"])
        stand.destroy()
        return reduction / math.ceil(math.log2(comm.size))

    def _often(self, comm: MPI.Comm, points: int, steps: int) -> float:
        """Share of output [%] with a frame every ten steps."""
        opt = self.options(4, points)
        stand = Stand(self.case, opt, comm)
        dt = 0.5 / float(stand.state.results[RATE])
        stand.destroy()
        return output_share(self.case, {**opt, "ts_dt": dt, "fsi_output_dt": 10 * dt, "ts_max_time": steps * dt}, comm, RUNS)


def measure(opt: Mapping[str, Any], world: MPI.Comm, say: Say) -> BenchStudy:
    """Everything that the options ask for; the study is complete on rank 0. Collective on world."""
    bench = Bench(opt, world, say)
    try:
        bench.machine()
        if bench.study.facts["load before"] > _REST:
            load = bench.study.facts["load before"]
            say(f"note: this machine has other work to do (load {load:.2f}): times will be too long and uneven")
        if 1 in opt["bench_dimensions"]:
            bench.steps()
            if opt["bench_more"]:
                bench.weak()
                bench.around()
        if 2 in opt["bench_dimensions"]:
            bench.study.plane = plane.measure(bench, bench.plane_yardstick)
        bench.study.facts["load after"] = os.getloadavg()[0]
        return bench.study
    finally:
        bench.free()


def about() -> dict[str, str]:
    """What machine this is and what the program runs on."""
    processor = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            processor = next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        pass  # not Linux
    return {"processor": processor, "date": time.strftime("%Y-%m-%d"), **versions()}
