"""Runs of problems of blocks: their state, steps, snapshots and what is saved."""
