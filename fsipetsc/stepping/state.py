"""What the time integration drives: a state of blocks, or one of the paper's method."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState
    from fsipetsc.paper.state import PaperState

    State = BlockState | PaperState
else:
    State = Any

#: what a rank says of STOP whose user's functions have failed: more than any signal
FAULT = 1000.0
