"""Entries of `verify` about small motions: frequencies and growth by the linearised scheme."""

from itertools import product
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy.optimize import brentq

from fsipetsc import Block, BlockProblem, Fluid
from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.blocks.conditions import Clamped, Free, Hinge, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.maps import rectangle
from fsipetsc.cases import load_case
from fsipetsc.cases.common import at_rest, constant
from fsipetsc.checks import Array
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.stiffened_gas import stiffened_gas
from fsipetsc.options import defaults
from fsipetsc.stepping.run import build_problem, make_state
from fsipetsc.studies.linear import column_modes, modes_near
from fsipetsc.studies.trials import Trial, entry, reference


@entry({4: (20, 30)}, dict.fromkeys((2, 4, 6), (20, 40)))
def beam(trial: Trial) -> None:
    """Free vibration in vacuum: the slowest motion that bends a beam."""
    table, h = reference("beam"), trial.h
    solid = ElasticSolid(1.0, 0.0, 0.0, 1.0, 1.0, law="linear", heat="elastic")
    sides = tuple(product((0, 1), (0, 1)))
    for ends, d, thin in (("clamped", 0.05, 22.37), ("hinged", 0.02, np.pi**2)):
        where, at_ends = rectangle((0.0, -0.5 * d), (1.0, 0.5 * d)), Clamped()
        points: tuple[Any, ...] = ()
        if ends == "hinged":
            points, at_ends = tuple(("beam", (x, 0.0), Hinge()) for x in (0.0, 1.0)), Free()
        cells = round(1 / h), round(0.6 / h)
        block = Block("beam", solid, where, cells, lambda X, Y: (0, 0, 1, X, Y))
        faces = {("beam", axis, side): Free() if axis else at_ends for axis, side in sides}
        problem, unit = BlockProblem((block,), faces, points=points), np.sqrt(d**2 / 6.0)
        with BlockState(MPI.COMM_SELF, problem, trial.order) as state:
            # 2/1 has a second mode near it, which alternates from node to node
            found = modes_near(state, 0.9j * thin * unit)[0].imag / unit
        row = np.argmin(np.abs(table["d"] - d))
        known, other = table[ends][row], table[f"{ends} pi^2/12"][row]
        expected = trial.closures, abs(1.0 - other / known)
        trial.compare(f"{ends}, d = {d:g}", found, known, *expected)


#: density, speeds of P and S waves [SI]
METALS = {
    "steel": (7850.0, 5900.0, 3200.0),
    "aluminium": (2700.0, 6320.0, 3130.0),
    "tungsten": (19250.0, 5220.0, 2890.0),
}


def metal(name: str, pressure: float = 0.0) -> ElasticSolid:
    """An elastic solid, free of stress under a pressure [Pa]."""
    density, cp, cs = METALS[name]
    mu = density * cs**2
    lame = density * cp**2 - 2.0 * mu
    return ElasticSolid(mu, lame, 0.0, density, 1000.0, p_ref=pressure, heat="elastic")


@entry({4: (16, 24)}, {4: (16, 32), 6: (24, 32)})
def normal_modes(trial: Trial) -> None:
    """Waves along the interface of two layers, 1 m deep: water or a metal over a metal."""
    table, n, gamma, cv, p, rho = reference("normal_modes"), round(1 / trial.h), 4.4, 1e3, 1e5, 1e3
    p_inf = rho * 1480.0**2 / gamma - p
    T = (p + p_inf) / ((gamma - 1.0) * cv * rho)
    water = Fluid(0.0, 0.0, gamma, (gamma - 1.0) * cv, law=stiffened_gas(gamma, cv, p_inf))
    fluid, solid = constant(rho, 0.0, 0.0, T), at_rest(T)
    for name, lid, upper, start, lower in (
        ("water over steel", Slip(), water, fluid, metal("steel", p)),
        ("water over aluminium", Slip(), water, fluid, metal("aluminium", p)),
        ("tungsten under aluminium", Clamped(), metal("aluminium"), solid, metal("tungsten")),
    ):
        below = Layer("lower", lower, (-1.0, 0.0), solid, cells=n)
        above = Layer("upper", upper, (0.0, 1.0), start, cells=n)
        along = {"along": ((0.0, 1.0),), "cells": (n,)}
        problem = layers(below, above, lower=Clamped(), upper=lid, **along)
        with BlockState(MPI.COMM_SELF, problem, trial.order) as state:
            found = column_modes(state, 0, 1)[0]
        known = complex(table[f"{name} real"][0], table[f"{name} imag"][0])
        trial.compare(name, found[np.abs(found - known).argmin()], known, trial.closures)


PANEL = load_case("panel")
#: frequency over sqrt(D/m) of a thin panel at the onset of flutter, and lambdas around this
FLUTTER = {"clamped": (52.0, (600.0, 650.0, 700.0)), "hinged": (32.0, (320.0, 350.0, 380.0))}
#: order of frequencies, where stress in a clamped corner goes as r^(0.69 - 1)
CORNER_ORDER = 1.38


@entry({4: (24,)}, {4: (24, 32, 48)})
def panel_flutter(trial: Trial) -> None:
    """lambda where the growth of the faster of two modes of a panel becomes positive. It differs
    from the thin limit by the effect of the thickness.

    The growth has a kink where the frequencies meet, but over sqrt(D / mass) the coefficients of
    (s - s1)(s - s1*)(s - s2)(s - s2*) are smooth: parabolas over lambda^2 are laid through them.
    """
    table, d, mach = reference("panel_flutter"), 0.04, 2.0
    row = np.argmin(np.abs(table["d"] - d))
    for ends, (frequency, lambdas) in FLUTTER.items():
        own = {"panel_ends": ends, "panel_mach": mach, "panel_thickness": d, "panel_push": 0.0}
        opt = {**defaults(PANEL), "fsi_order": trial.order, "fsi_h": trial.h, **own}
        found, x = [], np.square(lambdas)
        for at in lambdas:
            opt["panel_lambda"] = at
            unit = np.sqrt(mach**2 / (at * np.sqrt(mach**2 - 1.0)) / opt["panel_mass"])
            problem = build_problem(PANEL, opt, MPI.COMM_SELF)
            with make_state(problem, opt, MPI.COMM_SELF) as state:
                s = modes_near(state, 1j * frequency * unit, 2) / unit
            found.append(np.poly([*s, *s.conj()]).real)
        centre = 0.5 * (x.min() + x.max())
        fits = np.polynomial.polynomial.polyfit(x - centre, found, 2)

        def growth(at: float, centre: float = centre, fits: Array = fits) -> float:
            at_once = np.polynomial.polynomial.polyval(at * at - centre, fits)
            return float(np.roots(at_once).real.max())

        onset = float(brentq(growth, lambdas[0], lambdas[-1]))
        thin, thick = table[f"{ends} lambda"][:2]
        off, corner = 1.0 - thick / thin, CORNER_ORDER if ends == "clamped" else None
        trial.compare(f"{ends}, theory", onset, table[f"{ends} theory"][row], corner, off)
        trial.compare(f"{ends}, thin limit", onset, thin, error=off)
