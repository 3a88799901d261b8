"""Particles: nodes at one place are members of one. Who meets whom, what is shared, constraints.

members         who meets whom, and which conditions and constraints a particle has
records         tables and data that procedures take
procedures      members' sums, conditions, accelerations under constraints
constraints     projections of velocities and accelerations
heat            one temperature of the members, elastic energy
prescribed      data of conditions at an instant; contradictions: between those of neighbours
messages        members on other ranks
system          the particles of a rank: tables, messages, procedures

It is sections 3 and 4 of the derivation (docs/derivation.md).
"""
