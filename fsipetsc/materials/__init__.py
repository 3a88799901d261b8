"""Laws of gases, transport and solids: NamedTuples of their numbers whose methods are scalar
formulas. fluid.py and solid.py have what a case says of a material."""
