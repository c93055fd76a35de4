"""Add > Mesh > CMC: Wente's cylinder and torus and the honeycomb ring, ready to solve."""

import math

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty

from ...solver.catalogue.bubble_plans import ring_plan, torus_plan, wente_plan
from ..properties.units import metres
from .add_plan import add
from .open_tab import ByHand
from .poll import allow, why_not_object_mode

BUBBLES = [
    ("WENTE", "Wente Cylinder", "A quarter of one of the cylinders that make up a Wente torus; Solve, then Complete "
     "by Symmetry for the torus or a strip of bubbles"),
    ("TORUS", "Wente Torus", "The whole torus, an unstable shell over a flat torus; Solve makes the closed surface"),
    ("RING", "Honeycomb Ring", "A hexagon of tubes with six half tubes attached, an unstable shell; Solve, then "
     "Repeat by Symmetry for a honeycomb of rings"),
]
_MAKE = {
    "WENTE": (wente_plan, ("size", "angle", "height", "columns")),
    "TORUS": (torus_plan, ("size", "angle", "columns")),
    "RING": (ring_plan, ("size", "slenderness", "columns")),
}
"""Bubble → its function, and the settings that this takes, in order."""
_SIZE = 8.0  # metres; the property itself is in Blender units
_OWN_COLUMNS = {"WENTE": 16, "TORUS": 40, "RING": 14}
"""H is within 5 % then: 24,000 vertices for the torus, 15 s of which most count its unstable modes; 7,000 for the ring,
1 s."""


class CMC_OT_add_bubble(ByHand, bpy.types.Operator):
    """Add the plan of an unstable shell, with the start that Solve needs to find it"""

    bl_idname = "cmc.add_bubble"
    bl_label = "Add CMC Bubble"
    bl_options = {"REGISTER", "UNDO"}

    bubble: EnumProperty(name="Bubble", description="The bubble to add", items=BUBBLES)
    size: FloatProperty(
        name="Size", description="Approximate width of the surface",
        default=_SIZE, min=1e-3, subtype="DISTANCE", options={"SKIP_SAVE"})
    angle: FloatProperty(
        name="Angle", description="Angle between the normals at the two ends of a cylinder; a simple fraction of 180° "
        "makes a torus. Small angles need more edges",
        default=math.radians(120.0), min=math.radians(1.0), max=math.radians(179.0), subtype="ANGLE", step=100,
        options={"SKIP_SAVE"})
    height: FloatProperty(
        name="Height", description="Height of the cylinder, relative to the height at which it closes; any other "
        "height gives a strip of bubbles",
        default=1.0, min=0.3, max=3.0, soft_min=0.7, soft_max=1.5, options={"SKIP_SAVE"})
    slenderness: FloatProperty(
        name="Slenderness", description="From stocky to slender, with thin necks",
        default=0.6, min=0.0, max=1.0, subtype="FACTOR", options={"SKIP_SAVE"})
    columns: IntProperty(
        name="Edges", description="Edges around a quarter of a cylinder or along half a tube; more make a finer mesh",
        default=12, min=4, max=200, soft_max=60, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_object_mode(context))

    @classmethod
    def description(cls, context, properties):
        return properties.bl_rna.properties["bubble"].enum_items[properties.bubble].description

    def execute(self, context):
        if not self.properties.is_property_set("columns"):
            self.columns = _OWN_COLUMNS[self.bubble]
        if not self.properties.is_property_set("size"):
            self.size = metres(_SIZE)
        make, names = _MAKE[self.bubble]
        return add(self, context, make, names)

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in ("bubble", *_MAKE[self.bubble][1]):
            column.prop(self, name)


def in_add_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """Rows below all others."""
    menu.layout.separator()
    for identifier, label, _ in BUBBLES:
        menu.layout.operator("cmc.add_bubble", text=label).bubble = identifier


CLASSES = (CMC_OT_add_bubble,)
