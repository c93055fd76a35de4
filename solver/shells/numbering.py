"""Numbers in messages: the solver counts triangles and its own edges, a user the faces and vertices of a file."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import CmcError, listed, plural

_MENTION = re.compile(
    r"\b(face|polygon|edge|vertex|vertices)s? (\d+(?:, \d+)*(?: and \d+ more)?)(?: (have|are)\b)?", re.IGNORECASE
)

Number = Callable[[int], int | str]


def renumbered(error: CmcError, number_of: Mapping[str, Number]) -> CmcError:
    """The same error with the indices after "face", "edge", "vertex" in other numbers; a noun without a rule is kept.

    A text in place of a number ("from vertex 1 to 2") stands in the message only.
    """

    def text(match: re.Match[str]) -> str:
        noun = match[1].lower().replace("vertices", "vertex")
        kind = "face" if noun == "polygon" else noun
        if kind not in number_of:
            return match[0]
        return _mention(match, noun, getattr(error, _ATTRIBUTES[kind]), number_of[kind])

    indices = {name: _translated(getattr(error, name), number_of.get(kind)) for kind, name in _ATTRIBUTES.items()}
    return type(error)(_MENTION.sub(text, str(error)), **indices)


_ATTRIBUTES = {"face": "faces", "edge": "edges", "vertex": "vertices"}


def _translated(indices: tuple[int, ...], number: Number | None) -> Iterable[int]:
    if number is None:
        return indices
    return sorted({n for n in map(number, indices) if isinstance(n, int)})


def _mention(match: re.Match[str], noun: str, all_of_kind: tuple[int, ...], number: Number) -> str:
    numbers, verb = match[2], match[3]
    # a shortened list ("… and 3 more") stands for all indices of the error
    given = all_of_kind if numbers == listed(all_of_kind) else [int(n) for n in re.findall(r"\d+", numbers)]
    mapped = list(dict.fromkeys(map(number, given)))
    numbered = [n for n in mapped if isinstance(n, int)]
    if len(numbered) == len(mapped):
        text = plural(noun, numbered)
    else:
        text = f"{noun}{'s' if len(mapped) > 1 else ''} {', '.join(map(str, mapped[:8]))}"
        text += f" and {len(mapped) - 8} more" if len(mapped) > 8 else ""
    if verb:
        text += " " + ({"have": "has", "are": "is"}[verb] if len(mapped) == 1 else verb)
    return text[0].upper() + text[1:] if match[1][0].isupper() else text


def rules(
    vertices: Sequence[int] | NDArray[np.integer] | None, faces: Sequence[int] | NDArray[np.integer] | None
) -> dict[str, Number]:
    """The rules of tables, from index to number; None keeps the indices."""
    tables = {"vertex": vertices, "face": faces}
    return {noun: lambda i, numbers=numbers: int(numbers[i]) for noun, numbers in tables.items() if numbers is not None}


@contextmanager
def drawn_numbers(plan: Any) -> Iterator[None]:
    """Raise a `CmcError` from within in the numbers of the plan as drawn (`polygon_numbers`, `vertex_numbers`).

    An edge has no number in a file, so that its vertices name it.
    """
    try:
        yield
    except CmcError as error:
        if plan.triangle_polygons is None:
            raise
        raise renumbered(error, _plan_rules(plan)) from error


def _plan_rules(plan: Any) -> dict[str, Number]:
    faces, vertices = plan.triangle_polygons, plan.vertex_numbers
    if plan.polygon_numbers is not None:
        faces = plan.polygon_numbers[faces]
    sides = np.concatenate([plan.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    pairs: NDArray[np.integer] = np.unique(np.sort(sides, axis=1), axis=0)
    if vertices is not None:
        pairs = vertices[pairs]
    return rules(vertices, faces) | {"edge": lambda i: "from vertex {} to {}".format(*pairs[i])}
