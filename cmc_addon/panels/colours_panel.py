"""Look: colours and curvature lines of the results, and their normals on a sphere."""

import bpy

from ..drawing.curvature_lines import default_spacing_of
from ..drawing.shading import look_plan
from ..properties.colour_range import stored_range
from ..properties.libraries import keeps_changes
from ..properties.links import families, plan_to_solve
from ..properties.registration import registration
from ..results import gauss_image
from .tab import Tab, automatic, properties_column


class CMC_PT_look(Tab, bpy.types.Panel):
    """Shown once the plan has a result; with another object active, for the coloured plan."""

    bl_idname = "CMC_PT_look"
    bl_label = "Look"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 4

    @classmethod
    def poll(cls, context):
        return look_plan(context) is not None

    def draw(self, context):
        plan = look_plan(context)
        if plan is None:
            return
        is_active = plan == plan_to_solve(context)
        if not is_active:
            self.layout.label(text=plan.name, icon="MESH_GRID")
        self.layout.enabled = keeps_changes(plan)
        column = properties_column(self.layout)
        column.prop(plan.cmc, "colour_by")
        if plan.cmc.colour_by != "NONE":
            self._range(column, plan)
        column.separator()
        column.prop(plan.cmc, "curvature_lines")
        if plan.cmc.curvature_lines != "NONE":
            column.prop(plan.cmc, "curvature_line_spacing")
            if not plan.cmc.curvature_line_spacing:
                automatic(column, default_spacing_of(families(plan)[0].shell.dimensions))
        if not is_active:
            return
        column.separator()
        shown = gauss_image.is_shown(plan)
        column.operator("cmc.gauss_image", depress=shown, icon="SHADING_RENDERED")

    def _range(self, column, plan):
        column.prop(plan.cmc, "colour_fit")
        ranges = [stored_range(family.shell) for family in families(plan)]
        if not plan.cmc.colour_fit:
            both = column.column(align=True)
            both.prop(plan.cmc, "colour_min")
            both.prop(plan.cmc, "colour_max")
        elif not any(ranges):
            column.label(text="Not measured: solve again", icon="INFO")


CLASSES = (CMC_PT_look,)
register, unregister = registration(CLASSES)
