"""What is drawn against what is seen: modifiers and shape keys that a task leaves out, and digits that are lost."""

from __future__ import annotations

import bpy
import numpy as np

from ...solver.notes import Note
from .mesh_bridge import read, readable_mesh

# A step of single precision of this part of an object's size shows in a shell.
_COARSE = 1e-4


def drawn_warnings(context: bpy.types.Context, ob: bpy.types.Object, way_out: str) -> list[Note]:
    """What differs between an object as a task reads it and as it is seen. way_out: what to do about modifiers."""
    return [*_left_out(context, ob, way_out), *coarse(ob)]


def coarse(ob: bpy.types.Object) -> list[Note]:
    """A warning if an object is drawn so far from its own origin that Blender rounds its points visibly."""
    box = np.array(ob.bound_box)
    size, step = float(np.ptp(box, axis=0).max()), float(np.spacing(np.float32(np.abs(box).max())))
    if step <= _COARSE * size or size == 0.0:
        return []
    text = (
        f"'{ob.name}' is drawn {np.abs(box).max():.2g} from its origin, where Blender keeps points to {step:.2g} only; "
        "draw or import it near its origin, and move the object."
    )
    return [Note("far", text)]


def _left_out(context: bpy.types.Context, ob: bpy.types.Object, way_out: str) -> list[Note]:
    names = [f"modifier '{modifier.name}'" for modifier in ob.modifiers if modifier.show_viewport]
    if ob.type == "MESH" and ob.data.shape_keys is not None:
        names += [f"shape key '{key.name}'" for key in ob.data.shape_keys.key_blocks[1:] if key.value and not key.mute]
    if not names or (ob.type == "MESH" and _is_as_seen(ob, context.evaluated_depsgraph_get())):
        return []
    return [Note("not-seen", f"'{ob.name}' was taken as drawn, without its {', '.join(names)}; {way_out}.")]


def _is_as_seen(ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bool:
    with readable_mesh(ob) as drawn, readable_mesh(ob, depsgraph) as seen:
        if any(len(getattr(drawn, part)) != len(getattr(seen, part)) for part in ("vertices", "edges", "polygons")):
            return False
        one, other = (read(mesh, "position", len(mesh.vertices), np.float32, 3) for mesh in (drawn, seen))
        return bool(np.abs(one - other).max(initial=0.0) <= 1e-5 * max(np.abs(one).max(initial=0.0), 1e-30))


def has_seen_faces(context: bpy.types.Context, ob: bpy.types.Object) -> bool:
    """Whether the modifiers of a mesh object make faces; cheap enough for a panel."""
    if ob.type != "MESH" or not ob.modifiers:
        return False
    shown = ob.evaluated_get(context.view_layer.depsgraph)
    return shown.data is not None and len(shown.data.polygons) > 0
