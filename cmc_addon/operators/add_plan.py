"""Add > Mesh > CMC: plans with a hole, whose shells have a gap to be closed or tiled."""

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty, IntProperty

from ...solver.errors import CmcError
from .. import group_list
from ..mesh_bridge import set_attribute
from ..outline_bridge import write_boundary_groups
from ..periods_bridge import mark_seams
from ..periods_plans import StartPlan, annulus, cylinder
from ..result_bridge import build_polygons

SHAPES = [
    ("ANNULUS", "Annulus", "A round plan around a court that is not in its middle: Solve, then Close Periods"),
    ("CYLINDER", "Cylinder Strip", "A tube whose normals wind along both ends: Solve, then Tile by Periods makes a "
     "strip as long as wanted"),
]
_ROWS = {"ANNULUS": ("size", "hole", "offset", "columns"), "CYLINDER": ("size", "height", "columns")}


class CMC_OT_add_plan(bpy.types.Operator):
    """Add a plan with a hole and its boundary groups"""

    bl_idname = "cmc.add_plan"
    bl_label = "Add Plan with a Hole"
    bl_options = {"REGISTER", "UNDO"}

    shape: EnumProperty(name="Shape", items=SHAPES)
    size: FloatProperty(
        name="Size", description="Outer diameter", default=8.0, min=1e-3, subtype="DISTANCE", options={"SKIP_SAVE"})
    hole: FloatProperty(
        name="Hole", description="Diameter of the court as a part of the outer one",
        default=0.35, min=0.05, max=0.9, subtype="FACTOR", options={"SKIP_SAVE"})
    offset: FloatProperty(
        name="Offset", description="How far the court is from the middle, as a part of the radius",
        default=0.2, min=0.0, max=0.9, subtype="FACTOR", options={"SKIP_SAVE"})
    height: FloatProperty(
        name="Height", description="Height of the tube as a part of its diameter",
        default=0.5, min=0.05, max=20.0, soft_max=3.0, options={"SKIP_SAVE"})
    columns: IntProperty(
        name="Edges", description="Edges along the outer rim: more are finer",
        default=64, min=12, max=1000, soft_max=200, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Leave edit mode first")
            return False
        return True

    @classmethod
    def description(cls, context, properties):
        return cls.bl_rna.properties["shape"].enum_items[properties.shape].description

    def execute(self, context):
        try:
            if self.shape == "ANNULUS":
                start = annulus(self.size, self.hole, self.offset, self.columns)
            else:
                start = cylinder(self.size, self.height, self.columns)
        except CmcError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        plan = new_plan(context, start)
        for other in context.selected_objects:
            other.select_set(False)
        plan.select_set(True)
        context.view_layer.objects.active = plan
        return {"FINISHED"}

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in ("shape", *_ROWS[self.shape]):
            column.prop(self, name)


def new_plan(context: bpy.types.Context, start: StartPlan) -> bpy.types.Object:
    """The plan as an object at the 3D cursor, its groups made."""
    mesh, faces = bpy.data.meshes.new(start.name), start.domain.faces
    build_polygons(mesh, len(start.points), faces.ravel(), np.arange(0, 3 * len(faces) + 1, 3))
    set_attribute(mesh, "position", "FLOAT_VECTOR", "POINT", start.points)
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
    mesh.cmc.active_index = 0
    write_boundary_groups(mesh, np.concatenate(pairs), np.concatenate(uids))
    plan = bpy.data.objects.new(start.name, mesh)
    plan.location = context.scene.cursor.location
    context.collection.objects.link(plan)
    for key, value in start.settings.items():
        setattr(plan.cmc, key, value)
    return plan


def in_add_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """Rows below those of the modules."""
    menu.layout.separator()
    for identifier, label, _ in SHAPES:
        menu.layout.operator("cmc.add_plan", text=label).shape = identifier


CLASSES = (CMC_OT_add_plan,)
