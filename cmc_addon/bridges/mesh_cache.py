"""Numbers of a mesh in the sidebar, computed once a change, not once a redraw."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import bpy
import numpy as np

from ...solver.shells.span import usual_wish
from ..properties import group_list
from . import corner_bridge, edge_bridge, weld_bridge
from .geometry_changes import watched
from .mesh_bridge import points_and_rim

T = TypeVar("T")

_known: dict[tuple[int, str], tuple[tuple, object]] = watched({})


def boundary_counts(mesh: bpy.types.Mesh) -> tuple[int, int]:
    """Numbers of boundary edges in all, and of those in none of the mesh's groups."""
    return _cached(mesh, "counts", lambda: edge_bridge.count_boundary(mesh, group_list.uids(mesh)))


def is_on_lines(plan: bpy.types.Object) -> bool:
    """Whether sides of a plan are on lines or lean over them, so that its shell is spanned."""
    if any(group.kind in ("LINE", "LEAN") for group in plan.data.cmc.groups):
        return True
    return plan.cmc.default_kind == "LINE" and boundary_counts(plan.data)[1] > 0


def has_courts(mesh: bpy.types.Mesh) -> bool:
    """Whether a plan has holes or handles, by Euler's number: V - E + F = 2 - 2 genus - loops."""
    vertices, edges, faces = edge_bridge.sizes(mesh)
    return faces > 0 and vertices - edges + faces < 1


def usual_size(plan: bpy.types.Object) -> float | None:
    """The height that a shell on lines has without a size; None where it is a soap film."""

    def make() -> float | None:
        matrix = np.array(plan.matrix_world)
        points, rim = (local @ matrix[:3, :3].T + matrix[:3, 3] for local in points_and_rim(plan.data))
        if not len(rim):
            return None
        soap_films = all(group.kind in ("LINE", "LEAN", "MIRROR") for group in plan.data.cmc.groups)
        name, height = usual_wish(points, rim, soap_films)
        return height if name == "height" else None

    kinds = ",".join(group.kind for group in plan.data.cmc.groups)
    return _cached(plan.data, f"usual {kinds} {list(map(tuple, plan.matrix_world))}", make)


def mirror_corners(mesh: bpy.types.Mesh) -> list[corner_bridge.Corner]:
    """The corners between two mirrors."""
    kinds = ",".join(f"{group.uid}:{group.kind}" for group in mesh.cmc.groups)
    return _cached(mesh, f"corners {kinds}", lambda: corner_bridge.corners(mesh))


def contacts(mesh: bpy.types.Mesh) -> int:
    """Number of vertices where parts of the mesh touch without being joined."""
    return _cached(mesh, "contacts", lambda: weld_bridge.contact_count(mesh))


def _cached(mesh: bpy.types.Mesh, what: str, make: Callable[[], T]) -> T:
    sizes = len(mesh.vertices), len(mesh.edges), len(mesh.polygons)
    state = (mesh.is_editmode, sizes, group_list.uids(mesh))
    known = _known.get((mesh.session_uid, what))
    if known is None or known[0] != state:
        known = (state, make())
        _known[mesh.session_uid, what] = known
    return known[1]  # type: ignore[return-value]
