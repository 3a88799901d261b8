"""Particles: nodes at one place are members of one. Who meets whom, what is shared, constraints.

members         who meets whom, and which conditions and constraints a particle has
prescribed      data of conditions at an instant, and where they contradict each other
procedures      members' sums, conditions, accelerations under constraints
constraints     projections of velocities and accelerations; temperatures
system          the particles of a rank: their record, messages, procedures

It is sections 3 and 4 of the derivation (docs/derivation.md).
"""
