"""Laws of gases, transport and solids as formulas; Fluid and ElasticSolid.

A law is a NamedTuple of its numbers whose methods are scalar formulas; own.py has their names.
"""
