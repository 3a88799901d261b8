"""Conditions of particles: constraints at edges of any kind, who shares what."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")

import block_shapes as shapes
from ledger_problems import gas, problem_of, solid

from fsipetsc.blocks.conditions import (
    Clamped,
    Free,
    Slip,
)
from fsipetsc.blocks.particles import SLIPS, particles_of
from fsipetsc.scheme.constraints import eliminate

N = 3


def at(problem, *place):
    """The particle at a place."""
    for particle in particles_of(problem):
        k, node = particle.members[0]
        if np.allclose(problem.places(k, np.array([node]))[0], place):
            return particle
    raise AssertionError(f"no particle at {place}")


def kinds(particle):
    """(kind, number of faces at walls, at solids) of its constraints."""
    return [(c.kind, len(c.walls), len(c.solids)) for c in particle.constraints]


def panel(faces, mu=0.0, points=(), **options):
    return problem_of(shapes.panel(N), faces, gas(mu=mu), solid(**options), points)


def closed(name, axis, side):
    return Slip() if name.startswith("gas") else Clamped()


def test_a_panel_that_is_flush_with_a_wall():
    """The wall and the panel in it are one constraint."""
    shape = {
        "gas left": shapes.box((0, 0), (1, 1), N, N),
        "gas right": shapes.box((1, 0), (2, 1), N, N),
        "solid": shapes.box((0, 1), (1, 1.3), N, N),
    }
    problem = problem_of(shape, closed, gas(), solid())
    assert kinds(at(problem, 1.0, 1.0)) == [(SLIPS, 1, 1)]

    def named(name, axis, side):
        return Clamped() if name == "solid" else Slip(name=f"wall {axis}")

    assert kinds(at(problem_of(shape, named, gas(), solid()), 1.0, 1.0)) == [(SLIPS, 1, 1)]
    assert sorted(kinds(at(problem, 0.0, 1.0))) == [(SLIPS, 0, 1), (SLIPS, 1, 0)]


def test_names_decide():
    def named(name, axis, side):
        if name == "solid":
            return Clamped()
        return Slip(name="one") if axis == 0 or side == 0 else Slip(name=name)

    problem = panel(named)
    assert kinds(at(problem, 0.0, 0.0)) == [(SLIPS, 2, 0)], "a corner with one name"
    assert kinds(at(problem, 1.0, 1.5)) == [(SLIPS, 1, 0)] * 2, "a wall with two"
    assert kinds(at(problem, 0.0, 0.7)) == [(SLIPS, 2, 0)]


def test_a_temperature_that_is_given_is_that_of_all_solids_there():
    shape = {
        "solid a": shapes.box((0, 0), (1, 1), N, N),
        "solid b": shapes.box((1, 0), (2, 1), N, N),
    }

    def faces(name, axis, side):
        return Free(T=1.2) if (axis, side) == (1, 1) else Free()

    problem = problem_of(shape, faces, gas(), solid(heat="elastic", kappa=0.0))
    warm, other = at(problem, 1.0, 1.0), at(problem, 1.0, 0.5)
    assert warm.one_T and warm.stores and not other.one_T and not other.stores


def test_constraints_that_others_imply_get_no_force():
    n = np.array([[1.0, 0.0], [0.6, 0.8], [0.3, 0.4 + 1e-12]])
    A, x = n @ n.T, n @ np.array([2.0, 3.0])
    found = x.copy()
    eliminate.py_func(3, A.copy(), found, np.zeros(3))
    assert found[2] == 0.0 and np.abs(found).max() < 10.0
    assert np.allclose(A @ found, x, rtol=0.0, atol=1e-9)
