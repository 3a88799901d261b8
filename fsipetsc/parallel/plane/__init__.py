"""Two space dimensions: who owns what."""
