"""Start of MPI and PETSc, signals, streams, and how all ranks of a run end together."""
