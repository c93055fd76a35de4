"""Boundary conditions as data: prescribed normals and mirrors, added up and resolved into one normal a site."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError, plural
from .frames import blend, of_boundary

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def _none() -> Int:
    return np.zeros(0, dtype=np.int64)


def _no_normals() -> Array:
    return np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class Conditions:
    """Prescribed unit normals and mirrors, not yet combined: owners (n,) may repeat. Sums by `+`.

    vertices, vertex_normals: at vertices. edges, edge_normals: the same conditions in the middle of boundary edges.
    behind_normals: (n, 3) the same at the faces behind `edges`, where a drawn surface knows them; else `edge_normals`.
    faces, face_normals: at faces, prescribed one by one. only_vertices: those of `vertices` prescribed one
    by one and so hold no faces.
    mirrors, mirror_normals, windings: boundary edges, the unit normal of their mirror's plane, and the extra full turns
    of the normal along their side. corners, corner_normals: vertices between two mirrors, and vectors on the chosen
    side of the normals there.
    lines: boundary edges on which the rim lies; curves: pairs of whole loops of them and the points (m, 3) of a closed
    curve in their place. leans, lean_angles: boundary edges over which the rim stays, and the angle there. Both are for
    surfaces that are spanned, and say nothing about normals.
    up: (3,) the oriented area vector of the positions the conditions were made from, zero without positions: the side
    to which coplanar data bulge (see `initial_map`).
    is_balanced: whether the map is sought among balanced ones (see `balance`).
    """

    vertices: Int = field(default_factory=_none)
    vertex_normals: Array = field(default_factory=_no_normals)
    edges: Int = field(default_factory=_none)
    edge_normals: Array = field(default_factory=_no_normals)
    behind_normals: Array = field(default_factory=_no_normals)
    faces: Int = field(default_factory=_none)
    face_normals: Array = field(default_factory=_no_normals)
    only_vertices: Int = field(default_factory=_none)
    mirrors: Int = field(default_factory=_none)
    mirror_normals: Array = field(default_factory=_no_normals)
    windings: Int = field(default_factory=_none)
    corners: Int = field(default_factory=_none)
    corner_normals: Array = field(default_factory=_no_normals)
    lines: Int = field(default_factory=_none)
    curves: tuple[tuple[Int, Array], ...] = ()
    leans: Int = field(default_factory=_none)
    lean_angles: Array = field(default_factory=lambda: np.zeros(0))
    up: Array = field(default_factory=lambda: np.zeros(3))
    is_balanced: bool = False

    def __repr__(self) -> str:
        counts = {
            "fixed edges": self.edges,
            "fixed vertices": self.only_vertices,
            "fixed faces": self.faces,
            "mirror edges": self.mirrors,
            "corners": self.corners,
            "edges on lines": self.lines,
            "leaning edges": self.leans,
        }
        parts = [f"{len(np.unique(items))} {noun}" for noun, items in counts.items() if len(items)]
        parts += ["balanced"] if self.is_balanced else []
        return f"Conditions({', '.join(parts) or 'free'})"

    def __post_init__(self) -> None:
        if len(self.behind_normals) != len(self.edges):
            object.__setattr__(self, "behind_normals", self.edge_normals)

    def __add__(self, other: Conditions) -> Conditions:
        if not isinstance(other, Conditions):
            return NotImplemented
        names = [item.name for item in fields(self) if item.name not in ("up", "is_balanced", "curves")]
        joined = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in names}
        # conditions on one surface share their area vector; a sum would only change its length
        up = self.up if self.up.any() else other.up
        balanced, curves = self.is_balanced or other.is_balanced, self.curves + other.curves
        return Conditions(**joined, curves=curves, up=up, is_balanced=balanced)

    @property
    def is_empty(self) -> bool:
        """Whether every site is free."""
        return not (self.vertices.size or self.edges.size or self.faces.size or self.mirrors.size or self.is_spanned)

    @property
    def is_spanned(self) -> bool:
        """Whether the rim lies on lines or leans over them somewhere."""
        return bool(self.lines.size or self.leans.size)

    def resolve(self, sites: str = "vertices", owners: Int | None = None) -> tuple[Int, Array]:
        """Sorted fixed sites (n,) and the unit normal (n, 3) of each, with normals at vertices or at faces.

        Sites that only mirrors hold are left out (see `admissible.resolved`). owners: (E,) the site that each boundary
        edge fixes, needed unless sites are vertices. Raises `ConditionError` naming the sites whose normals cancel, or
        normals prescribed one by one at the other kind of site, and lines, along which normals are not prescribed.
        """
        if self.is_spanned:
            raise ConditionError(
                "A rim on lines, or leaning over them, is spanned, not solved for normals; use form or span_outline."
            )
        if sites == "vertices":
            self._refuse(self.faces, "face", "faces", "vertices")
            return blend(self.vertices, self.vertex_normals, np.ones(len(self.vertices)), "conditions")
        self._refuse(self.only_vertices, "vertex", "vertices", sites)
        if owners is None:
            raise ConditionError("With normals at faces, resolve needs owners: the site that each boundary edge fixes.")
        along = self.behind_normals if sites == "faces" else self.edge_normals
        edges, edge_normals = blend(self.edges, along, np.ones(len(self.edges)), "conditions", "edge")
        fixed = np.concatenate([of_boundary(edges, owners), self.faces])
        normals = np.concatenate([edge_normals, self.face_normals])
        return blend(fixed, normals, np.ones(len(fixed)), "conditions", "face")

    def carried(self, edges: Int) -> Conditions:
        """The same conditions on another triangulation of the domain; `edges` (E,) are the boundary edges there.

        Raises `ConditionError` for normals prescribed at faces one by one, since those faces are gone.
        """
        if self.faces.size:
            raise ConditionError(
                f"Normals are prescribed at {plural('face', np.unique(self.faces))}, which the Delaunay triangulation "
                "does not have; prescribe them along boundary edges, or solve with delaunay=False.",
                faces=self.faces,
            )
        return replace(self, edges=of_boundary(self.edges, edges), mirrors=of_boundary(self.mirrors, edges))

    def _refuse(self, single: Int, noun: str, given: str, wanted: str) -> None:
        if single.size:
            raise ConditionError(
                f"Normals are prescribed at {plural(noun, np.unique(single))}, but live at {wanted} here; solve with "
                f"sites={given!r}, or prescribe them along boundary edges.",
                **{given: single},
            )


def check_conditions(given: object) -> None:
    """Raise `ConditionError` on anything but `Conditions`, such as the name of a side."""
    if not isinstance(given, Conditions):
        raise ConditionError(
            f"Conditions are needed here, not {type(given).__name__}; "
            'make them with functions of `conditions`, such as conditions.binormal(shape, "outer", tilt=0.5).'
        )
