"""Sjögreen and Banks, Stability of Finite Difference Discretizations of Multi-Physics Interface
Conditions (2013), as published.

One space dimension: an elastic solid with the stress as an unknown, (4.19), between gases in rigid
frames that move with their interfaces, (4.20), over embedded boundaries with ghost points that come
and go. Where the paper has misprints the formulas are the corrected ones. From the bottom up:

    stencils      the SBP first derivative on the points of a rank, narrow second derivatives
    ends          walls, open ends, given data; boundaries that move over the grid; ends of solids
    rates         dy/dt of a layer, (4.19) and (4.20); the next stage; what follows a step
    layers        what a rank has of a layer, which procedures take
    coupling      what holds at an interface: projection, projection in energy, traditional
    paper_state   what the time integration drives: the right-hand side from top to bottom
"""
