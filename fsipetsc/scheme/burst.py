"""Several steps in one call: the words of the plan of a burst, and of what came of it.

A burst of steps ends when it has as many as are allowed (-fsi_burst, -ts_max_steps, room in the
journal), or something has to be looked at: a time to be saved, a grid that must grow, a failure, a
signal. Each step fills a row of the journal.
"""

from __future__ import annotations

#: time before or, once it is made, after the step; the step; time after it; the next time that must be hit;
#: Courant number, or the step that is given and else 0; steps that may be made, and have been; shortest and longest;
#: first row of the journal to be filled
TIME, DT, NEXT, TARGET, COURANT, FIXED, ALLOWED, MADE, SHORTEST, LONGEST, FIRST = range(11)
