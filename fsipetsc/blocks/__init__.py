"""Geometry of a problem: blocks with their maps, the faces between them, metrics, motion of the
gas's grid.

maps           logical cube [0, 1]^d -> places X
block          Block: a map, numbers of cells, a material, initial data
conditions     what can stand at a face
faces          which faces of blocks meet, nodes at one place
block_problem  BlockProblem: blocks, their faces, what a run asks of them
metrics        metric terms of gas and solid blocks
grid           the gas's grid follows solids and walls
"""
