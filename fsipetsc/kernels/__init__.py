"""How scalar formulas become machine code: recorded, printed as C, compiled. Nothing here knows gas
or solids: see symbols, kernel and build.
"""
