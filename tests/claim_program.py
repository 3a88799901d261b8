"""Many short runs of one name, without computing anything; run by test_claim.py: FILE RESULTS NUMBER."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import h5py

from fsipetsc.errors import FileError
from fsipetsc.output import claim

if __name__ == "__main__":
    target, rounds, number = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    if "without" in sys.argv:

        def refuse(*_: object) -> None:
            raise OSError("no locks here")

        claim.fcntl.flock = refuse
    while not target.with_name("go").exists():
        time.sleep(0.001)
    made = 0
    while made < rounds:
        try:
            claimed = claim.Claim(target)
        except FileError as error:
            assert error.status == 4 and "another run is writing it" in str(error), error
            time.sleep(0.001)
            continue
        text = f"{number} {made}"
        made += 1
        kept = claim.keep_earlier(target)
        while not claim.publish(target, text.encode()):
            assert "without" in sys.argv, "somebody else made the file that we have claimed"
            kept = claim.keep_earlier(target)
        if "without" not in sys.argv:
            assert target.read_text() == text
            time.sleep(0.0005)
            assert target.read_text() == text
        claimed.release()
        print(text, kept and os.path.basename(kept), sep="|")
    assert h5py
