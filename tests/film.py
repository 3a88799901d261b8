"""A film between two gases, which a pulse pushes; the film may have cells of its own."""

import numpy as np

from fsipetsc import Fluid, FluidLayer, Option, Problem, Solid, SolidLayer, Wall

OPTIONS = (Option("film_cells", int, None, "", "cells of the film; default: by -fsi_h"),)
DEFAULTS = {"fsi_h": 0.04, "ts_max_time": 1.0, "fsi_output_dt": 1.0}
FILM = (1.0, 1.02)


def build(opt):
    """Without conduction: no layer at the film is thinner than the pulse."""
    gas, film = Fluid(0.0, 0.0, 1.4, 1.0), Solid(20.0, 0.0, 2.0, 1.0)

    def pulse(X):
        """Isentropic, towards the film."""
        c = 1.4**0.5 * (1.0 + 0.04 * np.exp(-(((X - 0.5) / 0.15) ** 2)))
        T = c * c / 1.4
        return T**2.5, 5.0 * (c - 1.4**0.5), T

    layers = (
        FluidLayer("left", gas, (0.0, FILM[0]), pulse),
        SolidLayer("film", film, FILM, lambda X: (0.0, -1.0, 1.0, X), cells=opt["film_cells"]),
        FluidLayer("right", gas, (FILM[1], 2.02), pulse),
    )
    return Problem(layers, Wall(0.0), Wall(2.02), units="none")
