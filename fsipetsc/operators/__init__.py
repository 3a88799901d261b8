"""SBP operators as exact fractions, and derivatives in kernels; no PETSc and no MPI."""
