"""Plans to solve, and the scene's data as plain values, which show what a call has changed."""

from __future__ import annotations

import bpy
import numpy as np

FIELDS = {"FLOAT_VECTOR": "vector", "FLOAT2": "vector", "FLOAT_COLOR": "color", "BYTE_COLOR": "color_srgb"}


def mesh_object(name: str, vertices, faces, edges=()) -> bpy.types.Object:
    """A new mesh object in the scene, active; edges in no group leave the rim free, as most tests want it."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices, dtype=float).tolist(), list(edges), [list(face) for face in faces])
    wrong = mesh.attributes.get(".select_edge")  # Blender 5.0 gives it a type that crashes on writing
    if wrong is not None:
        mesh.attributes.remove(wrong)
    ob = bpy.data.objects.new(name, mesh)
    ob.cmc.default_kind = "BINORMAL"
    return link(ob)


def link(ob: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.collection.objects.link(ob)
    activate(ob)
    return ob


def activate(ob: bpy.types.Object | None) -> None:
    bpy.context.view_layer.objects.active = ob


def quad_disc(name: str = "Disc", rings: int = 5, columns: int = 24, radius: float = 4.0, rise: float = 0.0):
    """A round plan of quads around a fan of triangles; `rise` lifts its middle."""
    r = radius * np.arange(1, rings + 1) / rings
    t = 2 * np.pi * np.arange(columns) / columns
    points = [(0.0, 0.0, rise)]
    points += [(a * np.cos(b), a * np.sin(b), rise * (1 - (a / radius) ** 2)) for a in r for b in t]
    faces = [(0, 1 + k, 1 + (k + 1) % columns) for k in range(columns)]
    for ring in range(rings - 1):
        start = 1 + ring * columns
        faces += [
            (start + k, start + columns + k, start + columns + (k + 1) % columns, start + (k + 1) % columns)
            for k in range(columns)
        ]
    return mesh_object(name, points, faces)


def jittered(plan: bpy.types.Object, amount: float = 0.12) -> bpy.types.Object:
    """Move the inside vertices at random in the plan's plane, so that no four lie on one circle."""
    rim = {v for e in boundary_edges(plan.data) for v in plan.data.edges[e].vertices}
    moves = np.random.default_rng(7).uniform(-amount, amount, (len(plan.data.vertices), 2))
    for vertex, (x, y) in zip(plan.data.vertices, moves.tolist(), strict=True):
        if vertex.index not in rim:
            vertex.co.x += x
            vertex.co.y += y
    return plan


def quad_ring(name: str = "Ring", rings: int = 5, columns: int = 24, inner: float = 1.5, outer: float = 4.0):
    """A plan of quads with a hole off its centre, whose surface is left open."""
    points, faces = [], []
    for k in range(rings + 1):
        part = k / rings
        radius, centre = inner + part * (outer - inner), (1.0 - part) * 0.8
        t = 2 * np.pi * np.arange(columns) / columns
        points += list(zip(centre + radius * np.cos(t), radius * np.sin(t), 0 * t, strict=True))
    for k in range(rings):
        a, b = k * columns, (k + 1) * columns
        faces += [(a + j, b + j, b + (j + 1) % columns, a + (j + 1) % columns) for j in range(columns)]
    plan = mesh_object(name, points, faces)
    plan.cmc.keep_closed = False
    return plan


def boundary_edges(mesh: bpy.types.Mesh) -> np.ndarray:
    """Indices of the edges with one face."""
    corner_edges = np.array([loop.edge_index for loop in mesh.loops])
    return np.flatnonzero(np.bincount(corner_edges, minlength=len(mesh.edges)) == 1)


def add_group(ob: bpy.types.Object, name: str, edges, kind: str, **parameters):
    """A boundary group of these edges (indices), in object mode."""
    mesh = ob.data
    group = mesh.cmc.groups.add()
    group.name, group.uid, group.kind = name, mesh.cmc.next_uid, kind
    mesh.cmc.next_uid += 1
    for key, value in parameters.items():
        setattr(group, key, value)
    attribute = mesh.attributes.get("cmc_group") or mesh.attributes.new("cmc_group", "INT", "EDGE")
    for edge in edges:
        attribute.data[int(edge)].value = group.uid
    return group


def values(attribute: bpy.types.Attribute) -> list:
    """Values of an attribute as plain numbers."""
    field = FIELDS.get(attribute.data_type, "value")
    found = [getattr(item, field) for item in attribute.data]
    return [tuple(v) if hasattr(v, "__len__") and not isinstance(v, (str, bytes)) else v for v in found]


def positions(ob: bpy.types.Object) -> np.ndarray:
    """World coordinates (V, 3)."""
    bpy.context.view_layer.update()
    flat = np.empty(3 * len(ob.data.vertices))
    ob.data.vertices.foreach_get("co", flat)
    matrix = np.array(ob.matrix_world)
    return flat.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]


def snapshot() -> dict:
    """Everything in the file that a solve could touch, as values that compare."""
    return {
        "objects": {ob.name: _object(ob) for ob in bpy.data.objects},
        "meshes": {mesh.name: _mesh(mesh) for mesh in bpy.data.meshes},
        "collections": {
            c.name: (sorted(o.name for o in c.objects), sorted(k.name for k in c.children), _name(c.cmc_plan))
            for c in [*bpy.data.collections, bpy.context.scene.collection]
        },
        "materials": sorted(material.name for material in bpy.data.materials),
        "active": _name(bpy.context.view_layer.objects.active),
        "selected": sorted(ob.name for ob in bpy.context.view_layer.objects if ob.select_get()),
    }


def _name(block) -> str | None:
    return None if block is None else block.name


def _properties(group) -> dict:
    """All properties of a PropertyGroup, nested ones included."""
    found = {}
    for rna in group.bl_rna.properties:
        key = rna.identifier
        if key == "rna_type":
            continue
        value = getattr(group, key)
        if isinstance(value, bpy.types.bpy_prop_collection):
            found[key] = [_properties(item) for item in value]
        elif isinstance(value, bpy.types.ID):
            found[key] = value.name
        else:
            found[key] = tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value
    return found


def _object(ob: bpy.types.Object) -> dict:
    return {
        "data": _name(ob.data),
        "mode": ob.mode,
        "matrix": [tuple(row) for row in ob.matrix_basis],
        "modifiers": [(m.name, m.type) for m in ob.modifiers],
        "slots": [(slot.link, _name(slot.material)) for slot in ob.material_slots],
        "groups": [group.name for group in ob.vertex_groups],
        "custom": {key: value for key, value in ob.items() if isinstance(value, (int, float, str))},
        "hidden": (ob.hide_viewport, ob.hide_render),
        "cmc": _properties(ob.cmc),
    }


def _mesh(mesh: bpy.types.Mesh) -> dict:
    ob = next((ob for ob in bpy.data.objects if ob.data == mesh and ob.mode == "EDIT"), None)
    if ob is not None:
        ob.update_from_editmode()
    return {
        "cmc": _properties(mesh.cmc),
        "materials": [_name(material) for material in mesh.materials],
        "vertices": repr([(tuple(v.co), v.select) for v in mesh.vertices]),
        "edges": [(tuple(e.vertices), e.select, e.use_seam) for e in mesh.edges],
        "polygons": [(tuple(p.vertices), p.select, p.material_index, p.use_smooth) for p in mesh.polygons],
        "attributes": {
            a.name: (a.domain, a.data_type, repr(values(a))) for a in mesh.attributes
            if not a.name.startswith(".")
        },
        "weights": [[(g.group, g.weight) for g in v.groups] for v in mesh.vertices],
    }
