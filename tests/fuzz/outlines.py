"""Outlines from convex to comb, thin, with tiny edges; holes inside, touching, nested, outside; any size, anywhere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from solver.meshing.outline import inside

from .case import pick

Array = np.ndarray
Rng = np.random.Generator


def convex(rng: Rng) -> Array:
    """On an ellipse, from a triangle to a smooth curve."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, pick(rng, [3, 4, 5, 7, 12, 40, 200])))
    return np.column_stack([np.cos(angle), np.sin(angle)]) * [1.0, rng.uniform(0.1, 1.0)]


def regular(rng: Rng) -> Array:
    angle = 2 * np.pi * np.arange(k := pick(rng, [3, 4, 5, 6, 8, 15, 16, 60])) / k
    return np.column_stack([np.cos(angle), np.sin(angle)])


def star(rng: Rng) -> Array:
    """Around one point, at any distance from it."""
    count = pick(rng, [5, 8, 14, 30])
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(-0.4, 0.4, count)) / count
    far = rng.uniform(pick(rng, [0.05, 0.3, 0.8]), 1.0, count)
    return far[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def comb(rng: Rng) -> Array:
    """Teeth beside each other, with gaps down to a thousandth of their width."""
    teeth, gap, back = int(rng.integers(2, 6)), 10.0 ** rng.uniform(-3, -0.3), rng.uniform(0.1, 1.0)
    points = [(0.0, 0.0), (teeth * 1.0, 0.0)]
    for k in range(teeth - 1, -1, -1):
        points += [(k + 1.0 - (gap / 2 if k < teeth - 1 else 0), back + 1.5)]
        points += [(k + (gap / 2 if k else 0), back + 1.5)]
        if k:
            points += [(k + gap / 2, back), (k - gap / 2, back)]
    return np.array(points)


def letter(rng: Rng) -> Array:
    """L, T, U, Z and a cross, with arms of any width."""
    a, b = rng.uniform(0.05, 0.45, 2)
    shapes = [
        [(0, 0), (1, 0), (1, a), (b, a), (b, 1), (0, 1)],
        [(0, 1), (0, 1 - a), (0.5 - b, 1 - a), (0.5 - b, 0), (0.5, 0), (0.5, 1 - a), (1, 1 - a), (1, 1)],
        [(0, 0), (1, 0), (1, 1), (1 - b / 2, 1), (1 - b / 2, a), (b / 2, a), (b / 2, 1), (0, 1)],
        [(0, 0), (0.6, 0), (0.6, 0.7), (1, 0.7), (1, 1), (0.6 - a, 1), (0.6 - a, 0.3), (0, 0.3)],
    ]
    return np.array(pick(rng, shapes), dtype=float)


def spiral(rng: Rng) -> Array:
    turns, width = rng.uniform(0.6, 2.0), rng.uniform(0.05, 0.4)
    angle = np.linspace(0, 2 * np.pi * turns, 30)
    r = 1 + angle / (2 * np.pi)
    way = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.concatenate([(r + width)[:, None] * way, (r[:, None] * way)[::-1]])


def thin(rng: Rng) -> Array:
    """A strip a tenth to a thousandth as wide as long."""
    width = 10.0 ** rng.uniform(-3, -1)
    return np.array([(0, 0), (1, 0), (1, width), (0.5, width * rng.uniform(0.3, 3)), (0, width)])


def wild(rng: Rng) -> Array:
    """Points in no order: nearly always crossing itself."""
    return rng.uniform(-1, 1, (pick(rng, [1, 2, 3, 4, 5, 9]), 2))


KINDS: dict[str, Callable[[Rng], Array]] = {
    "convex": convex,
    "regular": regular,
    "star": star,
    "comb": comb,
    "letter": letter,
    "spiral": spiral,
    "thin": thin,
    "wild": wild,
}
_SHARES = np.array([4, 2, 4, 2, 5, 1, 2, 1]) / 21


def with_tiny_edges(rng: Rng, points: Array) -> Array:
    """Points put in beside others, a millionth to a hundredth of the size away, along the edge or off it."""
    for _ in range(rng.integers(1, 4)):
        k = int(rng.integers(len(points)))
        edge = np.roll(points, -1, axis=0)[k] - points[k]
        aside = np.array([-edge[1], edge[0]]) * pick(rng, [0.0, 0.0, 0.3, -1.0])
        points = np.insert(points, k + 1, points[k] + 10.0 ** rng.uniform(-9, -2) * (edge + aside), axis=0)
    return points


def damaged(rng: Rng, points: Array) -> Array:
    """What drawing leaves: points twice, out and back again, on a line, not numbers."""
    k = int(rng.integers(len(points)))
    after = points[(k + 1) % len(points)]
    if (way := pick(rng, ["twice", "spike", "closed", "line", "nan"])) == "twice":
        return np.insert(points, k + 1, points[k], axis=0)
    if way == "spike":
        return np.insert(points, k + 1, [points[k] + rng.normal(size=2), points[k]], axis=0)
    if way == "closed":
        return np.concatenate([points, points[:1]])
    if way == "line":
        return np.insert(points, k + 1, [0.7 * points[k] + 0.3 * after, 0.2 * points[k] + 0.8 * after], axis=0)
    return np.where(np.arange(len(points))[:, None] == k, pick(rng, [np.nan, np.inf, 1e300, -1e160]), points)


_MISPLACED = ["touching", "at a corner", "outside", "the same", "in the last", "like the last"]


def holes_in(rng: Rng, outline: Array) -> list[Array]:
    """None as a rule; else some inside, or where holes must not be."""
    if rng.random() < 0.7:
        return []
    size, middle = np.ptp(outline, axis=0).max(), outline.mean(axis=0)
    holes = []
    for _ in range(rng.integers(1, 4)):
        count = pick(rng, [3, 4, 6, 24])
        angle = 2 * np.pi * np.arange(count) / count + rng.uniform(0, 6)
        hole = 10.0 ** rng.uniform(-3, -1.2) * size * np.column_stack([np.cos(angle), np.sin(angle)])
        corner = outline[int(rng.integers(len(outline)))]
        way = pick(rng, ["inside"] * 2 + _MISPLACED) if rng.random() < 0.4 else "inside"
        if way == "inside":
            tried = middle + rng.uniform(0, 1, (50, 1)) * (outline[rng.integers(0, len(outline), 50)] - middle)
            within = tried[inside(tried, outline, np.roll(outline, -1, axis=0))]
            hole = hole + (within[0] if len(within) else middle)
        elif way == "touching":
            hole = hole - hole[0] + 0.5 * (outline[0] + outline[1 % len(outline)])
        elif way == "at a corner":
            hole = hole - hole[0] + corner
        elif way == "outside":
            hole = hole + middle + 3 * size
        elif way == "the same":
            hole = outline.copy()
        elif way == "in the last" and holes:
            hole = holes[-1].mean(axis=0) + 0.5 * (holes[-1] - holes[-1].mean(axis=0))
        elif holes:
            hole = holes[-1] + 10.0 ** rng.uniform(-9, -1) * size
        holes.append(hole if rng.random() < 0.5 else hole[::-1])
    return holes


def drawn(rng: Rng) -> tuple[str, Array, list[Array]]:
    """A name, an outline and holes: turned, at a scale of 1e-6 to 1e6, and some of them a million off the origin."""
    name = str(rng.choice(list(KINDS), p=_SHARES))
    outline = KINDS[name](rng)
    if rng.random() < 0.15:
        name, outline = f"{name} with tiny edges", with_tiny_edges(rng, outline)
    holes = holes_in(rng, outline)
    if rng.random() < 0.06:
        name, outline = f"{name}, damaged", damaged(rng, outline)
    c, s = np.cos(turn := pick(rng, [0.0, rng.uniform(0, 6.3)])), np.sin(turn)
    frame = pick(rng, [1.0, 1.0, 10.0 ** rng.uniform(-6, 6)]) * np.array([[c, s], [-s, c]])
    shift = pick(rng, [0.0, 0.0, 1.0]) * rng.uniform(-1e6, 1e6, 2)
    if rng.random() < 0.3:
        outline = outline[::-1]
    with np.errstate(all="ignore"):  # of points that are no numbers
        return name, outline @ frame + shift, [hole @ frame + shift for hole in holes]


def edge_for(rng: Rng, outline: Array, vertices: tuple[float, float]) -> float:
    """An edge length that makes about so many vertices; now and then one that nobody wants."""
    if rng.random() < 0.03:
        return pick(rng, [0.0, -1.0, np.nan, np.inf, 1e-300, 1e300])
    x, y = (outline - outline[0]).T
    with np.errstate(all="ignore"):
        area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
        return float(np.sqrt(area / 0.866 / rng.uniform(*vertices)))
