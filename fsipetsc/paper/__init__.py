"""Sjögreen and Banks, Stability of Finite Difference Discretizations of Multi-Physics Interface
Conditions (2013), as published, with misprints mended: an elastic solid with the stress as an
unknown, (4.19), between gases in rigid frames that move with their interfaces, (4.20), over
embedded boundaries with ghost points that come and go.
"""
