"""Laws of gases, transport and solids as formulas, one file each; Fluid and ElasticSolid.

A law is a NamedTuple of its numbers whose methods are scalar formulas; own.py has their names.
"""
