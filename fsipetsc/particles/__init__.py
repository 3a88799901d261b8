"""Particles: nodes at one place are members of one (docs/derivation.md, 3 and 4)."""
