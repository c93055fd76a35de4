"""Where a result is that nobody sees: a task must not end with FINISHED and an empty viewport."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ...solver.notes import Note
from ..properties.links import copies_of, result_of


def why_not_seen(context: bpy.types.Context, plan: bpy.types.Object, role: str) -> Note | None:
    """Why the result of a plan in this role is not visible, and the way out; None if it is, or there is none."""
    if not role:
        return None
    copies = copies_of(plan) if role == "COMPLETED" else None
    result = copies.objects[0] if copies is not None and copies.objects else result_of(plan, role)
    if result is None:
        return None
    layer = context.view_layer
    layer.update()
    if result.visible_get(view_layer=layer):
        return None
    start = f"'{result.name}' is there and cannot be seen:"
    collections = list(_collections(layer.layer_collection, result))
    for collection in collections:
        if collection.exclude:
            where = f"its collection '{collection.name}' is excluded from '{layer.name}'"
            return Note("hidden", f"{start} {where}; tick it in the Outliner.")
    for collection in collections:
        if collection.hide_viewport or collection.collection.hide_viewport:
            text = f"{start} its collection '{collection.name}' is hidden; click its eye in the Outliner."
            return Note("hidden", text)
    return Note("hidden", f"{start} it is hidden; click its eye in the Outliner, or press Alt H.")


def _collections(layer: bpy.types.LayerCollection, ob: bpy.types.Object) -> Iterator[bpy.types.LayerCollection]:
    """The collections of a view layer that lead to an object, from the outermost."""
    if ob.name in layer.collection.all_objects:
        yield layer
        for child in layer.children:
            yield from _collections(child, ob)
