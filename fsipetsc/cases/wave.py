"""A wave along the interface of a gas and an elastic layer, a normal mode of known rate s.

Gas above, between the interface and a rigid adiabatic wall, solid below, on a clamped end; both
at rest but for the mode of the linear equations (fsipetsc.cases.normal_mode), whose size is
small. What is exact to that size goes as exp(s t).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.blocks.conditions import Clamped, NoSlip, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.cases.materials import elastic_of, gas_of
from fsipetsc.cases.normal_mode import Layers, Mode, interpolated
from fsipetsc.checks import Fields
from fsipetsc.options import Option

NAME = "wave"
SUMMARY = "a normal mode of a gas over an elastic layer, whose frequency and decay are known"

OPTIONS = (
    Option("wave_number", float, 2.0 * np.pi, "1/m", "k; all is one wave long", check="positive"),
    Option("wave_mode", int, 0, "", "number, of those that swing", check="nonnegative"),
    Option("wave_size", float, 1e-5, "m", "of the interface's displacement", check="positive"),
    Option("wave_height", float, 1.0, "m", "of the gas", check="positive"),
    Option("wave_depth", float, 0.5, "m", "of the solid", check="positive"),
    Option("fluid_mu", float, 0.01, "Pa s", "viscosity; 0: the gas slips", check="nonnegative"),
    Option("fluid_kappa", float, 0.035 / 0.72, "W/(m K)", "of the gas", check="nonnegative"),
    Option("solid_density", float, 1.0, "kg/m3", "that of the gas is 1", check="positive"),
    Option("solid_mu", float, 1.0, "Pa", "mu_e; the pressure of the gas is 1", check="positive"),
    Option("solid_lambda", float, 1.0, "Pa", "lambda_e", check="nonnegative"),
)
DEFAULTS = {"fsi_h": 1 / 32, "fsi_order": 4, "ts_max_time": 1.0, "fsi_output_dt": 0.05}


def both_of(opt: Mapping[str, Any]) -> Layers:
    """Gas and solid of the options."""
    gas, solid = gas_of(opt), elastic_of(opt)
    return Layers(gas, solid, opt["wave_height"], opt["wave_depth"])


def measured(t: np.ndarray, X: np.ndarray, displacement: np.ndarray) -> complex:
    """s [1/s] of a displacement of the interface, (times, columns) [m].

    By a line through the logarithms of its amplitudes.
    """
    amplitudes = displacement @ np.exp(-2j * np.pi * np.arange(len(X)) / len(X))
    logs = np.stack([np.log(np.abs(amplitudes)), np.unwrap(np.angle(amplitudes))], axis=1)
    return complex(*np.polyfit(t, logs, 1)[0])


def build(opt: Mapping[str, Any]) -> BlockProblem:
    """The solid below Y = 0, the gas above."""
    both, k, size = both_of(opt), opt["wave_number"], opt["wave_size"]
    mode = both.mode(k, opt["wave_mode"])
    low, high = (-both.depth, 0.0), (0.0, both.height)

    def swinging(
        amplitudes: np.ndarray, ends: tuple[float, float], X: np.ndarray, Y: np.ndarray, t: float
    ) -> Fields:
        """Real parts of the amplitudes times exp(i k X + s t)."""
        phase = size * np.exp(1j * k * X + mode.s * t)
        heights, of_height = np.unique(Y, return_inverse=True)
        rows = [interpolated(values, *ends, heights)[of_height] for values in amplitudes]
        return [np.real(row.reshape(X.shape) * phase) for row in rows]

    def gas(X: np.ndarray, Y: np.ndarray, t: float = 0.0) -> Fields:
        rho, u, v, T = swinging(mode.gas, high, X, Y, t)
        return both.rho + rho, u, v, both.T + T

    def solid(X: np.ndarray, Y: np.ndarray, t: float = 0.0) -> Fields:
        x, y, u, v = swinging(mode.solid, low, X, Y, t)
        # without conduction and work of the stresses its temperature stays
        return u, v, both.T + 0.0 * X, X + x, Y + y

    return layers(
        Layer("layer", both.solid, low, solid, exact=solid),
        Layer("gas", both.gas, high, gas, exact=gas),
        along=((0.0, 2.0 * np.pi / k),),
        lower=Clamped(),
        upper=NoSlip() if opt["fluid_mu"] > 0 else Slip(),
        h=opt["fsi_h"],
        order=opt["fsi_order"],
        notes=(_note(mode),),
        units="none",
    )


def _note(mode: Mode) -> str:
    return f"the mode goes as exp(s t), s = {mode.s.real:.9f} {mode.s.imag:+.9f} i"
