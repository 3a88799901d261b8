"""Cases with exact solutions and their references: the command `verify`.

An entry is a module of this folder whose name stands in ENTRIES, with
  measure      measure(solve, order, h) -> Measured (fsipetsc.studies.verdicts)
  QUICK, FULL  what the levels take: order -> grid spacings, coarse to fine
  expected     expected(quantity, order, h) -> Expected, for operators of an order, finest grid h
  SOURCE, WHY  str: of the reference; why this is expected, which no run of this program says
Its problem is in problems/NAME.md, exact enough to repeat it in another code. The references in the
folder `references` come from the independent programs in the repository's folder `verify`.
"""

#: entries, in the order of the table
ENTRIES = (
    *("elastic_piston", "riemann_problems", "superseismic", "beam", "normal_modes"),
    *("spinning_disk", "panel_flutter", "heat", "sudden_contact", "large_deformation"),
    *("invariants", "vortex", "shock_tubes", "taylor_green", "oblique"),
    *("taylor_green_1600", "viscous_tube", "shock_on_panel"),
)
