"""Seams between a copy of a surface and the next one: along sides, and along the cuts of an open surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.connectivity import after, before
from ..surface.cmc_surface import CmcSurface
from .isometries import Isometry, across, translation
from .sides import SidePlane

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Jumps across a cut that differ by less than this part of the longest period are the same translation.
_SAME_JUMP = 1e-6


@dataclass(frozen=True, eq=False)
class Seam:
    """Cut vertex `here[i]` of a copy C is cut vertex `there[i]` of the copy C · `step`; the same, except at cuts."""

    name: str
    step: Isometry
    here: Int
    there: Int


def side_seams(planes: Sequence[SidePlane]) -> list[Seam]:
    return [Seam(plane.name, across(plane), plane.cut_vertices, plane.cut_vertices) for plane in planes]


def cut_seams(surface: CmcSurface) -> list[Seam]:
    """The seams of a surface that is cut open: across a cut it continues as its own copy, translated by the jump.

    Named "cut 0", "cut 1", … and, seen from the other side, "cut 0 back". The two banks of a cut without a jump are
    welded.
    """
    if not surface.is_open:
        return []
    here, there = _banks(surface)
    jumps = surface.g[here] - surface.g[there]
    scale = _SAME_JUMP * max(surface.gap, 1e-300)
    keys, of_pair = np.unique(np.round(jumps / scale).astype(np.int64), axis=0, return_inverse=True)
    seams: list[Seam] = []
    for k in range(len(keys)):
        on = of_pair.ravel() == k
        pairs = np.unique(np.column_stack([here[on], there[on]]), axis=0)
        step = translation(jumps[on].mean(axis=0))
        seams.append(Seam(f"cut {k}", step, pairs[:, 0], pairs[:, 1]))
        back = translation(-step.translation)
        seams.append(Seam(f"cut {k} back", back, pairs[:, 1], pairs[:, 0]))
    return seams


def _banks(surface: CmcSurface) -> tuple[Int, Int]:
    """Cut vertices (n,), (n,): the same vertex seen from the left and from the right face of an edge that is cut."""
    domain = surface.domain
    inside = domain.interior_edges
    left, right = domain.half_edges[inside].T
    corners = surface.faces.ravel()
    # what starts the left half-edge ends the right one; by corners, as a face may have a vertex twice
    starts = corners[after(left)], corners[before(right)]
    ends = corners[before(left)], corners[after(right)]
    here, there = (np.concatenate(pair) for pair in zip(starts, ends, strict=True))
    cut = here != there
    return here[cut], there[cut]
