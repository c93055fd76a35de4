"""Moves the vertices of a plan with its holes, and marks the seams of a new plan."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError
from ..properties.libraries import why_not_kept
from .mesh_bridge import read, set_positions


def check_movable(plan: bpy.types.Object, apply_modifiers: bool) -> None:
    """Raise `CmcError` if the vertices of a plan cannot be moved one by one."""
    mesh = plan.data
    if mesh.is_editmode:
        raise CmcError(f"'{plan.name}' is in edit mode; leave it (Tab) so that its holes can move.")
    if apply_modifiers and plan.modifiers:
        raise CmcError(
            f"'{plan.name}' is solved with its modifiers applied, so its holes cannot move; apply the modifiers, or "
            "close by the normals."
        )
    if mesh.shape_keys is not None:
        raise CmcError(f"'{plan.name}' has shape keys, so its holes cannot move; close by the normals.")
    if reason := why_not_kept(mesh):
        raise CmcError(f"{reason}, so that its holes can move.")


def move_vertices(plan: bpy.types.Object, positions: NDArray[np.float64]) -> None:
    """Move the vertices of a plan to positions (V, 3) in the world."""
    inverse = np.linalg.inv(np.array(plan.matrix_world, dtype=np.float64))
    set_positions(plan.data, positions @ inverse[:3, :3].T + inverse[:3, 3])


def mark_seams(mesh: bpy.types.Mesh, pairs: NDArray[np.integer]) -> None:
    """Mark edges, given as vertex pairs (n, 2), as seams."""
    if not len(pairs):
        return
    wanted = set(map(tuple, np.sort(pairs, axis=1).tolist()))
    ends = np.sort(read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2), axis=1)
    for edge, pair in zip(mesh.edges, map(tuple, ends.tolist()), strict=True):
        edge.use_seam = pair in wanted
