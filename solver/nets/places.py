"""Points and normals of a sheet inside its triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..gauss.sphere import normalize
from .sheets import Sheet

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def points_at(sheet: Sheet, faces: Int, barycentric: Array) -> Array:
    """Points (n, 3) at barycentric coordinates (n, 3) of faces (n,), on the curved surface through the corners.

    Half-way between the flat triangle and its projections on the tangent planes at the corners: exact for quadrics
    (Boubekeur and Alexa's Phong tessellation).
    """
    corner = sheet.points[sheet.domain.faces[faces]]
    N = sheet.normals[sheet.domain.faces[faces]]
    flat = np.einsum("nk,nkd->nd", barycentric, corner)
    height = np.einsum("nkd,nkd->nk", flat[:, None, :] - corner, N)
    return flat - 0.5 * np.einsum("nk,nk,nkd->nd", barycentric, height, N)


def normals_at(sheet: Sheet, faces: Int, barycentric: Array) -> Array:
    """Unit normals (n, 3), linear between the corners."""
    return normalize(np.einsum("nk,nkd->nd", barycentric, sheet.normals[sheet.domain.faces[faces]]))
