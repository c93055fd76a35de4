"""Everything in the open .blend as plain values: what a call has changed, and where."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import bpy
import numpy as np

Digest = dict[str, str]
"""Path of a property, like `objects/Disc/cmc/tilt`, to its value as text."""

# Of the window, not of the file's contents.
_OF_THE_WINDOW = {"window_managers", "screens", "workspaces", "brushes"}
# Geometry, which is read in bulk; what Blender derives, or counts for itself.
_GEOMETRY = {
    "vertices", "edges", "loops", "polygons", "attributes", "uv_layers", "loop_triangles", "loop_triangle_polygons",
    "color_attributes", "vertex_normals", "polygon_normals", "corner_normals", "skin_vertices",
    "uv_layer_clone", "uv_layer_stencil", "vertex_colors",
}
_SKIPPED = {
    "rna_type", "depsgraph", "id_data", "original", "users", "tag", "is_evaluated", "is_runtime_data", "preview",
    "all_objects", "children_recursive", "objects_recursive", "bl_rna", "session_uid", "is_updated", "is_updated_data",
    "texspace_location", "texspace_size", "particle_edit", "matrix_world", "matrix_local", "bound_box", "dimensions",
    "vertex_paint", "weight_paint", "curve_mapping", "normals_domain",
}
_FIELDS = {
    "FLOAT": ("value", np.float32, 1), "INT": ("value", np.int32, 1), "INT8": ("value", np.int8, 1),
    "BOOLEAN": ("value", np.bool_, 1), "FLOAT_VECTOR": ("vector", np.float32, 3), "FLOAT2": ("vector", np.float32, 2),
    "FLOAT_COLOR": ("color", np.float32, 4), "BYTE_COLOR": ("color_srgb", np.float32, 4),
    "QUATERNION": ("value", np.float32, 4), "FLOAT4X4": ("value", np.float32, 16),
    "INT16_2D": ("value", np.int16, 2), "INT32_2D": ("value", np.int32, 2),
}
_DEEP = 12


def digest() -> Digest:
    """All data-blocks of the open file, with their layers and properties."""
    bpy.context.view_layer.update()
    found: Digest = {}
    for collection in bpy.data.bl_rna.properties:
        name = collection.identifier
        if collection.type != "COLLECTION" or name in _OF_THE_WINDOW:
            continue
        for block in getattr(bpy.data, name):
            path = f"{name}/{block.name_full}"
            found[path] = str(block.session_uid)
            _walk(found, path, block, set())
            if isinstance(block, bpy.types.Mesh):
                found |= {f"{path}/{key}": value for key, value in _geometry(block)}
    found["scene"] = bpy.context.scene.name
    found["view layer"] = bpy.context.view_layer.name
    for ob in bpy.context.view_layer.objects:
        found[f"seen/{ob.name_full}"] = f"selected {ob.select_get()}, hidden {ob.hide_get()}"
    return found


def differences(before: Digest, after: Digest, but: tuple[str, ...] = ()) -> list[str]:
    """What is no longer as it was, a line each; but: last names of properties that do not count."""
    return [
        f"{path}: {before.get(path, 'nothing')[:80]} -> {after.get(path, 'nothing')[:80]}"
        for path in sorted(before.keys() | after.keys())
        if before.get(path) != after.get(path) and path.rpartition("/")[2] not in but
    ]


def _walk(found: Digest, path: str, owner, above: set[int]) -> None:
    """Add the properties of a data-block or of a part of one; links to other data-blocks as names."""
    here = owner.as_pointer()
    if here in above or len(above) > _DEEP:
        return
    above = above | {here}
    for rna in owner.bl_rna.properties:
        name = rna.identifier
        if name in _SKIPPED or (name in _GEOMETRY and isinstance(owner, bpy.types.Mesh)):
            continue
        try:
            value = getattr(owner, name)
        except (AttributeError, RuntimeError, ValueError):  # has no value in this state
            continue
        _add(found, f"{path}/{name}", value, above)
    if hasattr(owner, "keys") and isinstance(owner, (bpy.types.ID, bpy.types.PropertyGroup)):
        for key in owner.keys():  # noqa: SIM118  no mapping
            _add(found, f"{path}[{key}]", owner[key], above)


def _add(found: Digest, path: str, value, above: set[int]) -> None:
    if isinstance(value, bpy.types.ID):
        found[path] = value.name_full
    elif isinstance(value, bpy.types.bpy_struct):
        _walk(found, path, value, above)
    elif isinstance(value, bpy.types.bpy_prop_collection):
        found[path] = str(len(value))
        for index, item in enumerate(value):
            if isinstance(item, bpy.types.bpy_struct):
                _add(found, f"{path}/{index}", item, above)
    elif isinstance(value, set):
        found[path] = repr(sorted(value))
    elif hasattr(value, "to_list"):
        found[path] = repr(value.to_list())
    elif hasattr(value, "to_dict"):
        found[path] = repr(value.to_dict())
    elif hasattr(value, "__len__") and not isinstance(value, (str, bytes)):
        found[path] = repr([tuple(row) if hasattr(row, "__len__") else row for row in value])
    else:
        found[path] = repr(value)


def _geometry(mesh: bpy.types.Mesh) -> Iterator[tuple[str, str]]:
    """Every attribute of a mesh, Blender's own among them; of the edit mesh in edit mode."""
    if mesh.is_editmode:
        for ob in bpy.data.objects:
            if ob.data == mesh:
                ob.update_from_editmode()
        copy = mesh.copy()
        yield from _geometry(copy)
        bpy.data.meshes.remove(copy)
        return
    starts = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    yield "faces", _hash(starts)
    weights = [[(group.group, group.weight) for group in vertex.groups] for vertex in mesh.vertices]
    yield "weights", _hash(np.frombuffer(repr(weights).encode(), np.uint8))
    for attribute in mesh.attributes:
        yield f"attribute {attribute.name}", f"{attribute.domain} {attribute.data_type} {_values(attribute)}"
    for name in ("uv_layers", "color_attributes"):
        layers = getattr(mesh, name)
        yield f"{name} in use", repr(layers.active.name if layers.active else None)


def _values(attribute: bpy.types.Attribute) -> str:
    if attribute.data_type not in _FIELDS:
        return _hash(np.frombuffer(repr([item.value for item in attribute.data]).encode(), np.uint8))
    field, kind, width = _FIELDS[attribute.data_type]
    values = np.empty(len(attribute.data) * width, dtype=kind)
    if len(values):
        attribute.data.foreach_get(field, values)
    return _hash(values)


def _hash(array: np.ndarray) -> str:
    return f"{len(array)} values {hashlib.blake2b(array.tobytes(), digest_size=8).hexdigest()}"
