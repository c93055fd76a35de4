"""Surfaces that are symmetric themselves: across a mirror lies the same as one translation away.

Copies by reflection count such a surface several times over: two mirrors that meet at an obtuse angle generate
reflections that lead back to where a copy is already, turned by a symmetry of the surface. A ring of tubes between six
mirrors is of this kind. It goes on by translations, each of which joins a side to another one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ..surface.cmc_surface import CmcSurface
from .isometries import across, translation
from .seams import Seam
from .sides import SidePlane

Array = NDArray[np.float64]

# Cosine of two outward normals above which their planes meet at an obtuse angle; that of parallel ones.
_OBTUSE, _PARALLEL = 0.05, 0.999


def translation_seams(surface: CmcSurface, planes: Sequence[SidePlane], tolerance: float) -> list[Seam] | None:
    """Seams by translation in place of those across the mirrors `planes`, where these meet at obtuse angles and the
    surface is by a translation what it is by each reflection; else None.

    Points that are nearer than the tolerance (a length) are the same.
    """
    points = surface.f_plus
    middle = points.mean(axis=0)
    if surface.is_open or any(plane.normal is None or plane.switches for plane in planes):
        return None
    if not _is_obtuse(planes, middle):
        return None
    tree, seams = KDTree(points), []
    for plane in planes:
        image = across(plane).points(points)
        step = image.mean(axis=0) - middle
        if np.max(tree.query(image - step)[0]) > tolerance:
            return None
        apart, there = (np.asarray(found) for found in tree.query(points[plane.rows] - step))
        on_side = [np.isin(there, other.rows).all() for other in planes]
        if apart.max() > tolerance or len(np.unique(there)) < len(there) or not any(on_side):
            return None
        seams.append(Seam(plane.name, translation(step), plane.rows, there))
    return seams


def _is_obtuse(planes: Sequence[SidePlane], middle: Array) -> bool:
    normals = np.array([plane.normal for plane in planes], dtype=np.float64).reshape(-1, 3)
    heights = normals @ middle - np.array([plane.offset for plane in planes])
    outward = normals * np.where(heights > 0.0, -1.0, 1.0)[:, None]
    cosines = outward @ outward.T
    return bool(((cosines > _OBTUSE) & (cosines < _PARALLEL)).any())
