"""Random plans with leaning rims, and shells over them, for tests of nets."""

from __future__ import annotations

import numpy as np

from solver import CmcError, Shape, conditions, shapes, solve_cmc
from solver.surface.cmc_surface import CmcSurface


def outline(random: np.random.Generator) -> np.ndarray:
    """4 to 8 corners around the origin, a third of them at very different distances."""
    count = int(random.integers(4, 9))
    angle = 2.0 * np.pi * (np.arange(count) + random.uniform(-0.25, 0.25, count)) / count
    nearest = 0.45 if random.random() < 1.0 / 3.0 else 0.8
    return random.uniform(nearest, 1.0, count)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def tilts(plan: Shape, random: np.random.Generator, width: float) -> np.ndarray:
    """Tilts (B,) of the outer edges, 10° to 60° a side, blended along the rim over `width`."""
    edges = plan.sides["outer"]
    sides = [name for name in plan.sides if name.startswith("side")]
    of_side = np.zeros(len(edges))
    for name in sides:
        of_side[np.isin(edges, plan.sides[name])] = np.radians(random.uniform(10.0, 60.0))
    if not width:
        return of_side
    lengths = plan.domain.edge_lengths[edges]
    at, around = np.cumsum(lengths) - 0.5 * lengths, lengths.sum()
    apart = np.abs(at[:, None] - at[None, :])
    apart = np.minimum(apart, around - apart)
    weights = np.exp(-0.5 * (apart / width) ** 2) * lengths
    return weights @ of_side / weights.sum(axis=1)


def shell(seed: int, vertices: int = 600, rounded: bool = True) -> CmcSurface | None:
    """A surface of mean curvature ½ over a random plan; None where the plan cannot be meshed or the map not found."""
    random = np.random.default_rng(seed)
    corners = outline(random)
    radius = 0.25 if rounded else 0.0
    try:
        plan = shapes.polygon(corners, max_edge=float(np.sqrt(2.2 / vertices)), corner_radius=radius)
    except CmcError:
        return None
    lean = tilts(plan, random, 0.15 if rounded else 0.0)
    rim = conditions.binormal(plan, plan.positions, plan.sides["outer"], lean)
    surface = solve_cmc(plan, rim)
    return surface if surface.ok else None
