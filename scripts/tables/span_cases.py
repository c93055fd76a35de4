"""Plans and lines on which `measure_spans` measures: eight plans, sides that lean, and random lines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solver import Shape, shapes

Array = NDArray[np.float64]
Leans = list[tuple[NDArray[np.integer], float]]
TURN = 2.0 * np.pi * np.arange(400) / 400
CIRCLE = np.column_stack([np.cos(TURN), np.sin(TURN)])
SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
ELL = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]])
STAR = np.array([[0, 0], [3, -0.4], [4.2, 1], [3.4, 1.6], [4, 3], [2.4, 2.6], [1, 3.4], [0.6, 2], [-0.6, 1.2]])
HALL = np.array([[0.0, 0.0], [18.0, 0.0], [18.0, 12.0], [0.0, 12.0]])


# --- plans and lines -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Drawn:
    """A plan, the points (V, 3) that its rim spans, and exact lines (m, 3) of it, finely sampled."""

    name: str
    plan: Shape
    points: Array
    lines: list[Array]

    @property
    def size(self) -> float:
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))


def filleted(outline: Array, radius: float) -> Array:
    """A closed outline (n, 2) with its corners rounded, each arc with 200 points."""
    pieces = []
    for k, corner in enumerate(outline):
        before, after = outline[k - 1] - corner, outline[(k + 1) % len(outline)] - corner
        before, after = before / np.linalg.norm(before), after / np.linalg.norm(after)
        half = 0.5 * np.arccos(before @ after)
        middle = corner + (before + after) / np.linalg.norm(before + after) * radius / np.sin(half)
        first, last = (corner + radius / np.tan(half) * way - middle for way in (before, after))
        u = np.linspace(0.0, 1.0, 200)[:, None] * (np.pi - 2.0 * half)
        across = last - first * np.cos(np.pi - 2.0 * half)
        pieces.append(middle + np.cos(u) * first + np.sin(u) * across / np.sin(np.pi - 2.0 * half))
    return np.concatenate(pieces)


def flat(name: str, outline: Array, radius: float, count: int, holes: Sequence[Array] = ()) -> Drawn:
    """A plan at height 0 with about `count` vertices."""
    area = abs(enclosed(outline)) - sum(abs(enclosed(hole)) for hole in holes)
    plan = shapes.polygon(outline, holes=holes, max_edge=np.sqrt(1.15 * area / count), corner_radius=radius)
    lines = [filleted(each, radius) if radius else each for each in (outline, *holes)]
    return Drawn(name, plan, in_space(plan.positions), [in_space(line) for line in lines])


def enclosed(outline: Array) -> float:
    x, y = outline.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def in_space(points: Array, heights: Array | float = 0.0) -> Array:
    return np.column_stack([points, np.broadcast_to(heights, len(points))])


def raised(name: str, outline: Array, heights: Array, count: int) -> Drawn:
    """A sharp plan whose corners lie at heights (n,), its sides straight."""
    drawn = flat(name, outline, 0.0, count)
    return replace(drawn, points=along_sides(drawn.points, outline, heights), lines=[in_space(outline, heights)])


def along_sides(points: Array, outline: Array, heights: Array) -> Array:
    """Points (V, 3) with the heights of the nearest side, linear from corner to corner."""
    ahead = np.roll(outline, -1, axis=0) - outline
    to = points[:, None, :2] - outline
    u = np.clip(np.einsum("vki,ki->vk", to, ahead) / np.einsum("ki,ki->k", ahead, ahead), 0.0, 1.0)
    nearest = np.linalg.norm(to - u[:, :, None] * ahead, axis=2).argmin(axis=1)
    part = u[np.arange(len(points)), nearest]
    return in_space(points[:, :2], (1.0 - part) * heights[nearest] + part * np.roll(heights, -1)[nearest])


def waved(amplitude: float, count: int) -> Drawn:
    """A circle that rises and falls twice by the amplitude, times its diameter."""
    plan = shapes.disc(count)
    angle = 2.0 * np.arctan2(plan.positions[:, 1], plan.positions[:, 0])
    fine = 2.0 * np.pi * np.arange(8000) / 8000
    line = np.column_stack([np.cos(fine), np.sin(fine), amplitude * np.cos(2 * fine)])
    height = amplitude * np.cos(angle) * np.linalg.norm(plan.positions, axis=1) ** 2
    return Drawn(f"circle, raised by {50 * amplitude:.0f} % twice", plan, in_space(plan.positions, height), [line])


def plans(count: int) -> list[Drawn]:
    """Eight plans with about `count` vertices each, the last with twice as many."""
    angle = 2.0 * np.pi * np.arange(5) / 5
    pentagon = np.column_stack([np.cos(angle), np.sin(angle)])
    court = np.array([[1.6, 0.9], [1.5, 1.9], [2.4, 1.8], [2.5, 1.0]])
    return [
        flat("square, sharp", SQUARE, 0.0, count),
        flat("square, radius 0.2", SQUARE, 0.2, count),
        flat("rectangle 3 : 1, sharp", SQUARE * [1.5, 0.5], 0.0, count),
        flat("L, radius 0.3", ELL, 0.3, count),
        raised("pentagon, three heights", pentagon, np.array([0.0, 0.3, 0.0, 0.5, 0.2]), count),
        flat("nine corners and a courtyard", STAR, 0.25, count, [court]),
        waved(0.4, count),
        waved(1.2, 2 * count),
    ]


# --- sides that lean -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Leaning:
    """A plan with leans (sides, angle in degrees), and the rise that chooses the surface. plan(n): about n vertices.

    raised: what lifts the points of the plan.
    """

    name: str
    plan: Callable[[int], Shape]
    leans: Sequence[tuple[str, float]]
    rise: float = 0.35
    raised: Callable[[Array], Array] = in_space


def hall(outline: Array = HALL, radius: float = 1.5, holes: Sequence[Array] = ()) -> Callable[[int], Shape]:
    """Plans whose straight sides are "s0" to "sn" without the arcs at their ends; "c0" … have half of these, too."""

    def made(count: int) -> Shape:
        plan = flat("", outline, radius, count, holes).plan
        b = plan.domain.boundary_edges
        ends = plan.positions[plan.domain.edges[b]]
        gaps = np.stack([line_gap(ends.mean(axis=1), outline, k) for k in range(len(outline))])
        for k in range(len(outline)):
            lies = (line_gap(ends.reshape(-1, 2), outline, k).reshape(-1, 2) < 1e-3).all(axis=1)
            plan.sides[f"s{k}"] = b[lies]
            plan.sides[f"c{k}"] = b[(gaps.argmin(axis=0) == k) & (gaps[k] < max(radius, 1e-3))]
        return plan

    return made


def line_gap(points: Array, outline: Array, k: int) -> Array:
    """(n,) distances from side k of an outline."""
    a, b = outline[k], outline[(k + 1) % len(outline)]
    u = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(points - a - u[:, None] * (b - a), axis=1)


def ellipse(count: int) -> Shape:
    """Of 20 × 13; "third" is the part of it in front."""
    plan = shapes.polygon(CIRCLE[::4] * [10.0, 6.5], max_edge=np.sqrt(1.15 * np.pi * 65.0 / count))
    b = plan.domain.boundary_edges
    middle = plan.positions[plan.domain.edges[b]].mean(axis=1) / [10.0, 6.5]
    plan.sides["third"] = b[np.abs(np.arctan2(middle[:, 0], -middle[:, 1])) < np.pi / 3.0]
    return plan


def back_raised(points: Array) -> Array:
    """The hall's back side 1.5 higher, falling along the short sides."""
    return in_space(points, 1.5 * np.clip((points[:, 1] - 1.5) / 9.0, 0.0, 1.0))


COURT = np.array([9.0, 6.0]) + 2.2 * CIRCLE[::10]
HEXAGON = 8.0 * np.column_stack([np.cos(np.pi * np.arange(6) / 3), np.sin(np.pi * np.arange(6) / 3)])
LEANS = [
    Leaning("(a) hall, one side", hall(), [("s0", 35)]),
    Leaning("(a) the same, lower", hall(), [("s0", 35)], rise=0.2),
    *(Leaning("(b) hall, one side", hall(), [("s0", angle)]) for angle in (20, 60, 85, 120, 150)),
    Leaning("(c) L, street", hall(9.0 * ELL), [("s0", 45)]),
    Leaning("(d) sharp, short side", hall(radius=0.0), [("s3", 90)]),
    Leaning("(d) the same", hall(radius=0.0), [("s3", 60)]),
    Leaning("(f) opposite sides", hall(), [("s0", 35), ("s2", 70)]),
    Leaning("(f) opposite sides", hall(), [("s0", 60), ("s2", 70)]),
    Leaning("(g) opposite a raised line", hall(), [("s0", 50)], raised=back_raised),
    *(Leaning("(h) court", hall(holes=[COURT]), [("hole0", angle)], rise=0.5) for angle in (45, 70, 100, 120)),
    *(Leaning("(i) a third of an ellipse", ellipse, [("third", angle)]) for angle in (35, 70)),
    Leaning("two sides about a sharp corner", hall(radius=0.0), [("s3", 60), ("s0", 60)]),
    Leaning("two sides about an arc", hall(), [("c3", 45), ("c0", 45)]),
    Leaning("three sides of a hexagon", hall(HEXAGON, 1.0), [("s0", 65), ("s2", 65), ("s4", 65)]),
    Leaning("L, a re-entrant side, radius 3", hall(9.0 * ELL, 3.0), [("s2", 60)]),
]


# --- random lines ----------------------------------------------------------------------------------------------------


def random_line(seed: int, count: int = 600) -> Drawn:
    """A polygon of three to nine corners about the origin, sharp or rounded, at heights up to half of its span.

    Sharp ones are straight from corner to corner; rounded ones rise and fall by three waves of random size.
    """
    random = np.random.default_rng(seed)
    corners = int(random.integers(3, 10))
    shares = random.uniform(0.4, 1.0, corners)
    angle = 2.0 * np.pi * np.cumsum(shares) / shares.sum()
    outline = random.uniform(0.45, 1.0, corners)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    height = random.uniform(0.0, 0.5) * float(np.ptp(outline, axis=0).max())
    if random.uniform() < 0.5:
        return raised(f"{corners} sharp corners", outline, height * random.uniform(0.0, 1.0, corners), count)
    size, phase = random.normal(size=3) / np.arange(1, 4), random.uniform(0.0, 2.0 * np.pi, 3)
    drawn = flat(f"{corners} round corners", outline, 0.06, count)

    def lifted(points: Array) -> Array:
        around = np.arctan2(points[:, 1], points[:, 0])
        wave = np.cos(np.outer(around, np.arange(1, 4)) + phase) @ size
        return in_space(points[:, :2], 0.5 * height * wave / np.abs(size).sum())

    return replace(drawn, points=lifted(drawn.points), lines=[lifted(line) for line in drawn.lines])
