"""Shapes of blocks as arrays of nodes: {name: (X, periods)}, X (d, n_1, ..., n_d).

What is gas or solid follows from the name's first letter; n: nodes along most axes."""

import numpy as np


def box(lower, upper, *nodes):
    """(X, periods) of an interval, rectangle or box."""
    lines = (np.linspace(a, b, n) for a, b, n in zip(lower, upper, nodes, strict=True))
    return np.array(np.meshgrid(*lines, indexing="ij")), ()


def boxes(n, x, y, solid):
    """Rectangles between lines x and y, all but one of gas."""
    cells = [(i, j) for i in range(len(x) - 1) for j in range(len(y) - 1)]
    return {
        "solid" if (i, j) == solid else f"gas {i}{j}": box((x[i], y[j]), (x[i + 1], y[j + 1]), n, n)
        for i, j in cells
    }


def line(n=17):
    """Gas, a solid, and two blocks of gas."""
    names, ends = ("gas left", "solid", "gas right", "gas beyond"), (0.0, 1.0, 1.5, 2.0, 4.0)
    return {name: box((a,), (b,), n) for name, a, b in zip(names, ends, ends[1:])}


def layers(n, periodic):
    """Gas | solid, periodic in x and wavy, or with sides."""
    found = {"gas": box((0, 0), (1, 1), n, n), "solid": box((0, 1), (1, 1.6), n, n)}
    for name, (X, _) in found.items() if periodic else ():
        x, y = np.broadcast_to(np.arange(n)[:, None] / n, (n, n)), X[1]
        bent = y + 0.05 * np.sin(2 * np.pi * x) * np.sin(2 * y)
        found[name] = np.array([x, bent]), ((1.0, 0.0), None)
    return found


def warped(blocks, size=0.06):
    """The same under one smooth map of the plane."""
    found = {}
    for name, ((x, y), periods) in blocks.items():
        bend = [np.sin(1.7 * y + 0.3) * np.cos(1.1 * x), np.sin(1.9 * x - 0.2) * np.cos(0.8 * y)]
        found[name] = np.array([x, y]) + size * np.array(bend), periods
    return found


def flush(n):
    """A solid in the wall of a channel."""
    shape = warped(boxes(n, (0.0, 1.0, 2.0), (0.0, 1.0, 1.3), (0, 1)))
    return {name: X for name, X in shape.items() if name != "gas 11"}


def ring(n):
    """Gas | solid | gas as O-grids."""
    found = {}
    for name, inner, outer in (("gas inside", 0.5, 1), ("solid", 1, 1.3), ("gas outside", 1.3, 2)):
        # right-handed with r as the second axis
        angle, r = box((0, inner), (-2 * np.pi * (1 - 0.5 / n), outer), 2 * n, n)[0]
        found[name] = np.array([r * np.cos(angle), r * np.sin(angle)]), ((0.0, 0.0), None)
    return found


def square(n):
    """A free square solid in the middle of eight blocks of gas."""
    lines = (0.0, 1.0, 1.8, 3.0)
    return warped(boxes(n, lines, lines, (1, 1)))


def panel(n):
    """A solid that stands on the floor of a channel, foot clamped, in five blocks of gas."""
    return boxes(n, (0.0, 1.0, 1.3, 2.5), (0.0, 0.7, 1.5), (1, 0))


def turned(X, turns):
    """The same nodes, logical axes turned."""
    for _ in range(turns % 4):
        X = np.flip(np.swapaxes(X, 1, 2), 1)
    return X


def disk(n):
    """A solid disk of five blocks, axes turned, and four of gas between it and a square box."""
    a = 0.45
    (t, _), (x, y) = box((0, 0), (1, 1), n, n)[0], box((-a, -a), (a, a), n, n)[0]
    bulge = 0.25 * np.array([x * (1 - (y / a) ** 2 / 2), y * (1 - (x / a) ** 2 / 2)])
    centre = np.array([x, y]) + bulge
    found = {"solid centre": (turned(centre, 1), ())}
    angle = np.linspace(-np.pi / 4, np.pi / 4, n)
    circle = np.array([np.cos(angle), np.sin(angle)])
    side = np.array([np.full(n, 2.0), 2.0 * np.tan(angle)])
    for quarter in range(4):
        c, w = np.cos(quarter * np.pi / 2), np.sin(quarter * np.pi / 2)
        turn = np.array([[c, -w], [w, c]])
        for name, inner, outer in (("solid", centre[:, -1], circle), ("gas", circle, side)):
            X = (1 - t) * inner[:, None, :] + t * outer[:, None, :]
            found[f"{name} {quarter}"] = turned(np.einsum("ij,jkl->ikl", turn, X), quarter), ()
    return found


def three(n):
    """Two blocks of gas side by side and a solid on one of them, warped."""
    found = {
        "gas low": box((0, 0, 0), (1, 1, 1), n, n, n),
        "gas beside": box((1, 0, 0), (2, 1, 1), n, n, n),
        "solid": box((0, 1, 0), (1, 1.8, 1), n, n, n),
    }
    for name, ((x, y, z), periods) in found.items():
        bend = [np.sin(1.7 * y + z), np.sin(1.9 * x - 0.7 * z), np.sin(1.3 * x + 0.9 * y)]
        found[name] = np.array([x, y, z]) + 0.06 * np.array(bend), periods
    return found


def skewed(xi):
    """Wavy places with the period 1 in xi_1, ..., and the periods, not at right angles."""
    P = np.eye(len(xi)) + 0.2 * np.roll(np.eye(len(xi)), 1, axis=0)
    return np.einsum("kc,k...->c...", P, xi) + 0.03 * np.sin(2 * np.pi * (xi - xi[::-1])), P


def skew(n):
    """Gas | solid in three dimensions, periodic along two axes."""
    found = {}
    for name, low, high in (("gas", 0.0, 1.0), ("solid", 1.0, 2.0)):
        X, P = skewed(box((0, 0, low), (1 - 1 / n, 1 - 1 / n, high), n, n, n)[0])
        found[name] = X, (P[0], P[1], None)
    return found


def cell(n, d):
    """Gas that is periodic along all axes."""
    X, P = skewed(box([0] * d, [1 - 1 / n] * d, *[n] * d)[0])
    return {"gas": (X, tuple(P))}
