"""Surfaces with a symmetry of their own, whose reflection in a side is also a translation.

Reflections would count such a surface several times: two mirrors that meet at an obtuse angle generate reflections that
lead back to a copy that is there already, turned by a symmetry of the surface. A ring of tubes between six mirrors is
of this kind. It continues by translations, each joining one side to another.
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

# Cosine of two outward normals above which their planes meet at an obtuse angle, and above which they are parallel.
_OBTUSE, _PARALLEL = 0.05, 0.999


def translation_seams(surface: CmcSurface, planes: Sequence[SidePlane], tolerance: float) -> list[Seam] | None:
    """Seams by translation in place of those across the mirrors `planes`; None if reflection is the right way.

    They apply where the mirrors meet at obtuse angles and each reflection of the surface is also a translation of it,
    points nearer than the tolerance (a length) being the same.
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
        apart, there = (np.asarray(nearest) for nearest in tree.query(points[plane.cut_vertices] - step))
        on_side = [np.isin(there, other.cut_vertices).all() for other in planes]
        if apart.max() > tolerance or len(np.unique(there)) < len(there) or not any(on_side):
            return None
        seams.append(Seam(plane.name, translation(step), plane.cut_vertices, there))
    return seams


def _is_obtuse(planes: Sequence[SidePlane], middle: Array) -> bool:
    normals = np.array([plane.normal for plane in planes], dtype=np.float64).reshape(-1, 3)
    heights = normals @ middle - np.array([plane.offset for plane in planes])
    outward = normals * np.where(heights > 0.0, -1.0, 1.0)[:, None]
    cosines = outward @ outward.T
    return bool(((cosines > _OBTUSE) & (cosines < _PARALLEL)).any())
