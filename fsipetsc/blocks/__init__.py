"""Geometry of a problem: blocks with their maps, the faces between them, metrics, motion of the
gas's grid.

maps        logical cube [0, 1]^d -> places X
block       Block: a map, numbers of cells, a material, initial data
conditions  what can stand at a face
problem     BlockProblem: blocks, their faces, which of them meet, nodes at one place
metrics     metric terms of gas and solid blocks
grid        the gas's grid follows solids and walls
"""
