"""A run of blocks without files, and what is in its ledgers."""

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blockrun.columns import gained, slices


class Steps(BlockState):
    """A problem in time by RK4, on one rank. came: what has come in, as columns of ``gained``.

    apart: without the kernel that makes several steps in one call, which compiles for long.
    """

    def __init__(self, problem, order=2, form=BlockForm(), apart=True):  # noqa: B008
        super().__init__(MPI.COMM_SELF, problem, order, form, apart=apart)
        self.t, self._at = 0.0, slices(gained(problem))
        self.came = np.zeros(self.layout.auxiliary)
        self.set_initial()
        self.finish()

    def step(self, dt, steps=1):
        for _ in range(steps):
            super().step(self.t, dt, False)
            self.t += dt
            self.came += self.latest_numbers[-self.came.size :]

    def integrals(self):
        """Mass of all gas, momentum, energy after the last step."""
        found = self.latest
        mass = found["mass"].sum() if "mass" in found.dtype.names else 0.0
        momentum = (found[f"momentum_{x}"] for x in "xyz"[: self.problem.dimension])
        return np.array([mass, *momentum, found["energy"]])

    def gained(self):
        """The same, of what has come in."""
        mass = self._came("mass_in").sum() if "mass_in" in self._at else 0.0
        impulse = (self._came(f"impulse_{x}")[0] for x in "xyz"[: self.problem.dimension])
        return np.array([mass, *impulse, self._came("energy_in")[0]])

    def lost(self):
        """Of the kinetic and elastic energy of solids, where that is known."""
        return self._came("lost_energy")[0] if self.lossy else 0.0

    def face_energies(self):
        """Name of a face -> energy that has come in there, heat among it."""
        both = zip(self._came("energy_face"), self._came("heat_face"), strict=True)
        return dict(zip(self.problem.face_names, both, strict=True))

    def _came(self, name):
        return self.came[self._at[name]]
