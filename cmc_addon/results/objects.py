"""Result objects: their names, their places, and their update by the next solve.

**Names.** The first solve of a plan called "Hall" makes the collection "CMC Hall" under the scene, and in it
those of "Hall f+", "Hall f-", "Hall g" and "Hall Gauss image" that are wanted. Names are given once: links tie
plan and results together, so the user may rename both, and no solve ever does.

**Update in place.** The next solve writes positions, `cmc_normal`, the measures (see `measures`) and the report
into the same objects, and refreshes the layers that come from the plan (UVs, colours, attributes, vertex
groups). What the user has added stays: materials and their faces, smooth or flat shading, modifiers, constraints,
collections, other layers, custom properties. If the plan's polygons have changed, the mesh is replaced and
the object stays, with its materials; layers that the user added to the mesh are then lost.

**Other faces.** With the dual or the corner mesh chosen, the same object gets that mesh, with the plan's
layers interpolated to its vertices (see `polygon_bridge`); and back.

**Place.** A result starts with its origin at the plan's (near the plan, if that is far from its own origin), unrotated
and unscaled. What the user then does to its transform stays: the solve moves it only by as much as the plan has been
moved since (a parented result not even that).

**No longer wanted.** A result that exists but is not wanted now is updated and hidden, and shown again when it is
wanted. A sheet that has become a single point is deleted.

**Nearest.** Approximate Surface makes "Hall nearest CMC", a result of its own role, which Solve neither
changes nor hides; everything else here applies to it.

**Completed.** Repeat by Symmetry makes "Hall completed", or instances in a collection "Hall copies", and hides the
shell, which is one of the copies. The next solve makes them again (see `recipe`), or shows the shell and hides the
copies of the older one.

**Deleted.** A result counts as deleted when it is in no scene; the next solve makes a new one. One that is in another
scene is linked to this one, too. The same
holds for the collection. A result whose plan is deleted stays as it is and can no longer be solved.

**Duplicated.** A link counts only if it goes both ways: the plan names the result and the result names the
plan. So a duplicated plan gets results and a collection of its own and leaves the original's alone. Plan and
results duplicated together are a pair of their own, because Blender redirects the links. A duplicated result is
a copy that no solve changes; Solve with it active solves the plan it came from.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError
from ...solver.shells.polygon_sheets import PolygonSheet
from ..bridges.colour_bridge import put_measures
from ..bridges.mesh_bridge import NORMAL_ATTRIBUTE, PlanMesh, near_origin, readable_mesh, set_attribute, set_positions
from ..bridges.polygon_bridge import polygon_mesh, row_weights
from ..bridges.result_bridge import Cut, fresh_mesh, put_mesh, put_weights, vertex_weights
from ..properties.libraries import why_not_kept
from ..properties.links import _is_own, copies_of, result_of, results_of
from ..properties.stored import COMPLETED_ROLES, DESIGN_ROLES, ROLES

_SUFFIX = {"F_PLUS": "f+", "F_MINUS": "f-", "G": "g", "GAUSS": "Gauss image", "NEAREST": "nearest CMC"}
_SUFFIX["COMPLETED"] = "completed"


# --- links ---------------------------------------------------------------------------------

def check_writable(plan: bpy.types.Object) -> None:
    """Raise `CmcError` if a result cannot be written, before anything is changed."""
    if reason := why_not_kept(plan):
        raise CmcError(f"{reason} to solve it here.")
    for result in results_of(plan, (*ROLES, *DESIGN_ROLES, *COMPLETED_ROLES)).values():
        if result.data.is_editmode:
            raise CmcError(f"The result '{result.name}' is in edit mode; leave it (Tab) and solve again.")


# --- writing -------------------------------------------------------------------------------

class Writer:
    """Writes shells into the result objects of a plan; the module's docstring lists what stays.

    mesh: the arrays of the plan under the shell; cut: where it is open.
    """

    def __init__(
        self,
        context: bpy.types.Context,
        plan: bpy.types.Object,
        depsgraph: bpy.types.Depsgraph | None,
        mesh: PlanMesh,
        cut: Cut | None,
    ) -> None:
        self.scene = context.scene
        self.plan, self.depsgraph, self.mesh, self.cut = plan, depsgraph, mesh, cut
        self.origin = result_origin(plan, mesh)
        self.group_names = [group.name for group in plan.vertex_groups]
        self.weights = self._weights()

    def _weights(self) -> list[dict[int, float]]:
        """The plan's vertex weights."""
        if not self.group_names:
            return []
        with readable_mesh(self.plan, self.depsgraph) as mesh:
            return vertex_weights(mesh, len(self.group_names))

    def _cut_weights(self) -> list[dict[int, float]]:
        """The plan's vertex weights on a surface that may be cut open: each copy of a vertex has its weight."""
        weights = self.weights
        if self.cut is None:
            return weights
        copies: dict[int, list[int]] = {}
        for cut_vertex, vertex in enumerate(self.cut.vertices.tolist()):
            copies.setdefault(vertex, []).append(cut_vertex)
        return [{copy: w for vertex, w in group.items() for copy in copies[vertex]} for group in weights]

    def write(
        self, role: str, points: NDArray, normals: NDArray, measures: Mapping[str, NDArray] | None = None
    ) -> bpy.types.Object:
        """Make or update the result in this role with the plan's polygons; points (n, 3) in world coordinates.

        measures: attribute -> values on a measured sheet; attributes that it lacks are removed.
        """
        fresh = fresh_mesh(self.plan, self.depsgraph, self.mesh, self.cut)
        result = self._put(role, fresh, self._cut_weights())
        put_points(result, self.origin, points, normals, measures)
        return result

    def write_polygons(
        self,
        role: str,
        sheet: PolygonSheet,
        triangles: NDArray,
        owners: NDArray,
        measures: Mapping[str, NDArray] | None = None,
    ) -> None:
        """The same with the polygons of a dual or corner mesh, made of the plan's triangles (see `polygon_mesh`)."""
        fresh = polygon_mesh(self.plan, self.depsgraph, self.mesh, triangles, owners, sheet)
        result = self._put(role, fresh, row_weights(sheet, self.weights, len(self.mesh.positions)))
        put_points(result, self.origin, sheet.points, sheet.normals, measures)

    def write_alike(self, role: str, like: bpy.types.Object, points: NDArray, normals: NDArray) -> bpy.types.Object:
        """Make the result in this role from the mesh of another result, with points of its own."""
        weights = vertex_weights(like.data, len(self.group_names))
        result = self._put(role, like.data.copy(), weights)
        put_points(result, self.origin, points, normals, {})
        return result

    def _put(self, role: str, fresh: bpy.types.Mesh, weights: list[dict[int, float]]) -> bpy.types.Object:
        """The result in this role, made or updated except for its points."""
        result = result_of(self.plan, role)
        if result is None:
            result = self._new(role, fresh)
        else:
            put_mesh(result, fresh)
            move_along(result, self.origin)
        if result.data.shape_keys is not None:
            result.shape_key_clear()
        put_weights(result, self.group_names, weights)
        self.link(result)
        return result

    def link(self, result: bpy.types.Object) -> None:
        """Have a result in this scene, too, where it is only in another one that shows the same plan."""
        here = self.scene.objects
        if here.get(result.name) != result and here.get(self.plan.name) == self.plan:
            collection = self.collection()
            if result.name not in collection.objects:
                collection.objects.link(result)

    def _new(self, role: str, mesh: bpy.types.Mesh) -> bpy.types.Object:
        _forget(self.plan, role)
        name = f"{self.plan.name} {_SUFFIX[role]}"
        mesh.name = name
        result = bpy.data.objects.new(name, mesh)
        result.cmc.role, result.cmc.source = role, self.plan
        result.location = result.cmc.placed_at = self.origin
        self.collection().objects.link(result)
        for own, slot in zip(result.material_slots, self.plan.material_slots, strict=False):
            if slot.link == "OBJECT":
                own.link = "OBJECT"
                own.material = slot.material
        setattr(self.plan.cmc, role.lower(), result)
        return result

    def collection(self) -> bpy.types.Collection:
        """The plan's own collection, in this scene; made if no scene has it."""
        collection = self.plan.cmc.collection
        if collection is not None and collection.cmc_plan == self.plan:
            if collection in self.scene.collection.children_recursive:
                return collection
            if any(collection in scene.collection.children_recursive for scene in bpy.data.scenes):
                self.scene.collection.children.link(collection)
                return collection
        collection = bpy.data.collections.new(f"CMC {self.plan.name}")
        collection.cmc_plan = self.plan
        self.scene.collection.children.link(collection)
        self.plan.cmc.collection = collection
        return collection


def result_origin(plan: bpy.types.Object, mesh: PlanMesh) -> NDArray[np.float64]:
    """The origin (3,) of the results of a plan: the plan's own, or one near a plan whose own is far away."""
    return near_origin(np.array(plan.matrix_world.translation, dtype=np.float64), mesh.positions)


def move_along(result: bpy.types.Object, origin: NDArray) -> None:
    """Move a result by as much as its plan has moved since the last write; origin (3,): see `result_origin`."""
    moved = origin - np.array(result.cmc.placed_at, dtype=np.float64)
    if not moved.any():
        return
    if result.parent is None:
        result.location = np.array(result.location, dtype=np.float64) + moved
    result.cmc.placed_at = origin


def put_points(
    result: bpy.types.Object,
    origin: NDArray,
    points: NDArray,
    normals: NDArray,
    measures: Mapping[str, NDArray] | None,
) -> None:
    """Write points (n, 3) in the world, normals (n, 3) and measures into a result; origin (3,): see `result_origin`."""
    if measures is not None:
        put_measures(result.data, measures)
    set_attribute(result.data, NORMAL_ATTRIBUTE, "FLOAT_VECTOR", "POINT", normals)
    set_positions(result.data, points - origin)


def _forget(plan: bpy.types.Object, role: str) -> None:
    """Clear a link that does not count, and remove the result that the user has deleted, which only the link keeps."""
    linked = getattr(plan.cmc, role.lower())
    setattr(plan.cmc, role.lower(), None)
    if linked is not None and _is_own(plan, role, linked):
        delete_result(linked)


def delete_result(result: bpy.types.Object) -> None:
    """Delete a result object, and its mesh if nothing else uses it."""
    mesh = result.data
    bpy.data.objects.remove(result)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)


def show_wanted(plan: bpy.types.Object, wanted: list[str]) -> None:
    """Hide results that are not wanted now; show again those that this hid before."""
    for role, result in results_of(plan).items():
        if (role not in wanted) == result.cmc.parked:
            continue
        result.cmc.parked = result.hide_viewport = result.hide_render = role not in wanted


def park(result: bpy.types.Object | None) -> None:
    """Hide a result that another one replaces; the next solve shows it again."""
    if result is not None:
        result.cmc.parked = result.hide_viewport = result.hide_render = True


def hide_completed(plan: bpy.types.Object, hidden: bool) -> None:
    """Hide or show the copies of the shell; hidden ones are behind: of an older shell."""
    if plan.cmc.behind != hidden:  # each change would wake Live
        plan.cmc.behind = hidden
    for thing in (result_of(plan, "COMPLETED"), copies_of(plan)):
        if thing is not None:
            thing.hide_viewport = thing.hide_render = hidden


def world_box(ob: bpy.types.Object) -> NDArray[np.float64]:
    """The corners (8, 3) of an object's bounding box in the world."""
    matrix = np.array(ob.matrix_world)
    return np.array(ob.bound_box) @ matrix[:3, :3].T + matrix[:3, 3]


def write_report(result: bpy.types.Object, report: dict) -> None:
    """Put a report on a result: all of it as JSON in `cmc_report`, and each number and text as `cmc_<name>`."""
    result["cmc_report"] = json.dumps(report, ensure_ascii=False)
    for name, value in report.items():
        if isinstance(value, (bool, int, float, str)):
            result[f"cmc_{name}"] = value
        elif value is None and f"cmc_{name}" in result:  # the value is of an older shell
            del result[f"cmc_{name}"]
