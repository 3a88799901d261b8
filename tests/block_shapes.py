"""Shapes of blocks, as arrays of nodes: what tests of the scheme of blocks are made on.

Each function returns {name: (X, periods)}, X (d, n_1, ..., n_d), and what is gas or solid follows
from the name's first letter. n: nodes along most axes.
"""

from __future__ import annotations

import numpy as np


def grid(*lengths):
    """Logical coordinates in [0, 1] of so many nodes along each axis."""
    return np.array(np.meshgrid(*(np.linspace(0.0, 1.0, n) for n in lengths), indexing="ij"))


def box(lower, upper, *nodes):
    """(X, periods) of an interval, rectangle or box."""
    xi = grid(*nodes)
    shape = (-1, *[1] * len(nodes))
    low, high = np.reshape(lower, shape), np.reshape(upper, shape)
    return np.array(low + (high - low) * xi, float), ()


def wave(size, n, rows, low, high):
    """(X, periods) of a layer of [0, 1) x [low, high], periodic along xi_1, with wavy lines."""
    xi, eta = np.meshgrid(np.arange(n) / n, np.linspace(0.0, 1.0, rows), indexing="ij")
    y = low + (high - low) * eta
    return np.array([xi, y + size * np.sin(2 * np.pi * xi) * np.sin(2 * y)]), ((1.0, 0.0), None)


def layers(n, periodic):
    """Gas | solid, periodic in x or with sides."""
    if periodic:
        return {"gas": wave(0.05, n, n, 0.0, 1.0), "solid": wave(0.05, n, n, 1.0, 1.6)}
    return {"gas": box((0, 0), (1, 1), n, n), "solid": box((0, 1), (1, 1.6), n, n)}


def warped(blocks, size=0.06):
    """The same under one smooth map of the plane."""
    found = {}
    for name, (X, periods) in blocks.items():
        x, y = X[:2]
        Y = X.copy()
        Y[0] = x + size * np.sin(1.7 * y + 0.3) * np.cos(1.1 * x)
        Y[1] = y + size * np.sin(1.9 * x - 0.2) * np.cos(0.8 * y)
        found[name] = Y, periods
    return found


def ring(n, around=None):
    """Gas | solid | gas as O-grids."""
    radii = {"gas inside": (0.5, 1.0), "solid": (1.0, 1.3), "gas outside": (1.3, 2.0)}
    found = {}
    for name, (inner, outer) in radii.items():
        phi, s = np.meshgrid(
            np.arange(around or 2 * n) / (around or 2 * n), np.linspace(0, 1, n), indexing="ij"
        )
        r = inner + (outer - inner) * s
        angle = -2 * np.pi * phi  # right-handed with r as the second axis
        found[name] = np.array([r * np.cos(angle), r * np.sin(angle)]), ((0.0, 0.0), None)
    return found


def square(n):
    """A free square solid in the middle of eight blocks of gas."""
    lines = (0.0, 1.0, 1.8, 3.0)
    found = {}
    for i in range(3):
        for j in range(3):
            name = "solid" if (i, j) == (1, 1) else f"gas {i}{j}"
            found[name] = box((lines[i], lines[j]), (lines[i + 1], lines[j + 1]), n, n)
    return warped(found)


def panel(n):
    """A solid that stands on the floor of a channel, foot clamped, in five blocks of gas."""
    x, y, found = (0.0, 1.0, 1.3, 2.5), (0.0, 0.7, 1.5), {}
    for i in range(3):
        for j in range(2):
            name = "solid" if (i, j) == (1, 0) else f"gas {i}{j}"
            found[name] = box((x[i], y[j]), (x[i + 1], y[j + 1]), n, n)
    return found


def turned(X, turns):
    """The same nodes, logical axes turned."""
    for _ in range(turns % 4):
        X = np.flip(np.swapaxes(X, 1, 2), 1)
    return X


def disk(n, box_of_gas=True):
    """A solid disk of five blocks, axes turned against each other, and four of gas between it and a
    square box.
    """
    t, s = grid(n, n)
    a, found = 0.45, {}
    x, y = a * (2 * t - 1), a * (2 * s - 1)
    bulge = 0.25 * np.array([x * (1 - (y / a) ** 2 / 2), y * (1 - (x / a) ** 2 / 2)])
    found["solid centre"] = turned(np.array([x, y]) + bulge, 1), ()
    edge = (np.array([x, y]) + bulge)[:, -1, :]
    angle = np.pi / 4 * (2 * np.linspace(0, 1, n) - 1)
    circle = np.array([np.cos(angle), np.sin(angle)])
    side = np.array([np.full(n, 2.0), 2.0 * np.tan(angle)])
    for quarter in range(4):
        c, w = np.cos(quarter * np.pi / 2), np.sin(quarter * np.pi / 2)
        turn = np.array([[c, -w], [w, c]])
        for name, inner, outer in (("solid", edge, circle), ("gas", circle, side)):
            X = (1 - t)[None] * inner[:, None, :] + t[None] * outer[:, None, :]
            if name == "solid" or box_of_gas:
                found[f"{name} {quarter}"] = turned(np.einsum("ij,jkl->ikl", turn, X), quarter), ()
    return found


def three(n):
    """Two blocks of gas side by side and a solid on one of them, warped."""
    found = {
        "gas low": box((0, 0, 0), (1, 1, 1), n, n, n),
        "gas beside": box((1, 0, 0), (2, 1, 1), n, n, n),
        "solid": box((0, 1, 0), (1, 1.8, 1), n, n, n),
    }
    for name, (X, periods) in found.items():
        x, y, z = X
        bend = 0.06 * np.array(
            [np.sin(1.7 * y + z), np.sin(1.9 * x - 0.7 * z), np.sin(1.3 * x + 0.9 * y)]
        )
        found[name] = X + bend, periods
    return found


def tube(n):
    """Gas in a solid shell, both bent, around (xi_1) and along (xi_2) periodic, in three
    dimensions.
    """
    found = {}
    for name, inner, outer in (("gas", 0.5, 1.0), ("solid", 1.0, 1.4)):
        around, length = np.arange(n) / n, np.arange(n) / n
        phi, z, s = np.meshgrid(2 * np.pi * around, length, np.linspace(0, 1, n), indexing="ij")
        radius = inner + (outer - inner) * s
        r = radius * (1 + 0.05 * np.sin(2 * np.pi * z + phi))
        x = r * np.cos(phi) + 0.1 * np.sin(2 * np.pi * z)
        along = z + 0.03 * np.sin(2 * phi) * np.cos(2 * np.pi * z) * radius
        found[name] = np.array([x, r * np.sin(phi), along]), ((0, 0, 0), (0, 0, 1.0), None)
    return found
