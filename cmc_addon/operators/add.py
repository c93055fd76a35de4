"""Add > Mesh > CMC: plans of modules for Repeat by Symmetry, ready to solve."""

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty, IntProperty

from ...solver.catalogue.module_presets import EDGES, PRESETS
from ...solver.errors import CmcError
from ..bridges.mesh_bridge import build_polygons, set_attribute, set_positions
from ..bridges.outline_bridge import write_boundary_groups
from ..properties import group_list
from ..properties.units import metres
from .activate import activate
from .open_tab import ByHand
from .poll import allow, check_numbers, why_not_object_mode


class CMC_OT_add_module(ByHand, bpy.types.Operator):
    """Add the plan of a module with its boundary groups; then Solve, then Repeat by Symmetry"""

    bl_idname = "cmc.add_module"
    bl_label = "Add Module"
    bl_options = {"REGISTER", "UNDO"}

    module: EnumProperty(
        name="Module", description="The module to add",
        items=[(name.upper(), preset.name, preset.description) for name, preset in PRESETS.items()])
    size: FloatProperty(
        name="Size", description="Longest side of the plan; 0 for the module's own size",
        default=0.0, min=0.0, subtype="DISTANCE", options={"SKIP_SAVE"})
    slenderness: FloatProperty(
        name="Slenderness", description="From stocky to slender, with thin necks",
        default=0.5, min=0.0, max=1.0, subtype="FACTOR", options={"SKIP_SAVE"})
    edges: IntProperty(
        name="Edges", description="Edges along the longest side of the plan; more make a finer mesh",
        default=EDGES, min=6, max=400, soft_max=100, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_object_mode(context))

    @classmethod
    def description(cls, context, properties):
        return PRESETS[properties.module.lower()].description

    def execute(self, context):
        try:
            check_numbers(self, ("size", "slenderness"))
            plan = new_plan(context, self.module.lower(), self.size, self.slenderness, self.edges)
        except CmcError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        activate(context, plan)
        return {"FINISHED"}

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in ("module", "size", "slenderness", "edges"):
            column.prop(self, name)


def new_plan(context: bpy.types.Context, name: str, size: float, slenderness: float, edges: int) -> bpy.types.Object:
    """The plan of a preset as an object at the 3D cursor, with its groups and settings. Raises `CmcError`."""
    preset = PRESETS[name]
    module = preset.make(slenderness, edges)
    shape = module.shape
    flat = shape.positions * ((size or metres(preset.size)) / float(np.ptp(shape.positions, axis=0).max()))
    mesh = bpy.data.meshes.new(preset.name)
    faces = shape.domain.faces
    build_polygons(mesh, len(flat), faces.ravel(), np.arange(0, 3 * len(faces) + 1, 3))
    set_positions(mesh, np.column_stack([flat, np.zeros(len(flat))]))
    set_attribute(mesh, "Plan", "FLOAT2", "CORNER", flat[faces.ravel()])
    mesh.update()
    _make_groups(mesh, preset, module)
    plan = bpy.data.objects.new(preset.name, mesh)
    plan.location = context.scene.cursor.location
    context.collection.objects.link(plan)
    plan.cmc.complete_repeat = preset.repeat
    for key, value in preset.settings.items():
        setattr(plan.cmc, key, value)
    return plan


def _make_groups(mesh: bpy.types.Mesh, preset, module) -> None:
    pairs, uids = [], []
    for name, edges in module.shape.sides.items():
        group = group_list.add(mesh, name)
        group.kind = preset.kinds.get(name, "mirror").upper()
        group.normal = module.normals[name]
        group.across = "OFF" if name in preset.ends else "AUTO"
        pairs.append(module.shape.domain.edges[edges])
        uids.append(np.full(len(edges), group.uid))
    mesh.cmc.active_index = 0
    write_boundary_groups(mesh, np.concatenate(pairs), np.concatenate(uids))


CLASSES = (CMC_OT_add_module,)
