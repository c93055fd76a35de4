"""Asset files of plans, modules and bubbles: shelves of the catalogue, an object as OBJ, asset or .blend file."""

from __future__ import annotations

import os
import tempfile
import uuid
from collections.abc import Sequence
from pathlib import Path

from scripts.gallery import blender_session

package = blender_session.start()

import bpy
import numpy as np
from cmc_formfinding.cmc_addon.bridges import mesh_bridge
from cmc_formfinding.solver.io.obj import MeshData

from scripts.gallery import scene

ASSETS = blender_session.ROOT / "assets"
CATALOGUE = ASSETS / "blender_assets.cats.txt"
AUTHOR = "CMC Form-Finding"
LICENCE = "GPL-3.0-or-later"
PREVIEW = 192  # pixels


def _identifier(shelf: str) -> str:
    """The identifier of a shelf of the catalogue, the same in every run."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"cmc-formfinding/assets/{shelf}"))


SHELVES = {shelf: _identifier(shelf) for shelf in ("plans", "modules", "bubbles")}


def obj_data(plan: bpy.types.Object) -> MeshData:
    """A plan as OBJ data: polygons, the first UV layer, materials, boundary groups as polylines."""
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


def picture_of_scene() -> np.ndarray:
    """A square picture (height, width, 4) in 0…1, bottom row first, from the camera."""
    with tempfile.TemporaryDirectory() as scratch:
        file = scene.render(Path(scratch) / "preview.png", PREVIEW, PREVIEW, samples=16)
        image = bpy.data.images.load(str(file))
        return np.array(image.pixels[:], dtype=np.float32).reshape(PREVIEW, PREVIEW, 4)


def mark(plan: bpy.types.Object, description: str, tags: Sequence[str], picture: np.ndarray, shelf: str) -> None:
    """Mark a plan as an asset on a shelf. picture: (height, width, 4) in 0…1, bottom row first."""
    plan.asset_mark()
    data = plan.asset_data
    data.description, data.author, data.license = description, AUTHOR, LICENCE
    data.catalog_id = SHELVES[shelf]
    for tag in tags:
        data.tags.new(tag)
    preview = plan.preview_ensure()
    preview.image_size = picture.shape[1::-1]
    preview.image_pixels_float.foreach_set(picture.astype(np.float32).ravel())


def save(path: Path, plan: bpy.types.Object) -> None:
    """Write a .blend with this object and its data, in a scene of its own."""
    with tempfile.TemporaryDirectory(prefix=".assets-", dir=path.parent) as scratch:
        temporary = str(Path(scratch) / path.name)
        bpy.data.orphans_purge(do_local_ids=True, do_linked_ids=True, do_recursive=True)
        bpy.ops.wm.save_as_mainfile(filepath=temporary, compress=True, copy=True, check_existing=False)
        os.replace(temporary, path)


def write_catalogue() -> None:
    """The asset browser's catalogue of all shelves."""
    places = {identifier: f"CMC Form-Finding/{shelf.title()}" for shelf, identifier in SHELVES.items()}
    lines = [
        "# Catalogues of the asset browser: UUID:path:simple name",
        "",
        "VERSION 1",
        "",
        *(f"{identifier}:{path}:{path.replace('/', '-')}" for identifier, path in places.items()),
    ]
    CATALOGUE.write_text("\n".join(lines) + "\n", encoding="utf-8")
