"""Two space dimensions: what a step is. Compiled."""
