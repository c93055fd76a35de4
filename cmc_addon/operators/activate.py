"""Selecting one object, as operators do that add or show one."""

import bpy


def activate(context: bpy.types.Context, ob: bpy.types.Object) -> None:
    """Make an object the active and the only selected one; show it if it is hidden, or not in this view layer."""
    context.view_layer.update()  # of a new object
    if context.view_layer.objects.get(ob.name) != ob:
        context.scene.collection.objects.link(ob)
    for other in context.selected_objects:
        other.select_set(False)
    ob.hide_set(False)
    ob.select_set(True)
    context.view_layer.objects.active = ob
