"""Copies of a shell as instances: one object each, all with the same mesh, reflected by their scale."""

from __future__ import annotations

from collections.abc import Mapping

import bpy
import numpy as np
from mathutils import Matrix

from ...solver.shells.complete import Completed
from ..bridges.colour_bridge import put_measures
from ..bridges.mesh_bridge import NORMAL_ATTRIBUTE, PlanMesh, set_attribute, set_positions
from ..bridges.result_bridge import Cut, fresh_mesh, put_mesh
from ..properties.links import copies_of
from .measures import Measured
from .objects import Writer, result_origin

PIECE = "cmc_piece"
"""Custom property of a piece's mesh: the sheet it shows."""

# Copies between two updates of the progress cursor.
_PROGRESS_EVERY = 200


def write_instances(
    context: bpy.types.Context,
    plan: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph | None,
    mesh: PlanMesh,
    cut: Cut | None,
    completed: Completed,
    measures: Mapping[str, Measured],
) -> None:
    """Make or update the collection of copies. Its meshes are kept, with their materials.

    measures: sheet -> the measures on it.
    """
    writer = Writer(context, plan, depsgraph, mesh, None)
    collection = copies_of(plan) or _new_collection(plan, writer)
    origin = result_origin(plan, mesh)
    meshes = {}
    for sheet in sorted(set(completed.sheets)):
        fresh = fresh_mesh(plan, depsgraph, mesh, cut)
        meshes[sheet] = _piece(plan, collection, sheet, fresh)
        _place(meshes[sheet], completed, sheet, origin, measures[sheet])
    before = list(collection.objects)
    if collection not in context.scene.collection.children_recursive:
        own = writer.collection()  # links it with all that it contains
        if collection not in own.children_recursive:
            own.children.link(collection)
    _match_count(plan, collection, before, len(completed.transforms), next(iter(meshes.values())))
    to_origin = np.eye(4)
    to_origin[:3, 3] = origin
    cursor = context.window_manager
    cursor.progress_begin(0, len(before))
    for k, (ob, sheet) in enumerate(zip(before, completed.sheets, strict=True)):
        if ob.data != meshes[sheet]:
            ob.data = meshes[sheet]
        ob.matrix_world = Matrix((completed.transforms[k] @ to_origin).tolist())
        if k % _PROGRESS_EVERY == 0:
            cursor.progress_update(k)
    cursor.progress_end()
    _drop_unused(plan, meshes)


def delete_instances(plan: bpy.types.Object) -> None:
    """Delete the copies of a plan's shell, if it has any, with their meshes."""
    collection = copies_of(plan)
    if collection is None:
        return
    bpy.data.batch_remove(list(collection.objects))
    bpy.data.collections.remove(collection)
    plan.cmc.copies = None
    _drop_unused(plan, {})


def _new_collection(plan: bpy.types.Object, writer: Writer) -> bpy.types.Collection:
    collection = bpy.data.collections.new(f"{plan.name} copies")
    collection.cmc_plan = plan
    writer.collection().children.link(collection)
    plan.cmc.copies = collection
    return collection


def _piece(plan: bpy.types.Object, collection: bpy.types.Collection, sheet: str, fresh) -> bpy.types.Mesh:
    """The mesh of a sheet, made or updated."""
    user = next((ob for ob in collection.objects if ob.data.get(PIECE) == sheet), None)
    if user is None:
        fresh.name = f"{plan.name} piece {sheet}"
        fresh[PIECE] = sheet
        return fresh
    put_mesh(user, fresh)
    user.data[PIECE] = sheet
    return user.data


def _place(
    mesh: bpy.types.Mesh, completed: Completed, sheet: str, origin: np.ndarray, measures: Measured
) -> None:
    put_measures(mesh, measures)
    set_attribute(mesh, NORMAL_ATTRIBUTE, "FLOAT_VECTOR", "POINT", completed.shell.normals[sheet])
    set_positions(mesh, completed.piece(sheet) - origin)


def _match_count(plan, collection, objects: list, count: int, mesh: bpy.types.Mesh) -> None:
    """Add or remove objects, in the collection and in the list, until there is one for each copy."""
    if len(objects) > count:
        bpy.data.batch_remove(objects[count:])
        del objects[count:]
    for _ in range(count - len(objects)):
        ob = bpy.data.objects.new(f"{plan.name} copy", mesh)
        ob.cmc.role, ob.cmc.source = "COMPLETED", plan  # with a copy active, Solve solves the plan
        collection.objects.link(ob)
        objects.append(ob)


def _drop_unused(plan: bpy.types.Object, kept: dict[str, bpy.types.Mesh]) -> None:
    """Remove pieces that no object uses."""
    for mesh in list(bpy.data.meshes):
        if mesh.get(PIECE) is not None and mesh.users == 0 and mesh not in kept.values():
            bpy.data.meshes.remove(mesh)
