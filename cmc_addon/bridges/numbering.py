"""Translates the indices in the solver's messages into those of the Blender mesh.

The solver numbers triangles and its own edges, a user sees polygons and Blender's edges. Vertices are the same in both.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError
from ...solver.shells.numbering import renumbered
from .mesh_bridge import PlanMesh


def in_plan_numbers(
    error: CmcError, plan: PlanMesh, triangles: NDArray[np.int32], owners: NDArray[np.int32]
) -> CmcError:
    """The same error with faces and edges numbered as in the plan. triangles (T, 3); owners (T,): their polygons.

    A triangle becomes its polygon. A diagonal of a polygon has no number in the plan; its vertices name it.
    """
    return renumbered(error, {"face": lambda i: int(owners[i]), "edge": _plan_edges(plan, triangles)})


def _plan_edges(plan: PlanMesh, triangles: NDArray[np.int32]) -> Callable[[int], int | str]:
    """From the solver's index of an edge (sorted vertex pairs, in order) to Blender's, or to its vertices."""
    sides = [triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]
    pairs = np.unique(np.sort(np.concatenate(sides), axis=1), axis=0)
    known = {(min(a, b), max(a, b)): i for i, (a, b) in enumerate(plan.edges.tolist())}

    def number(index: int) -> int | str:
        pair = tuple(pairs[index].tolist())
        return known.get(pair, f"from vertex {pair[0]} to {pair[1]}")

    return number
