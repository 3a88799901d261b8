"""What usually helps a run that cannot go on, for each kind of failure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_GRID, _LOAD = "a finer grid (-fsi_h)", "stiffer or heavier layers or less load, so that none is squeezed to nothing"
#: what the failure is about -> what to try, in this order; what stands in braces depends on the options in force
_ADVICE = {
    "rho": ("{steps}", "{shocks}", _GRID),
    "T": ("{steps}", "{shocks}", _GRID),
    "J": ("{steps}", _LOAD, _GRID),
    "x_X": ("{steps}", _LOAD, _GRID),
    "finite": ("{steps}", "{shocks}", "a look at what functions of the case give then"),
    "crossed": ("{steps}", "{mapping}"),
    "short": (_GRID, "a lower -fsi_order, which needs fewer points", "{mapping}"),
}


def advice(topic: str, opt: Mapping[str, Any]) -> str:
    """What to try, in words: topic is a key of _ADVICE, opt are the options in force."""
    steps = "a smaller -ts_dt" if opt["ts_dt"] else "a smaller -fsi_cfl"
    missing = [f"-{name} 1" for name in ("fsi_dissipation", "fsi_shock") if not opt[name]]
    missing = ["-fsi_coupling conservative", *missing] if opt["fsi_coupling"] != "conservative" else missing
    filled = {
        "{steps}": steps,
        "{shocks}": f"{' and '.join(missing)} where there are shocks" if missing else "",
        "{mapping}": ""
        if opt["fsi_coupling"] == "conservative"
        else "-fsi_coupling conservative, whose grids keep their points",
    }
    tried = [filled.get(words, words) for words in _ADVICE[topic]]
    return f"what usually helps: {', '.join(words for words in tried if words)}"
