"""The times at which profiles are saved, which steps hit exactly."""

import math
from collections.abc import Sequence

from fsipetsc.errors import InputError

#: profiles of a run
MOST = 10_000_000


def saved_times(
    t_end: float, interval: float | None, times: Sequence[float] | None, unit: str = " s"
) -> list[float]:
    """Times [s] in [0, t_end] at which profiles are saved: every ``interval``, at ``times``, at the
    end.

    InputError for times beyond the end and for more than MOST; unit: what comes after a time.
    """
    saved = set(times or ())
    if beyond := sorted(t for t in saved if t > t_end):
        listed = ", ".join(f"{t:g}" for t in beyond[:5]) + (" …" if beyond[5:] else "")
        end = f"the run ends at -ts_max_time {t_end:g}{unit}"
        raise InputError(f"-fsi_output_times: {listed}{unit} would not be reached, {end}")
    if interval is not None:
        if t_end / interval > MOST:
            what = f"-fsi_output_dt {interval:g} would save more than {MOST} profiles"
            raise InputError(f"{what} to t = {t_end:g}{unit}")
        count = math.floor(t_end / interval * (1 + 1e-12))
        saved.update(min(k * interval, t_end) for k in range(count + 1))
    return sorted({*saved, t_end})
