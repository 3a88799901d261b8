"""What the paper's method does at the outer end of a layer of gas."""

from fsipetsc.paper.embedded import LEAST, beyond_boundary, dirichlet_ghost, lagrange


class GasEnd:
    """An end of a gas, from which conditions take what they do not change. n is the outward normal,
    -1 left, 1 right. A part is a fsipetsc.paper.steps.Part.

    new: degree of the extrapolation that fills a new point.
    """

    new = 3

    @staticmethod
    def ghost(part, layer, side, n, nodes):
        """(rho, u, T) of the ghost point."""
        raise NotImplementedError

    @staticmethod
    def seen(part, layer, side, n, nodes):
        """(u, T) for the gradients in viscous stress and conduction at a ghost point that is
        filled: those with which data are met at the boundary.
        """
        _, u, T = nodes
        degree, data = part.ends.degree[side], layer.end_data[side]
        weights, _ = lagrange(beyond_boundary(layer, side), degree)
        # less, and the viscous stress of the ghost point takes more than the time step gives
        least = LEAST if degree < 4 else 0.3
        seen_u = dirichlet_ghost(data[1], u, weights, degree, least)
        return seen_u, dirichlet_ghost(data[2], T, weights, degree, least)
