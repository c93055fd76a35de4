"""The distance of a result from the surface that it approximates, as numbers and as colours."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from ..bridges.mesh_bridge import set_attribute

DEVIATION_ATTRIBUTE = "cmc_deviation"
DEVIATION_COLOURS = "cmc_deviation_colour"

# From zero to the largest: blue, white, red.
_COLOURS = np.array([(0.10, 0.25, 0.75), (0.95, 0.95, 0.90), (0.80, 0.10, 0.05)])


def deviation_from(
    positions: NDArray[np.float64], triangles: NDArray[np.int32], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Distances (n,) of points (n, 3) from the closest points of a surface, positions (V, 3) and triangles (T, 3)."""
    centre = positions.mean(axis=0)  # the tree is in single precision
    tree = BVHTree.FromPolygons((positions - centre).tolist(), triangles.tolist())
    return np.array([tree.find_nearest(point)[3] for point in (points - centre).tolist()])


def show_deviation(plan: bpy.types.Object, result: bpy.types.Object, deviation: NDArray[np.float64]) -> None:
    """Write the deviation of each vertex as a number and as a colour.

    The colours become the active ones, which Solid shading shows by Attribute, unless the plan has its own.
    """
    mesh = result.data
    set_attribute(mesh, DEVIATION_ATTRIBUTE, "FLOAT", "POINT", deviation)
    part = deviation / (deviation.max() or 1.0)
    colour = [np.interp(part, [0.0, 0.5, 1.0], channel) for channel in _COLOURS.T]
    set_attribute(mesh, DEVIATION_COLOURS, "FLOAT_COLOR", "POINT", np.column_stack([*colour, np.ones(len(part))]))
    if plan.type == "MESH" and not len(plan.data.color_attributes):
        mesh.color_attributes.active_color_name = DEVIATION_COLOURS
