"""The process and its ranks: start of MPI and PETSc, signals, streams, and how all ranks end
together.
"""
