"""Shapes: domains with vertex positions and named sides. Calls that want a domain take a shape, too (`as_domain`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError, MeshError, check_choice
from ..notes import Note
from .domain import Domain


@dataclass(frozen=True, eq=False)
class Shape:
    """A domain with `positions` (V, 2|3) of its vertices and `sides`: name → indices into `domain.edges`.

    Every boundary edge is on at least one side; a side lists its edges in the order of the boundary loop. notes: what
    differs from the drawing.
    """

    domain: Domain
    positions: NDArray
    sides: dict[str, NDArray]
    notes: tuple[Note, ...] = ()

    def __repr__(self) -> str:
        domain = repr(self.domain).removeprefix("Domain(").removesuffix(")")
        return f"Shape({domain}; sides: {', '.join(self.sides) or 'none'})"


DomainLike = Annotated[Domain | Shape, "as_domain checks it"]


def as_domain(given: DomainLike) -> Domain:
    """The domain itself, or the domain of a shape; raises `MeshError` on anything else."""
    if isinstance(given, Shape):
        return given.domain
    if isinstance(given, Domain):
        return given
    has_shape = isinstance(getattr(given, "shape", None), Shape)
    way = "pass its .shape" if has_shape else "make one with Domain.from_positions(vertices, faces)"
    raise MeshError(f"A Domain or a Shape is needed here, not {type(given).__name__}; {way}.")


def is_names(edges: Any) -> bool:
    """Whether edges are given by the names of sides: a string, or a sequence of strings."""
    if isinstance(edges, np.ndarray) and edges.dtype.kind in "UO":
        edges = edges.ravel().tolist()
    if isinstance(edges, (list, tuple)):
        return len(edges) > 0 and all(isinstance(name, str) for name in edges)
    return isinstance(edges, str)


def side_edges(given: DomainLike, names: str | Sequence[str]) -> NDArray[np.int64]:
    """Edges (K,) of the named sides of a shape, in the order of the names, each edge once.

    Raises `ConditionError` for a name the shape does not have, and for names on a bare domain.
    """
    wanted = [names] if isinstance(names, str) else [str(name) for name in np.ravel(names)]
    if not isinstance(given, Shape):
        as_domain(given)
        raise ConditionError(f"A Domain has no side {wanted[0]!r}; pass the Shape, or the edges themselves.")
    for name in wanted:
        check_choice(name, given.sides, "side")
    edges = np.concatenate([np.asarray(given.sides[name], dtype=np.int64) for name in wanted])
    return edges[np.sort(np.unique(edges, return_index=True)[1])]
