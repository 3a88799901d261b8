"""Table 1 of the paper: convergence exponents of the manufactured solution, beside a study's."""

from __future__ import annotations

import numpy as np

from fsipetsc.analysis.convergence_table import ConvergenceStudy
from fsipetsc.operators.sbp import operator

#: kind of layer -> order -> exponent in L2 between the two finest grids
PAPER = {"fluid": {8: 4.9, 6: 4.7, 4: 2.4, 2: 1.6}, "solid": {8: 4.3, 6: 4.1, 4: 2.6, 2: 1.8}}
#: the one lower exponent of ours that is understood, and between which exponents that is the reason
KNOWN = ("fluid", 6), 3.8, 4.5
REASON = ": closures of order 3 leave an error of order 4, which rules on fine grids"


def compare(study: ConvergenceStudy) -> str:
    """The table, with a line for each exponent of ours that is lower and one for those that are
    higher.

    study: of the case mms on two grids at least. Exponents are rounded to one digit, as in the
    paper.
    """
    here = {kind: np.round(study.rates(kind)[:, -1], 1) for kind in PAPER}
    orders = sorted(study.orders, reverse=True)
    lines = [
        "Table 1 of the paper, exponents between the two finest grids, "
        f"and ours between h = {study.hs[-2]:g} and {study.hs[-1]:g}",
        f"{'':<12}" + "".join(f"{operator(order).name:>7}" for order in orders),
    ]
    lower, higher = [], []
    for kind, paper in PAPER.items():
        ours = {order: here[kind][study.orders.index(order)] for order in orders}
        lines.append(f"{kind:<7}paper" + "".join(f"{paper[order]:>7.1f}" for order in orders))
        lines.append(f"{'':<7}ours " + "".join(f"{ours[order]:>7.1f}" for order in orders))
        for order in orders:
            numbers = f"{kind} {operator(order).name} ({ours[order]:.1f} for {paper[order]:.1f})"
            if ours[order] > paper[order]:
                higher.append(numbers)
            elif not ours[order] == paper[order]:
                known = (kind, order) == KNOWN[0] and KNOWN[1] <= ours[order] <= KNOWN[2]
                lower.append(f"lower than in the paper: {numbers}{REASON if known else ''}")
    if higher:
        lines.append(f"higher than in the paper: {', '.join(higher)}")
    return "\n".join(lines + lower)
