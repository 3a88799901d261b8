"""Result files: written in parallel (`writer`), opened anywhere (`reader`), described (`info`) and drawn (`plots`).

`layout` says how a file is organised. Nothing is imported here, so that reading needs neither PETSc nor MPI.
"""
