"""The equations as formulas at a node or a pair of nodes, once for d = 1, 2, 3; no indices."""
