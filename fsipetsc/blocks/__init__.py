"""Blocks and their maps, what stands at faces, metrics, motion of a gas's grid."""
