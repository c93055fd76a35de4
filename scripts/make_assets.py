"""Draw the plans of `plans.py` in Blender and write them into assets/: .blend marked as Blender assets, and .obj.
The modules of Add > Mesh > CMC are written by `make_modules.py`, which this calls at the end.

    .venvs/full-4.5/bin/python scripts/make_assets.py

The oldest Blender that the extension supports writes them, since newer files lose data in older ones; any other will
do to try things out. `make test-versions` makes that environment.

Add the folder in Blender's Preferences > File Paths > Asset Libraries, and drag a plan from the asset browser
into a scene: its boundary groups come along, and Solve forms a shell over it.
"""

from __future__ import annotations

import os
import sys
import tempfile
import uuid
from collections.abc import Sequence
from pathlib import Path

import blender_session
import plans

package = blender_session.start()

import bpy  # noqa: E402
import numpy as np  # noqa: E402
import portrait  # noqa: E402
import studio  # noqa: E402
from cmc_formfinding.cmc_addon import group_list, mesh_bridge  # noqa: E402
from cmc_formfinding.cmc_addon.edge_bridge import repair_selection  # noqa: E402
from cmc_formfinding.cmc_addon.outline_bridge import write_boundary_groups  # noqa: E402
from cmc_formfinding.solver.files import MeshData, write_mesh  # noqa: E402

ASSETS = blender_session.ROOT / "assets"
CATALOGUE = ASSETS / "blender_assets.cats.txt"
# The catalogue's identifier only has to be always the same one.
CATALOGUE_ID = str(uuid.uuid5(uuid.NAMESPACE_URL, "cmc-formfinding/assets/plans"))
CATALOGUE_PATH = "CMC Form-Finding/Plans"
AUTHOR = "CMC Form-Finding"
LICENCE = "GPL-3.0-or-later"
PREVIEW = 192  # pixels
COLOURS = {"Membrane": (0.80, 0.77, 0.72, 1.0), "Glass": (0.35, 0.50, 0.55, 1.0)}


def main() -> None:
    for file_name, make in plans.SKETCHES.items():
        sketch = make()
        picture = preview(sketch)
        blender_session.empty_scene()
        plan = draw(sketch)
        write_mesh(ASSETS / f"{file_name}.obj", obj_data(plan))
        mark(plan, sketch.description, sketch.tags, picture)
        save(ASSETS / f"{file_name}.blend", plan)
        print(f"{plan.name}: {len(plan.data.polygons)} faces, {len(plan.data.cmc.groups)} boundary groups")
    import make_modules

    make_modules.main()


# --- the plan as an object -----------------------------------------------------------------


def draw(sketch: plans.Sketch) -> bpy.types.Object:
    """The plan object of a sketch, alone in the scene and active, with its boundary groups."""
    bpy.context.scene.unit_settings.system = "METRIC"
    plan = _meshed(sketch) if isinstance(sketch, plans.OutlineSketch) else _quads(sketch)
    plan.cmc.blend = sketch.blend
    return plan


def _meshed(sketch: plans.OutlineSketch) -> bpy.types.Object:
    """The outline is drawn with its groups on it, and Mesh Plan does the rest."""
    loops = [sketch.outline, *sketch.holes]
    starts = np.cumsum([0] + [len(loop) for loop in loops])
    edges = np.concatenate([s + _cycle(len(loop)) for s, loop in zip(starts, loops, strict=False)])
    ob = _object(sketch.name, np.concatenate(loops), edges, [])
    _group(ob.data, sketch, lambda rim: edges[starts[rim.loop] + np.asarray(rim.segments)])
    bpy.ops.cmc.mesh_plan(
        edge_length=sketch.edge_length,
        round_corners=sketch.corner_radius > 0,
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


# --- files ---------------------------------------------------------------------------------


def obj_data(plan: bpy.types.Object) -> MeshData:
    """The plan as an OBJ knows it: polygons, the first UV layer, materials, boundary groups as polylines."""
    mesh = plan.data
    read = mesh_bridge.read_plan(plan)
    uv = np.array([item.vector[:] for item in mesh.uv_layers[0].uv], dtype=np.float64)
    starts = [polygon.loop_start for polygon in mesh.polygons][1:]
    rows, inverse = np.unique(uv, axis=0, return_inverse=True)
    slots = [material.name for material in mesh.materials]
    return MeshData(
        positions=read.positions,
        polygons=read.polygons(),
        uvs=rows,
        uv_corners=np.split(inverse.ravel().astype(np.int32), starts),
        materials=[slots[polygon.material_index] for polygon in mesh.polygons] if slots else [],
        edge_groups={group.name: read.edges[read.groups == group.uid] for group in mesh.cmc.groups},
    )


def preview(sketch: plans.Sketch) -> np.ndarray:
    """A picture (height, width, 4) in 0…1, bottom row first, of the shell over a plan."""
    blender_session.empty_scene()
    plan = draw(sketch)
    portrait.stage(plan, portrait.form(plan), sketch.view, aspect=1.0, people=False)
    return picture_of_scene()


def picture_of_scene() -> np.ndarray:
    """A square picture (height, width, 4) in 0…1, bottom row first, of what the camera sees."""
    with tempfile.TemporaryDirectory() as scratch:
        file = studio.render(Path(scratch) / "preview.png", PREVIEW, PREVIEW, samples=16)
        image = bpy.data.images.load(str(file))
        return np.array(image.pixels[:], dtype=np.float32).reshape(PREVIEW, PREVIEW, 4)


def mark(
    plan: bpy.types.Object, description: str, tags: Sequence[str], picture: np.ndarray, catalogue: str = CATALOGUE_ID
) -> None:
    """Make the plan an asset; picture (height, width, 4) in 0…1, from the bottom up."""
    plan.asset_mark()
    data = plan.asset_data
    data.description, data.author, data.license = description, AUTHOR, LICENCE
    data.catalog_id = catalogue
    for tag in tags:
        data.tags.new(tag)
    preview = plan.preview_ensure()
    preview.image_size = picture.shape[1::-1]
    preview.image_pixels_float.foreach_set(picture.astype(np.float32).ravel())


def save(path: Path, plan: bpy.types.Object) -> None:
    """Write a .blend that holds this object and what it needs, in a scene of its own."""
    with tempfile.TemporaryDirectory(prefix=".assets-", dir=path.parent) as scratch:
        temporary = str(Path(scratch) / path.name)
        bpy.data.orphans_purge(do_local_ids=True, do_linked_ids=True, do_recursive=True)
        bpy.ops.wm.save_as_mainfile(filepath=temporary, compress=True, copy=True, check_existing=False)
        os.replace(temporary, path)


def write_catalogue() -> None:
    """The asset browser's catalogue: a shelf for the plans, one for the modules."""
    import make_modules  # which needs what is here

    shelves = {CATALOGUE_ID: CATALOGUE_PATH, make_modules.CATALOGUE_ID: make_modules.CATALOGUE_PATH}
    lines = [
        "# Catalogues of the asset browser: UUID:path:simple name",
        "",
        "VERSION 1",
        "",
        *(f"{identifier}:{path}:{path.replace('/', '-')}" for identifier, path in shelves.items()),
    ]
    CATALOGUE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
