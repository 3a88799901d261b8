"""SBP operators as exact fractions; arrays in, arrays out, no PETSc and no MPI."""
