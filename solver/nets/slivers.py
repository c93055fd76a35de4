"""Clipped panels at the rim that are too small are joined to their neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .rim_nodes import distance_to_chord

Array = NDArray[np.float64]

# A clipped panel is joined to a neighbour if its area is below this part of the neighbour's.
SMALLEST = 0.25


def merged(
    cells: list[list[int]], rim: set[tuple[int, int]], points: Array, kept: set[int], tolerance: float
) -> tuple[list[list[int]], list[list[int]]]:
    """Cells as lists of nodes, after joining, and the numbers of the cells that each consists of.

    rim: pairs of nodes along the boundary, the surface on their left. kept: nodes that stay even where the boundary
    alone runs through them; so do those farther than `tolerance` from the line between their neighbours. Smaller cells
    come first; each joins the neighbour across its longest side.
    """
    polygons = {number: list(cell) for number, cell in enumerate(cells)}
    members = {number: [number] for number in polygons}
    thin = [(cell[0], cell[1], number) for number, cell in polygons.items() if len(cell) == 2]
    left = {pair: number for number, cell in polygons.items() if len(cell) > 2 for pair in _sides(cell)}
    for i, j, number in thin:
        # between the rim and a line that leaves it and comes back at once: the rim takes the place of the line
        pair = (i, j) if (i, j) in rim else (j, i)
        if pair in left:
            del polygons[number]
            members[left[pair]] += members.pop(number)
    rim = set(rim)
    area = dict(enumerate(_areas(cells, points).tolist()))
    clipped = sorted({left[pair] for pair in rim if pair in left}, key=lambda number: area[number])
    for small in clipped:
        sides = [(i, j) for i, j in _sides(polygons[small]) if left.get((j, i), small) != small]
        if not sides:
            continue
        i, j = max(sides, key=lambda pair: float(np.linalg.norm(points[pair[1]] - points[pair[0]])))
        big = left[j, i]
        if area[small] >= SMALLEST * area[big]:
            continue
        joined = _joined(polygons[small], polygons[big], (i, j))
        if joined is None:
            continue
        for number in (small, big):
            for pair in _sides(polygons[number]):
                left.pop(pair, None)
        joined = _without_idle(joined, rim, points, kept, tolerance)
        del polygons[small]
        polygons[big] = joined
        members[big] += members.pop(small)
        area[big] += area.pop(small)
        left.update(dict.fromkeys(_sides(joined), big))
    numbers = sorted(polygons)
    return [polygons[number] for number in numbers], [members[number] for number in numbers]


def _sides(cell: list[int]) -> list[tuple[int, int]]:
    return list(zip(cell, cell[1:] + cell[:1], strict=True))


def _areas(cells: list[list[int]], points: Array) -> Array:
    """The area (P,) of each cell, seen along its normal."""
    sizes = np.array([len(cell) for cell in cells])
    node = np.concatenate(cells)
    first = np.cumsum(sizes) - sizes
    following = np.arange(1, len(node) + 1)
    following[first + sizes - 1] = first
    about = points[node] - np.repeat(points[node[first]], sizes, axis=0)
    swept = np.add.reduceat(np.cross(about, about[following]), first, axis=0)
    return 0.5 * np.linalg.norm(swept, axis=1)


def _joined(small: list[int], big: list[int], side: tuple[int, int]) -> list[int] | None:
    """The two cells without the side (i, j) of the small one between them; None if they share more than that."""
    i, j = side
    at, to = small.index(i), big.index(j)
    around_small = small[at + 1 :] + small[: at + 1]  # from j to i
    around_big = big[to + 1 :] + big[: to + 1]  # from i to j
    joined = around_small + around_big[1:-1]
    return joined if len(set(joined)) == len(joined) else None


def _without_idle(
    cell: list[int], rim: set[tuple[int, int]], points: Array, kept: set[int], tolerance: float
) -> list[int]:
    """The cell without nodes that only the boundary runs through now; `rim` is shortened with it."""
    count = 0
    while count < len(cell):
        before, node, after = cell[count - 1], cell[count], cell[(count + 1) % len(cell)]
        idle = len(cell) > 3 and node not in kept and (before, node) in rim and (node, after) in rim
        if idle and distance_to_chord(points[[node]], points[before], points[after])[0] <= tolerance:
            rim -= {(before, node), (node, after)}
            rim.add((before, after))
            cell = cell[:count] + cell[count + 1 :]
        else:
            count += 1
    return cell
