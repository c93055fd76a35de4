"""The mean curvature of the corner complex, a mesh of flat panels, by Steiner's formula.

With normals at vertices f± = g ± N on the corners of the domain has flat polygons only: that of g around each vertex,
at right angles to N_i; the triangle of the normals of each face; and a rectangle for each edge, with sides τ_ij and N_j
- N_i, which are at right angles since τ_ij = w N_i × N_j. Moved along N by t the first ones keep their shape, triangles
grow as (1 + t)² and rectangles as 1 + t. So the area is A(t) = A + 2 t ∫H + t² ∫K with ∫H = ½ A_rectangles +
A_triangles: rectangles have H = ½ exactly, triangles 1, the others 0, and the mean over the surface tends to ½ (second
order).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..surface.cmc_surface import CmcSurface

Array = NDArray[np.float64]


def steiner_mean_curvature(surface: CmcSurface, sheet: str = "f+") -> float | None:
    """∫H / A of the corner complex of f+ or f-, in the units of the surface; areas turned over count as negative.

    None where normals are not at vertices, on surfaces that are cut open, and at H = 0.
    """
    if not surface.graph.at_vertices or surface.is_open or not np.isfinite(surface.scale):
        return None
    N, domain = surface.harmonic.normals, surface.graph.domain
    polygons = _polygons(surface, N)
    a, b, c = (N[domain.faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    triangles = 0.5 * float((np.linalg.norm(across, axis=1) * np.sign(np.einsum("fi,fi->f", across, a + b + c))).sum())
    i, j = domain.edges.T
    apart = np.linalg.norm(N[j] - N[i], axis=1)
    rectangles = float((domain.cotan_weights * np.linalg.norm(np.cross(N[i], N[j]), axis=1) * apart).sum())
    sign = 1.0 if sheet == "f+" else -1.0
    curvature, area = 0.5 * rectangles + sign * triangles, rectangles + sign * (triangles + polygons)
    return curvature / (area * surface.scale) if area else None


def _polygons(surface: CmcSurface, N: Array) -> float:
    """The area of the polygons of g around the vertices, seen from N; at the rim one edge closes them (Fig. 7)."""
    domain, conjugate = surface.graph.domain, surface.conjugate
    left, right = domain.edge_faces.T
    on_left, on_right = conjugate.g[left], conjugate.g[np.maximum(right, 0)]
    on_right[domain.boundary_edges] = conjugate.boundary_points
    tail, head = domain.edges.T
    swept = np.cross(on_right, on_left)
    area = 0.5 * float(np.einsum("ei,ei->", N[tail] - N[head], swept))
    leaving, arriving = np.zeros((2, domain.vertex_count, 3))
    leaving[tail[domain.boundary_edges]] = arriving[head[domain.boundary_edges]] = conjugate.boundary_points
    rim = domain.boundary_vertices
    return area + 0.5 * float(np.einsum("vi,vi->", N[rim], np.cross(arriving[rim], leaving[rim])))
