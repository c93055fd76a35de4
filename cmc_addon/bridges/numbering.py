"""Translates the indices in the solver's messages into those of the Blender mesh.

The solver numbers triangles and its own edges, a user sees polygons and Blender's edges. Vertices are the same in both.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError, listed, plural
from .mesh_bridge import PlanMesh

_MENTION = re.compile(r"\b(face|edge)s? (\d+(?:, \d+)*(?: and \d+ more)?)(?: (have|are)\b)?", re.IGNORECASE)


def in_plan_numbers(
    error: CmcError, plan: PlanMesh, triangles: NDArray[np.int32], owners: NDArray[np.int32]
) -> CmcError:
    """The same error with faces and edges numbered as in the plan. triangles (T, 3); owners (T,): their polygons.

    A triangle becomes its polygon. A diagonal of a polygon has no number in the plan; its vertices name it.
    """
    edges = _plan_edges(plan, triangles)
    faces_of = {"face": lambda i: int(owners[i]), "edge": edges}
    message = _MENTION.sub(lambda match: _renumbered(match, error, faces_of), str(error))
    return type(error)(
        message,
        vertices=error.vertices,
        faces=sorted({int(owners[i]) for i in error.faces}),
        edges=sorted({e for e in map(edges, error.edges) if isinstance(e, int)}),
    )


def _renumbered(match: re.Match, error: CmcError, number_of: dict[str, Callable[[int], int | str]]) -> str:
    noun, numbers, verb = match.group(1), match.group(2), match.group(3)
    all_of_kind = {"face": error.faces, "edge": error.edges}[noun.lower()]
    # a shortened list ("… and 3 more") stands for all indices of the error
    given = all_of_kind if numbers == listed(all_of_kind) else [int(n) for n in re.findall(r"\d+", numbers)]
    mapped = list(dict.fromkeys(number_of[noun.lower()](i) for i in given))
    numbered = [i for i in mapped if isinstance(i, int)]
    if len(numbered) == len(mapped):
        text = plural(noun.lower(), numbered)
    else:
        text = f"{noun.lower()}{'s' if len(mapped) > 1 else ''} {', '.join(map(str, mapped))}"
    if verb:
        text += " " + ({"have": "has", "are": "is"}[verb] if len(mapped) == 1 else verb)
    return text[0].upper() + text[1:] if noun[0].isupper() else text


def _plan_edges(plan: PlanMesh, triangles: NDArray[np.int32]) -> Callable[[int], int | str]:
    """From the solver's index of an edge (sorted vertex pairs, in order) to Blender's, or to its vertices."""
    sides = [triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]
    pairs = np.unique(np.sort(np.concatenate(sides), axis=1), axis=0)
    known = {(min(a, b), max(a, b)): i for i, (a, b) in enumerate(plan.edges.tolist())}

    def number(index: int) -> int | str:
        pair = tuple(pairs[index].tolist())
        return known.get(pair, f"from vertex {pair[0]} to {pair[1]}")

    return number
