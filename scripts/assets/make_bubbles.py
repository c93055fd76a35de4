"""Write the bubbles of Add > Mesh > CMC into assets/bubbles/: .blend marked as Blender assets, .obj, .npz, job files.

`make_assets.py` calls it; by itself it writes the bubbles only:

    .venvs/full-4.5/bin/python -m scripts.assets.make_bubbles

A job is for `python -m solver`: it solves the bubble of the OBJ beside it, from the start in the .npz, and completes it
as the asset does.
"""

from __future__ import annotations

import sys

from scripts.gallery import blender_session

package = blender_session.start()

import bpy
import numpy as np
from cmc_formfinding.cmc_addon.bridges import mesh_bridge
from cmc_formfinding.cmc_addon.operators.add_bubble import BUBBLES
from cmc_formfinding.cmc_addon.properties.settings import SIZE_PROPERTY
from cmc_formfinding.solver.io.mesh_files import write_mesh
from cmc_formfinding.solver.jobs.start_table import write_start

from scripts.assets import asset_files
from scripts.gallery import scene, staging

FOLDER = asset_files.ASSETS / "bubbles"
# Coarse enough for small files, fine enough for the solver; None: the menu's own.
COLUMNS = {"WENTE": None, "TORUS": 20, "RING": 10}
MADE = "../../build/jobs"


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    asset_files.write_catalogue()
    for identifier, label, description in BUBBLES:
        name = identifier.lower()
        picture = preview(identifier)
        blender_session.empty_scene()
        plan = draw(identifier)
        write_mesh(FOLDER / f"{name}.obj", asset_files.obj_data(plan))
        read = mesh_bridge.read_plan(plan)
        if read.initial is not None or read.lengths is not None:
            edges = None if read.lengths is None else read.edges
            write_start(FOLDER / f"{name}.npz", read.initial, edges, read.lengths)
        text = job(name, f"{label}: {description[:1].lower()}{description[1:]}.", plan)
        (FOLDER / f"{name}.toml").write_text(text, encoding="utf-8")
        asset_files.mark(plan, f"{description}.", ("bubble", "saddle"), picture, "bubbles")
        asset_files.save(FOLDER / f"{name}.blend", plan)
        print(f"{plan.name}: {len(plan.data.polygons)} faces, {len(plan.data.cmc.groups)} boundary groups")


def draw(identifier: str) -> bpy.types.Object:
    """The plan of a bubble, alone in the scene and active."""
    bpy.context.scene.unit_settings.system = "METRIC"
    columns = COLUMNS[identifier]
    bpy.ops.cmc.add_bubble(bubble=identifier, **({} if columns is None else {"columns": columns}))
    bpy.context.object.select_set(False)
    return bpy.context.object


def job(name: str, comment: str, plan: bpy.types.Object) -> str:
    """The job file of a bubble: its conditions are the plan's groups, its settings those of the object."""
    settings, groups = plan.cmc, plan.data.cmc.groups
    lines = [f"# {comment}", "", f'mesh = "{name}.obj"']
    if (FOLDER / f"{name}.npz").is_file():
        lines += [f'start = "{name}.npz"']
    for group in groups:
        lines += ["", "[[conditions]]", f'group = "{group.name}"', f'kind = "{group.kind.lower()}"']
        if group.kind in ("MIRROR", "PLANE"):
            normal = ", ".join(f"{0.0 if abs(part) < 1e-7 else part:.9g}" for part in group.normal)
            lines += [f"normal = [{normal}]"]
        if group.kind == "MIRROR" and group.winding:
            lines += [f"winding = {group.winding:g}"]
    value = SIZE_PROPERTY[settings.size]
    lines += ["", "[size]", *([f"{value} = {getattr(settings, value):.6g}"] if value else [])]
    lines += [f'ground = "{settings.ground.lower()}"', "", "[solver]", f'method = "{settings.method.lower()}"']
    sides = [f'"{group.name}"' for group in groups if group.across != "OFF"]
    if sides:
        lines += ["", "[complete]", f"sides = [{', '.join(sides)}]", f"repeat = {list(settings.complete_repeat)}"]
        lines += [f'mesh = "{MADE}/{name}.obj"']
    lines += ["", "[output]", *([] if sides else [f'f_plus = "{MADE}/{name}.obj"']), f'report = "{MADE}/{name}.json"']
    return "\n".join(lines) + "\n"


def preview(identifier: str) -> np.ndarray:
    """A picture of the completed bubble."""
    blender_session.empty_scene()
    plan = draw(identifier)
    bpy.ops.cmc.solve()
    whole = plan.cmc.f_plus
    if plan.data.cmc.groups:
        bpy.ops.cmc.complete()
        whole = plan.cmc.completed
    plan.hide_render = True
    staging.paint(whole, scene.checker("Plaster", "Plan", cells=1.0))
    whole.data.shade_smooth()
    points = staging.world_points(whole)
    scene.add_ground(float(np.ptp(points, axis=0).max()), z=float(points[:, 2].min()))
    scene.light()
    staging.look_at(points, (-62.0, 0.9), 42.0, 1.0)
    return asset_files.picture_of_scene()


if __name__ == "__main__":
    sys.exit(main())
