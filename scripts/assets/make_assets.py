"""Draw the plans of `plans.py` in Blender and write them into assets/: .blend marked as Blender assets, and .obj.

Then `make_modules.py` and `make_bubbles.py` write the modules and bubbles of Add > Mesh > CMC.

    .venvs/full-4.5/bin/python -m scripts.assets.make_assets

Use the oldest Blender that the extension supports, since newer files lose data in older versions; any other serves for
a trial. `make test-versions` makes that environment.

Add the folder in Blender's Preferences > File Paths > Asset Libraries, and drag a plan from the asset browser
into a scene: its boundary groups come along, and Solve forms a shell over it.
"""

from __future__ import annotations

import sys

from scripts.assets import plans
from scripts.gallery import blender_session

package = blender_session.start()

import bpy
import numpy as np
from cmc_formfinding.cmc_addon.bridges import mesh_bridge
from cmc_formfinding.cmc_addon.bridges.edge_bridge import repair_selection
from cmc_formfinding.cmc_addon.bridges.outline_bridge import write_boundary_groups
from cmc_formfinding.cmc_addon.properties import group_list
from cmc_formfinding.solver.io.mesh_files import write_mesh

from scripts.assets import make_bubbles, make_modules
from scripts.assets.asset_files import ASSETS, mark, obj_data, picture_of_scene, save
from scripts.gallery import staging

COLOURS = {"Membrane": (0.80, 0.77, 0.72, 1.0), "Glass": (0.35, 0.50, 0.55, 1.0)}


def main() -> None:
    for file_name, make in plans.SKETCHES.items():
        sketch = make()
        picture = preview(sketch)
        blender_session.empty_scene()
        plan = draw(sketch)
        write_mesh(ASSETS / f"{file_name}.obj", obj_data(plan))
        mark(plan, sketch.description, sketch.tags, picture, "plans")
        save(ASSETS / f"{file_name}.blend", plan)
        print(f"{plan.name}: {len(plan.data.polygons)} faces, {len(plan.data.cmc.groups)} boundary groups")
    make_modules.main()
    make_bubbles.main()


# --- the plan as an object -----------------------------------------------------------------


def draw(sketch: plans.Sketch) -> bpy.types.Object:
    """The plan object of a sketch, alone in the scene and active, with its boundary groups."""
    bpy.context.scene.unit_settings.system = "METRIC"
    plan = _meshed(sketch) if isinstance(sketch, plans.OutlineSketch) else _quads(sketch)
    plan.cmc.blend = sketch.blend
    return plan


def _meshed(sketch: plans.OutlineSketch) -> bpy.types.Object:
    """Draw the outline with its groups and fill it with Mesh Plan."""
    loops = [sketch.outline, *sketch.holes]
    starts = np.cumsum([0] + [len(loop) for loop in loops])
    edges = np.concatenate([s + _cycle(len(loop)) for s, loop in zip(starts, loops, strict=False)])
    ob = _object(sketch.name, np.concatenate(loops), edges, [])
    _group(ob.data, sketch, lambda rim: edges[starts[rim.loop] + np.asarray(rim.segments)])
    bpy.ops.cmc.mesh_plan(
        edge_length=sketch.edge_length,
        corners="ALL" if sketch.corner_radius > 0 else "NONE",
        corner_radius=sketch.corner_radius,
    )
    plan = bpy.context.object
    outline, wire = ob, ob.data
    plan.cmc.outline = None
    bpy.data.objects.remove(outline)
    bpy.data.meshes.remove(wire)
    plan.name = plan.data.name = sketch.name
    return plan


def _quads(sketch: plans.QuadSketch) -> bpy.types.Object:
    plan = _object(sketch.name, sketch.positions, [], sketch.quads.tolist())
    mesh = plan.data
    for name, coordinates in sketch.uv_layers.items():
        mesh_bridge.set_attribute(mesh, name, "FLOAT2", "CORNER", coordinates[sketch.quads.ravel()])
    mesh.uv_layers.active = mesh.uv_layers[0]
    for slot, (name, faces) in enumerate(sketch.materials.items()):
        material = bpy.data.materials.new(name)
        material.diffuse_color = COLOURS[name]
        mesh.materials.append(material)
        indices = np.array([polygon.material_index for polygon in mesh.polygons], dtype=np.int32)
        mesh.polygons.foreach_set("material_index", np.where(faces, slot, indices).astype(np.int32))
    first = len(sketch.positions) - sketch.rim
    _group(mesh, sketch, lambda rim: first + _cycle(sketch.rim)[np.asarray(rim.segments)])
    return plan


def _object(name: str, points: np.ndarray, edges, faces) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    flat = np.column_stack([points, np.zeros(len(points))])
    mesh.from_pydata(flat.tolist(), np.asarray(edges).tolist(), faces)
    repair_selection(mesh)
    ob = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob
    return ob


def _group(mesh: bpy.types.Mesh, sketch: plans.Sketch, edges_of) -> None:
    pairs, uids = [], []
    for rim in sketch.rims:
        group = group_list.add(mesh, rim.name)
        group.tilt = np.radians(rim.tilt)
        pairs.append(edges_of(rim))
        uids.append(np.full(len(pairs[-1]), group.uid))
    write_boundary_groups(mesh, np.concatenate(pairs), np.concatenate(uids))


def _cycle(count: int) -> np.ndarray:
    k = np.arange(count)
    return np.column_stack([k, (k + 1) % count])


def preview(sketch: plans.Sketch) -> np.ndarray:
    """A picture (height, width, 4) in 0…1, bottom row first, of the shell over a plan."""
    blender_session.empty_scene()
    plan = draw(sketch)
    staging.stage(plan, staging.form(plan), sketch.view, aspect=1.0, people=False)
    return picture_of_scene()


if __name__ == "__main__":
    sys.exit(main())
