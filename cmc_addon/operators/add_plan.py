"""Add > Mesh > CMC: ordinary plans, and plans with a hole, whose shells have a gap."""

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty, IntProperty

from ...solver.catalogue.holed_plans import StartPlan, annulus, cylinder
from ...solver.catalogue.start_plans import court, l_shape, rectangle, round_plan
from ...solver.errors import CmcError
from ..bridges.mesh_bridge import build_polygons, set_attribute, set_positions
from ..bridges.outline_bridge import write_boundary_groups
from ..bridges.start_bridge import mark_seams, write_lengths, write_normals
from ..properties import group_list
from ..properties.units import metres
from .activate import activate
from .open_tab import ByHand
from .poll import allow, check_numbers, why_not_object_mode

ORDINARY = [
    ("RECTANGLE", "Rectangle", "A rectangular plan; Solve makes the shell over it, its rim on the outline"),
    ("ROUND", "Round", "A round plan; its shell is a piece of a sphere"),
    ("L_SHAPE", "L-Shaped", "Two wings at a right angle, the corner between them rounded"),
    ("COURT", "Court", "A rectangular plan with a round court in the middle, around which the shell closes"),
]
"""Plans whose shells close by themselves."""

WITH_GAP = [
    ("ANNULUS", "Annulus", "A round plan with a court off its middle, around which Solve keeps the shell "
     "closed"),
    ("CYLINDER", "Cylinder Strip", "A tube whose normals wind along both ends; Solve, then Repeat by Gaps for a "
     "strip of any length"),
]
"""Plans whose shells would have a gap."""

_MAKE = {
    "RECTANGLE": (rectangle, ("size", "width", "columns")),
    "ROUND": (round_plan, ("size", "columns")),
    "L_SHAPE": (l_shape, ("size", "width", "columns")),
    "COURT": (court, ("size", "width", "hole", "columns")),
    "ANNULUS": (annulus, ("size", "hole", "offset", "columns")),
    "CYLINDER": (cylinder, ("size", "height", "columns")),
}
"""Shape → its function, and the settings that this takes, in order."""

_OWN = {
    "RECTANGLE": {"size": 10.0, "width": 0.65, "columns": 40},
    "ROUND": {"size": 10.0, "columns": 40},
    "L_SHAPE": {"size": 10.0, "width": 0.45, "columns": 40},
    "COURT": {"size": 12.0, "width": 0.8, "hole": 0.35, "columns": 40},
}
"""Defaults of a shape that differ from those of the properties."""
_SIZE = 8.0  # metres; the property itself is in Blender units


class CMC_OT_add_plan(ByHand, bpy.types.Operator):
    """Add a meshed plan with its boundary groups, ready for Solve"""

    bl_idname = "cmc.add_plan"
    bl_label = "Add CMC Plan"
    bl_options = {"REGISTER", "UNDO"}

    shape: EnumProperty(name="Shape", description="The plan to add", items=ORDINARY + WITH_GAP)
    size: FloatProperty(
        name="Size", description="Length of the plan, or its outer diameter",
        default=_SIZE, min=1e-3, subtype="DISTANCE", options={"SKIP_SAVE"})
    width: FloatProperty(
        name="Width", description="Depth of the plan or of its wings, relative to its length",
        default=0.65, min=0.05, max=1.0, subtype="FACTOR", options={"SKIP_SAVE"})
    hole: FloatProperty(
        name="Hole", description="Diameter of the court, relative to the plan's width",
        default=0.35, min=0.05, max=0.9, subtype="FACTOR", options={"SKIP_SAVE"})
    offset: FloatProperty(
        name="Offset", description="Distance of the court from the middle, relative to the radius",
        default=0.2, min=0.0, max=0.9, subtype="FACTOR", options={"SKIP_SAVE"})
    height: FloatProperty(
        name="Height", description="Height of the tube, relative to its diameter",
        default=0.5, min=0.05, max=20.0, soft_max=3.0, options={"SKIP_SAVE"})
    columns: IntProperty(
        name="Edges", description="Edges along the length of the plan or around its outer rim; more make a finer mesh",
        default=64, min=12, max=1000, soft_max=200, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_object_mode(context))

    @classmethod
    def description(cls, context, properties):
        return properties.bl_rna.properties["shape"].enum_items[properties.shape].description

    def execute(self, context):
        make, names = _MAKE[self.shape]
        defaults = {"size": _SIZE, **_OWN.get(self.shape, {})}
        defaults["size"] = metres(defaults["size"])
        for name, value in defaults.items():
            if not self.properties.is_property_set(name):
                setattr(self, name, value)
        return add(self, context, make, names)

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in ("shape", *_MAKE[self.shape][1]):
            column.prop(self, name)


def add(operator: bpy.types.Operator, context: bpy.types.Context, make, names) -> set[str]:
    """Add the plan that `make` gives for these settings of the operator, and make it active."""
    try:
        check_numbers(operator, names)
        start = make(*(getattr(operator, name) for name in names))
    except CmcError as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    activate(context, new_plan(context, start))
    return {"FINISHED"}


def new_plan(context: bpy.types.Context, start: StartPlan) -> bpy.types.Object:
    """The plan as an object at the 3D cursor, with its groups."""
    mesh, faces = bpy.data.meshes.new(start.name), start.domain.faces
    build_polygons(mesh, len(start.points), faces.ravel(), np.arange(0, 3 * len(faces) + 1, 3))
    set_positions(mesh, start.points)
    set_attribute(mesh, "Plan", "FLOAT2", "CORNER", start.uvs.reshape(-1, 2))
    mark_seams(mesh, start.domain.edges[start.seams])
    mesh.update()
    pairs, uids = [], []
    for name, edges in start.sides.items():
        group = group_list.add(mesh, name)
        kind, parameters = start.kinds[name]
        group.kind = kind.upper()
        for key, value in parameters.items():
            setattr(group, key, value)
        pairs.append(start.domain.edges[edges])
        uids.append(np.full(len(edges), group.uid))
    if pairs:
        mesh.cmc.active_index = 0
        write_boundary_groups(mesh, np.concatenate(pairs), np.concatenate(uids))
    if start.own_lengths:
        write_lengths(mesh, start.domain.edges, start.domain.edge_lengths)
    if start.initial is not None:
        write_normals(mesh, start.initial)
    plan = bpy.data.objects.new(start.name, mesh)
    plan.location = context.scene.cursor.location
    context.collection.objects.link(plan)
    plan.cmc.meshed = start.remesh
    for key, value in {"default_kind": "BINORMAL", **start.settings}.items():
        setattr(plan.cmc, key, value)
    return plan


def first_in_add_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """Rows above those of the modules."""
    draw_shapes(menu.layout, ORDINARY)
    menu.layout.separator()


def in_add_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """Rows below those of the modules."""
    menu.layout.separator()
    draw_shapes(menu.layout, WITH_GAP)


def draw_shapes(layout: bpy.types.UILayout, shapes) -> None:
    for identifier, label, _ in shapes:
        layout.operator("cmc.add_plan", text=label).shape = identifier


CLASSES = (CMC_OT_add_plan,)
