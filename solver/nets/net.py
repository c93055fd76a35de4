"""A net of panels on a surface, and its measures."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import plural
from ..signatures import checked
from ..surface import convert
from .panel_measures import corner_angles, least_width, longest_diagonal, vector_area

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Lines that are farther than this from their exact directions, in the mean, are not what was asked for.
_OFF = np.radians(5.0)


@dataclass(frozen=True, eq=False)
class Net:
    """Panels between two families of lines, and what is left of them along the rim.

    vertices, normals: (n, 3), N with which H is positive. polygons: the P panels, nodes counter-clockwise seen from N.
    edges: (m, 2), family: (m,) 0 along the larger principal curvature, 1 along the smaller one, -1 on the rim; of a
    diagonal net its two families. rim_edges: (m,) the boundary edge of the domain on which an edge of the rim begins,
    -1 inside, and where ends of lines were dropped. faces (n,), barycentric (n, 3): where the nodes are on the
    triangles of the domain. clipped: (P,) panels cut by the rim, where it is no line of the net. orders: (P,) the sum
    of the orders of the umbilics inside each panel: an inner one has 4 + 2 orders corners. branched: panels in which
    this sheet has a branch point. kind, sheet: what was asked for. spacing: the panel side wanted; spacings: (2,) of
    the lines, in units of w, so that sides are spacing / √(k1 - k2). curvature: (P,) the larger principal curvature k1.
    deviation: the mean angle between lines and their exact directions, in radians. mean_curvature: H.
    euler_characteristic: of the surface. folded: vertices of the domain at which the surface turns over. axes, moved,
    flatness: of nets with flat panels, see `planarise`.
    """

    vertices: Array
    normals: Array
    polygons: list[Int]
    edges: Int
    family: Int
    rim_edges: Int
    faces: Int
    barycentric: Array
    clipped: NDArray[np.bool_]
    orders: Int
    branched: Int
    kind: str
    sheet: str
    spacing: float
    spacings: Array
    curvature: Array
    deviation: float
    mean_curvature: float
    euler_characteristic: int
    folded: Int
    axes: Array | None = None
    moved: Array | None = None
    flatness: float | None = None

    def __repr__(self) -> str:
        return f"Net({self.summary})"

    @property
    def summary(self) -> str:
        """Counts and sizes in one line."""
        sides = self.side_lengths
        low, high = np.quantile(sides, [0.05, 0.95]) if len(sides) else (np.nan, np.nan)
        umbilics = f", {len(self.umbilics)} with umbilics" if len(self.umbilics) else ""
        return (
            f"{len(self.polygons)} panels ({len(self.inner)} whole, {int(self.clipped.sum())} clipped{umbilics}), "
            f"sides {low:.3g} to {high:.3g}"
        )

    @property
    def ok(self) -> bool:
        """Whether the panels cover the surface once, look the same way, and follow its curvature."""
        return (
            self.counted == self.euler_characteristic
            and self.deviation <= _OFF
            and (self.sheet == "g" or not len(self.flipped))
        )

    @property
    def message(self) -> str:
        """The panels in a sentence, and what is wrong with them or with the surface."""
        sentences = [f"{self.summary[0].upper()}{self.summary[1:]}: all different in outline."]
        if len(self.folded):
            sentences.append(
                f"The surface is folded at {plural('vertex', self.folded)}, where panels turn over; round the corner "
                "of the plan there, or let leans change gradually."
            )
        if len(self.branched):
            has = "has" if len(self.branched) == 1 else "have"
            sentences.append(
                f"{plural('panel', self.branched).capitalize()} {has} a branch point of {self.sheet}, where sides "
                "shrink to nothing; take the other sheet."
            )
        if self.counted != self.euler_characteristic or self.deviation > _OFF:
            sentences.append("The panels do not follow the curvature of the surface; refine the mesh.")
        elif not self.ok and not len(self.folded):
            sentences.append(f"{plural('panel', self.flipped).capitalize()} turn over; choose a smaller spacing.")
        return " ".join(sentences)

    @property
    def umbilics(self) -> Int:
        """The panels with an umbilic in them."""
        return np.flatnonzero(self.orders)

    @property
    def indices(self) -> Array:
        """The index of the umbilics in each of these panels, -½ of their order."""
        return -0.5 * self.orders[self.umbilics]

    @property
    def inner(self) -> Int:
        """The whole panels: those that the rim does not cut."""
        return np.flatnonzero(~self.clipped)

    @property
    def sphere_gap(self) -> float:
        """How far each whole panel of a principal net departs from the sphere of radius 1 / |H|: w² / 16."""
        return float(np.prod(self.spacings) / 16.0)

    @property
    def rim(self) -> Int:
        """The nodes on the rim."""
        return np.unique(self.edges[self.family < 0])

    @cached_property
    def side_lengths(self) -> Array:
        """Lengths of the edges that are pieces of lines."""
        i, j = self.edges[self.family >= 0].T
        return np.linalg.norm(self.vertices[j] - self.vertices[i], axis=1)

    @cached_property
    def planarity(self) -> Array:
        """(P,) the least distance of two parallel planes with the panel's corners between them, in model length."""
        return self._measured(least_width)

    @cached_property
    def diagonal(self) -> Array:
        """(P,) the longest diagonal of each panel."""
        return self._measured(longest_diagonal)

    @cached_property
    def area(self) -> Array:
        """(P,) the area of each panel, seen along its normal."""
        return np.linalg.norm(self._vector_area, axis=1)

    @cached_property
    def corner_angles(self) -> list[Array]:
        """The angles at the corners of each panel, in radians."""
        found: list[Array] = [np.zeros(0)] * len(self.polygons)
        for numbers, corners in self._groups():
            for number, angles in zip(numbers.tolist(), corner_angles(corners), strict=True):
                found[number] = angles
        return found

    @cached_property
    def flipped(self) -> Int:
        """Panels that face away from the mean of the normals at their corners; g does so where f± are saddles."""
        mean = np.array([self.normals[polygon].sum(axis=0) for polygon in self.polygons]).reshape(-1, 3)
        return np.flatnonzero(np.einsum("pi,pi->p", self._vector_area, mean) <= 0.0)

    @cached_property
    def torsion(self) -> Array:
        """Angles between the planes that an inner edge spans with the normals at its two ends, in radians."""
        i, j = self.edges[self.family >= 0].T
        e = self.vertices[j] - self.vertices[i]
        a, b = np.cross(e, self.normals[i]), np.cross(e, self.normals[j])
        return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ei,ei->e", a, b))

    @cached_property
    def normal_curvature(self) -> Array:
        """(m,) along each edge, <ΔX, ΔN> / |ΔX|²."""
        i, j = self.edges.T
        e, n = self.vertices[j] - self.vertices[i], self.normals[j] - self.normals[i]
        return np.einsum("ei,ei->e", e, n) / np.einsum("ei,ei->e", e, e)

    @property
    def counted(self) -> int:
        """V - E + F, the Euler characteristic of the surface."""
        return len(self.vertices) - len(self.edges) + len(self.polygons)

    @cached_property
    def _vector_area(self) -> Array:
        return self._measured(vector_area, 3)

    def _measured(self, measure: Callable[[Array], Array], width: int = 0) -> Array:
        found = np.zeros((len(self.polygons), width) if width else len(self.polygons))
        for numbers, corners in self._groups():
            found[numbers] = measure(corners)
        return found

    def _groups(self) -> list[tuple[Int, Array]]:
        """The panels by their number of corners: their numbers (p,) and corners (p, k, 3)."""
        sizes = np.array([len(polygon) for polygon in self.polygons])
        groups = []
        for size in np.unique(sizes):
            numbers = np.flatnonzero(sizes == size)
            groups.append((numbers, self.vertices[np.stack([self.polygons[k] for k in numbers])]))
        return groups

    @checked
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the panels as OBJ, PLY, STL or GLB, by the suffix; raises `JobError` where that fails."""
        convert.save_mesh(path, self.vertices, self.polygons, self.normals)
