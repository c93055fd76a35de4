"""A domain with vertex positions and named sides, and `as_domain`: calls that want a domain take such a shape, too."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import NDArray

from ..errors import MeshError
from .domain import Domain


@dataclass(frozen=True, eq=False)
class Shape:
    """A domain, the places of its vertices `positions` (V, 2|3), and its `sides`: name → indices into `domain.edges`.

    Every boundary edge is on at least one side; a side lists its edges in the order of the boundary loop.
    """

    domain: Domain
    positions: NDArray
    sides: dict[str, NDArray]

    def __repr__(self) -> str:
        domain = repr(self.domain).removeprefix("Domain(").removesuffix(")")
        return f"Shape({domain}; sides: {', '.join(self.sides) or 'none'})"


DomainLike = Domain | Shape


def as_domain(given: DomainLike) -> Domain:
    """The domain itself, or the domain of a shape; raises `MeshError` on anything else."""
    if isinstance(given, Shape):
        return given.domain
    if isinstance(given, Domain):
        return given
    raise MeshError(
        f"A Domain or a Shape is needed here, not {type(given).__name__}; "
        "make one with Domain.from_positions(vertices, faces)."
    )
