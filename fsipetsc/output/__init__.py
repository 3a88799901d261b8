"""Result files: written in parallel (`writer`), opened anywhere (`reader`), described (`info`) and
drawn (`plots`).

`file_layout` says how a file is organised. Nothing is imported here: reading needs no PETSc or MPI.
"""
