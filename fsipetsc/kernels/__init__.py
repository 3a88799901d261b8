"""How scalar formulas become machine code: recorded, printed as C, compiled."""
