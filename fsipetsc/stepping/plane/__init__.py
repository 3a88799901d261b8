"""Two space dimensions: PETSc's TS and what happens around a step."""
