"""Runs of problems of blocks: their right-hand side, state, steps, snapshots and what is saved."""
