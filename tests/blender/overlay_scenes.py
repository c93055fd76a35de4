"""Plans under the overlay, and the layers that it draws over them."""

from __future__ import annotations

from itertools import pairwise

import bpy
import numpy as np

from .scenes import add_group, boundary_edges, mesh_object, quad_disc


def disc(kind="BINORMAL", **parameters):
    plan = quad_disc()
    add_group(plan, "rim", boundary_edges(plan.data), kind, **parameters)
    return plan


def arcs(plan, *angles):
    """Boundary edges of a disc between following angles in degrees."""
    edges = boundary_edges(plan.data)
    ends = np.array([[plan.data.vertices[v].co for v in plan.data.edges[e].vertices] for e in edges])
    at = np.degrees(np.arctan2(*ends.mean(axis=1)[:, 1::-1].T)) % 360
    return [edges[(at >= a) & (at < b)] for a, b in pairwise(angles)]


def matrix_of(transform):
    from mathutils import Matrix

    turn = Matrix.Rotation(0.7, 4, (1.0, 2.0, 3.0))
    scale = {"plain": (1, 1, 1), "stretched": (2, 0.7, 1.3), "mirrored": (1, -1.5, 1)}[transform]
    return Matrix.Translation((5, -3, 2)) @ turn @ Matrix.Diagonal((*scale, 1))


def square(count: int = 5, size: float = 4.0):
    ticks = np.linspace(-0.5 * size, 0.5 * size, count)
    points = [(x, y, 0.0) for y in ticks for x in ticks]
    faces = [
        (r * count + c, r * count + c + 1, (r + 1) * count + c + 1, (r + 1) * count + c)
        for r in range(count - 1) for c in range(count - 1)
    ]
    return mesh_object("Square", points, faces)


def sides_of(plan):
    """Edges of a square below, to the right, above, to the left."""
    edges = boundary_edges(plan.data)
    ends = np.array([[plan.data.vertices[v].co for v in plan.data.edges[e].vertices] for e in edges])
    middle = ends.mean(axis=1)
    return [edges[np.isclose(middle[:, k], s * 2.0)] for k, s in ((1, -1), (0, 1), (1, 1), (0, -1))]


def frame(addon):
    bpy.context.view_layer.update()
    return addon.cmc_addon.drawing.overlay.frame(bpy.context)


def layers(parts, kind=None):
    return [layer for part in parts for layer in part.layers if kind in (None, layer.kind)]


def only(name):
    """Switch all off but one."""
    from cmc_formfinding.cmc_addon.properties.overlay_settings import SHOWN

    for other in SHOWN:
        setattr(bpy.context.scene.cmc, other, other == name)
