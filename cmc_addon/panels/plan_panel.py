"""Plan: from a drawn outline to a plan, or plans to begin with."""

import bpy

from ...solver.meshing.wires import default_corner_radius, default_edge_length
from ..bridges.mesh_cache import contacts
from ..bridges.outline_bridge import local_size
from ..operators.add_plan import ORDINARY
from ..operators.go_to import target
from ..operators.plan import is_ready_made, outline_of, plan_of
from ..properties.registration import registration
from .tab import TALL, Tab, automatic, fitting, go_to_row, hint, properties_column


class CMC_PT_plan(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_plan"
    bl_label = "Plan"
    bl_order = 0

    def draw_header_preset(self, context):
        ob = context.object
        if ob is not None and ob.cmc.meshed:
            self.layout.label(text=fitting(ob.name))

    def draw(self, context):
        layout, ob = self.layout, context.object
        if ob is None or ob.type not in {"MESH", "CURVE"}:
            hint(layout, "Draw an outline and press", "Mesh Plan, or begin with")
            self._shapes(layout)
        elif ob.cmc.role != "NONE":
            if target(ob, "PLAN"):
                go_to_row(layout, ob, "PLAN")
            else:
                hint(layout, "The plan of this result", "has been deleted")
        elif is_ready_made(ob):
            hint(layout, "This plan is meshed already:", "Solve works on it")
        else:
            self._mesh(layout, context.scene.cmc, ob)

    def _shapes(self, layout):
        """Buttons that add plans."""
        grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        for identifier, label, _ in ORDINARY:
            grid.operator("cmc.add_plan", text=label).shape = identifier
        layout.menu("CMC_MT_add", text="More")

    def _mesh(self, layout, settings, ob):
        self._settings(layout, settings, ob)
        go_to_row(layout, ob, "OUTLINE" if ob.cmc.meshed else "PLAN")
        if ob.cmc.rounded:
            layout.label(text=ob.cmc.rounded, icon="SPHERECURVE")
        row = layout.row()
        row.scale_y = TALL
        row.operator("cmc.mesh_plan", text=f"Mesh Plan from {fitting(ob.name)}" if plan_of(ob) is None else "Update")
        if ob.type == "MESH" and (count := contacts(ob.data)):
            row = layout.row()
            row.label(text=f"{count} vertices touch, unjoined", icon="ERROR")
            row.operator("cmc.weld")

    def _settings(self, layout, settings, ob):
        column = properties_column(layout)
        size = local_size(outline_of(ob))
        column.prop(settings, "edge_length")
        if not settings.edge_length:
            automatic(column, default_edge_length(size))
        column.prop(settings, "corners")
        if settings.corners != "NONE":
            column.prop(settings, "corner_radius", text="Radius")
            if not settings.corner_radius:
                automatic(column, default_corner_radius(size), "up to ")


CLASSES = (CMC_PT_plan,)
register, unregister = registration(CLASSES)
