"""The phases of a right-hand side on blocks, which read as the method:

    share      members add up what is extensive; faces of the gas's grids follow the solids
    fulfil     share, and then the unknowns obey the conditions
    grid       the grids of the gas follow their faces
    begin      share, area vectors, halos and grid, of a solution that obeys the conditions
    rates      volume terms of each block, what passes open faces, forcing; then the constraints
               of the particles
    complete   begin, and what is noted of the step: so the next one has begun

A phase is a list of calls, which C makes: procedures of parts and of particles
(fsipetsc.kernels.procedure), and exchanges between ranks (fsipetsc.parallel.exchange).
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

from fsipetsc.kernels.procedure import Code
from fsipetsc.parallel.block_layout import BlockLayout
from fsipetsc.particles.system import ParticleSystem
from fsipetsc.scheme import monitor
from fsipetsc.scheme import plan as stages
from fsipetsc.scheme.recorded_data import set_time
from fsipetsc.scheme.sweep import LAST, RATES, STAGE
from fsipetsc.state import OfRates


def procedures_of_steps(code: Code, found: Any) -> dict[str, Any]:
    """Record the procedures between phases; found: see fsipetsc.scheme.plan."""
    of_step = monitor.begin_monitor, monitor.note_extremes, monitor.note_gained
    wanted: dict[str, Any] = {f.__name__: (f, found) for f in of_step}
    wanted["plan_next"] = stages.plan_next, found.plan
    wanted["begin_rates"] = partial(stages.begin_stage, RATES, 0), found
    for n in range(stages.STAGES):
        kind = LAST if n == stages.STAGES - 1 else STAGE
        wanted[f"begin_{n}"] = partial(stages.begin_stage, kind, n), found
        wanted[f"stage_{n}"] = partial(stages.advance, n), found
    for n in stages.NEW_DATA:
        wanted[f"time_{n}"] = partial(set_time, stages.FRACTIONS[n]), found
    return {name: code.procedure(name, *one) for name, one in wanted.items()}


def phases(
    layout: BlockLayout, parts: Sequence[Any], system: ParticleSystem, does: Any, data: Any
) -> dict[str, list[Any]]:
    """Return the ``phases`` of fsipetsc.state. does: procedures of steps, and what reduces
    extremes. data: those that fill recorded data.
    """
    does = {**does, **system.does}

    def of_parts(name: str) -> list[Any]:
        return [part.does[name] for part in parts if name in part.does]

    sums, areas, slips = system.sums, system.areas, system.record.slips
    with_halo = [part for part in parts if part.halo.size]
    inside = [part.inside for part in with_halo]
    read = [part.inside for part in with_halo if part.reads_ghosted]
    halos, images = layout.halos, of_parts("images")
    fill = [halos, *read, *images]  # owned nodes of ghosted arrays too where they are read
    follow = [*of_parts("follow"), *(part.gather for part in parts if part.block.kind == "fluid")]
    reduce = [does["reduce"]] * (layout.comm.size > 1)
    normals = [*of_parts("normals"), areas, does["end_normals"]] if slips else []
    moving = [part for part in parts if part.moves]
    edge, move = ([part.does[name] for part in moving] for name in ("edge", "move"))
    swing, stored = of_parts("swing"), list[Any]()
    if system.record.stores:
        stored = [*move, does["begin_stored"], *fill, *of_parts("store")]
        stored += [system.stored, does["weigh_heat"]]
    # where walls slip, conditions change velocities, which grids follow
    imposed = [does["impose_conditions"], *(follow if slips else [])]
    share = [does["weigh"], sums, does["end_sums"], *follow, *edge]
    # what takes long is done after ranks have waited for halos, not before
    grid = [*move, *swing]
    begin = [*share, *normals, *fill, *grid]
    noted = does["begin_monitor"], *of_parts("monitor"), *reduce
    found = {
        "share": share,
        "fulfil": [*share, *normals, *stored, *imposed],
        "grid": grid,
        "begin": begin,
        "complete": [*begin, *noted, does["note_extremes"], does["note_gained"]],
        "halos": [halos, *inside, *images],
        "inside": [one for one in inside if one not in read],
    }
    rates = [*of_parts("turn"), *of_parts("rates")]
    # exchanged after the rates, so that no rank waits while another one moves its grid
    rates += [areas, does["end_turning"]] if slips else []
    rates += [OfRates(does["weigh"]), sums, does["end_rates"]]
    before = [*fill, *(swing if stored else grid)]
    found["rates"] = [does["begin_rates"], *before, *rates]
    for n in range(stages.STAGES):
        known = before if n > 0 else []  # a step begins from what is completed
        found[f"advance_{n}"] = [does[f"begin_{n}"], *known, *rates, OfRates(does[f"stage_{n}"])]
    for n in stages.NEW_DATA:
        found[f"data_{n}"] = [does[f"time_{n}"], *data] if data else []
    return found
