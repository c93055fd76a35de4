"""What must hold of a scene in Blender whatever was called: boxes are those of the points, points are numbers."""

from __future__ import annotations

import bpy
import numpy as np


def wrong_bounds() -> list[str]:
    """Mesh objects whose box is not that of their points; on the object and as evaluated."""
    bpy.context.view_layer.update()
    depsgraph, wrong = bpy.context.evaluated_depsgraph_get(), []
    for ob in bpy.context.view_layer.objects:
        if ob.type != "MESH" or ob.mode != "OBJECT" or not len(ob.data.vertices) or ob.data.is_editmode:
            continue
        seen = ob.evaluated_get(depsgraph)
        for kind, shown in (("", ob), ("evaluated ", seen)):
            # an object with modifiers has the box of what they make; Blender evaluates what is seen only
            if not ob.visible_get() or (not kind and (ob.modifiers or ob.data.shape_keys)):
                continue
            points = np.empty(3 * len(shown.data.vertices), dtype=np.float32)
            shown.data.vertices.foreach_get("co", points)
            points = points.reshape(-1, 3)
            box, wanted = np.array(shown.bound_box), [points.min(axis=0), points.max(axis=0)]
            if np.isfinite(points).all() and not np.allclose([box.min(axis=0), box.max(axis=0)], wanted, rtol=1e-5):
                wrong.append(f"{kind}'{ob.name}' has the box {box.min(axis=0)} to {box.max(axis=0)}, not {wanted}")
    return wrong


def not_finite() -> list[str]:
    """Results with a coordinate that is no number."""
    bad = []
    for ob in bpy.data.objects:
        if ob.type != "MESH" or ob.cmc.role == "NONE" or not len(ob.data.vertices) or ob.data.is_editmode:
            continue
        points = np.empty(3 * len(ob.data.vertices), dtype=np.float32)
        ob.data.vertices.foreach_get("co", points)
        if not np.isfinite(points).all():
            bad.append(f"'{ob.name}' has coordinates that are no numbers")
    return bad
