"""Coarse plans of modules, solved, and measures of their completed copies."""

from __future__ import annotations

import json

import bpy
import numpy as np
from scipy.spatial import KDTree

FINISHED = {"FINISHED"}
EDGES = 9
COPIES = {"NODOID": 8, "UNDULOID": 8, "QUADRILATERAL": 16, "HONEYCOMB": 24, "CAPITAL": 4}
"""Copies in a unit."""


def module(name: str, **options) -> bpy.types.Object:
    """The plan of a preset, coarse, as the menu makes it."""
    assert bpy.ops.cmc.add_module(module=name, edges=options.pop("edges", EDGES), **options) == FINISHED
    return bpy.context.object


def solved(name: str, **options) -> bpy.types.Object:
    plan = module(name, **options)
    assert bpy.ops.cmc.solve() == FINISHED
    return plan


def completion_report(plan: bpy.types.Object) -> dict:
    return json.loads(plan.cmc.complete_report)


def matrices(plan: bpy.types.Object) -> np.ndarray:
    bpy.context.view_layer.update()
    return np.array([ob.matrix_world for ob in plan.cmc.copies.objects])


def faces_of(mesh: bpy.types.Mesh) -> list[tuple[int, ...]]:
    return [tuple(polygon.vertices) for polygon in mesh.polygons]


def is_oriented(mesh: bpy.types.Mesh) -> bool:
    """Whether no two faces walk an edge in the same direction."""
    walked = [pair for face in faces_of(mesh) for pair in zip(face, face[1:] + face[:1], strict=True)]
    return len(set(walked)) == len(walked)


def farthest(points: np.ndarray, others: np.ndarray) -> float:
    """Largest distance of points (n, 3) from the nearest of the others."""
    return float(KDTree(others).query(points)[0].max())
