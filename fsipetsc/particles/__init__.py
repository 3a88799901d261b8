"""Nodes at one place are members of one particle ("Particles" in docs/derivation.md)."""
