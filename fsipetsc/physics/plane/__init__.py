"""Two space dimensions: the equations, and a file for each law of a solid. Point formulas only."""
