"""Repeat: copies of the shell by symmetry; the plane of a mirror group; the menu Add > Mesh > CMC."""

import bpy

from ...solver.catalogue.module_presets import PRESETS
from ...solver.errors import CmcError
from ...solver.measure.summary import NOISE
from ..bridges.mesh_cache import mirror_corners
from ..properties.libraries import keeps_changes
from ..properties.links import plan_to_solve
from ..properties.registration import registration
from ..properties.reports import complete_report, last_report
from ..properties.symmetry_settings import draw_complete
from ..properties.units import length_text, part_text
from ..tasks.complete import CompleteTask, counts
from ..tasks.recipe import is_behind
from .tab import TALL, Tab, hint, numbers, paragraph, properties_column

PLANAR_KINDS = ("MIRROR", "PLANE")


def draw_group(layout: bpy.types.UILayout, context: bpy.types.Context, mesh: bpy.types.Mesh, group) -> None:
    """For the active group: its plane, its corners, and whether the shell continues across it."""
    if group.kind in PLANAR_KINDS:
        row = layout.row(align=True)
        for plane in ("X", "Y", "Z"):
            row.operator("cmc.group_plane", text=plane).plane = plane
        row.operator("cmc.group_plane", text="Edges").plane = "EDGES"
        row.operator("cmc.group_plane", text="", icon="ARROW_LEFTRIGHT").plane = "FLIP"
    if group.kind == "MIRROR":
        _draw_corners(layout, mesh, group)
    if group.kind in (*PLANAR_KINDS, "FREE"):
        properties_column(layout).prop(group, "across")
        numbers(layout, plane_rows(last_report(context), group.name))


def _draw_corners(layout, mesh, group) -> None:
    names = {other.uid: other.name for other in mesh.cmc.groups}
    for corner in mirror_corners(mesh):
        normal = corner.normal(mesh)
        if group.uid not in corner.uids or normal is None:
            continue
        other = names[corner.uids[0] if corner.uids[1] == group.uid else corner.uids[1]]
        row = layout.row(align=True)
        row.label(text=f"At {other}: faces {direction(normal)}", icon="EMPTY_SINGLE_ARROW")
        row.operator("cmc.flip_corner", text="", icon="ARROW_LEFTRIGHT").vertex = corner.vertex


def direction(normal) -> str:
    """The name of an axis, or the components of another direction."""
    for k, axis in enumerate("XYZ"):
        if abs(normal[k]) > 0.9999:
            return f"{'+' if normal[k] > 0 else '-'}{axis}"
    return "({:.2f}, {:.2f}, {:.2f})".format(*normal)


def plane_rows(report: dict | None, name: str) -> list[tuple[str, str]]:
    """Offset and planarity error of the sides of a group after the last solve."""
    rows = []
    for plane in [] if report is None else report.get("planes", []):
        if plane["name"] == name or plane["name"].rpartition(" ")[0] == name:
            rows.append(("Plane At", length_text(plane["offset"])))
            rows.append(("Off Plane", part_text(plane["error"], plane["relative"])))
    return rows


class CMC_PT_complete(Tab, bpy.types.Panel):
    """Copies of the shell, by symmetry and by the gaps around holes"""

    bl_idname = "CMC_PT_complete"
    bl_label = "Repeat"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 50

    @classmethod
    def poll(cls, context):
        plan = plan_to_solve(context)
        return plan is not None and (_repeats(plan) or has_gaps(context))

    def draw(self, context):
        """Its parts are panels."""
        plan = plan_to_solve(context)
        if plan is not None and is_behind(plan):
            draw_behind(self.layout, context)


def draw_behind(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """What was made of an older shell, and the button that makes it again."""
    paragraph(layout, context, "The copies are of an older shell.", "RADIOBUT_ON")
    layout.operator("cmc.update_all", icon="FILE_REFRESH")


def _repeats(plan: bpy.types.Object) -> bool:
    """Whether there is a group across which the shell may continue."""
    return any(group.kind in (*PLANAR_KINDS, "FREE") and group.across != "OFF" for group in plan.data.cmc.groups)


def has_gaps(context: bpy.types.Context) -> bool:
    """Whether the shell has a gap around a hole of its plan, or would have one if it were not kept closed."""
    report = last_report(context)
    return report is not None and bool(report.get("holes") and (report.get("is_open") or report.get("closing")))


class CMC_PT_symmetry(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_symmetry"
    bl_label = "Symmetry"
    bl_parent_id = "CMC_PT_complete"
    bl_order = 0

    @classmethod
    def poll(cls, context):
        plan = plan_to_solve(context)
        return plan is not None and _repeats(plan)

    def draw(self, context):
        layout, plan = self.layout, plan_to_solve(context)
        if plan is None:
            return
        column = properties_column(layout)
        column.enabled = keeps_changes(plan) and not context.window_manager.cmc.running
        draw_complete(column, plan.cmc)
        self._preview(layout, context, plan)
        row = layout.row()
        row.scale_y = TALL
        row.operator("cmc.complete")
        if plan.cmc.complete_report:
            numbers(layout, completed_rows(complete_report(plan)))

    def _preview(self, layout, context, plan):
        """The number of copies to expect."""
        try:
            expected = counts(plan, CompleteTask.stored(plan))
        except CmcError as error:
            paragraph(layout, context, str(error), "ERROR")
            return
        if expected is None:
            hint(layout, "Solve to see the", "number of copies")
        else:
            copies, more = expected
            than = "more than " if more else ""
            faces = copies * len(plan.data.polygons)
            numbers(layout, [("Copies", f"{than}{copies:,}"), ("Faces", f"{than}{faces:,}")])


def completed_rows(report: dict | None) -> list[tuple[str, str]]:
    if report is None:
        return []
    seams = part_text(report["largest_gap"], report["relative_gap"], " apart")
    rows = [("Made", f"{report['copies']:,} copies"), ("Seams", "Closed" if seams == "None" else seams)]
    if report.get("relative_offset", 0.0) > NOISE:
        rows.append(("Off Plane", length_text(report["largest_offset"], digits=2)))
    return rows


class CMC_MT_add(bpy.types.Menu):
    bl_idname = "CMC_MT_add"
    bl_label = "CMC"

    def draw(self, context):
        for name, preset in PRESETS.items():
            self.layout.operator("cmc.add_module", text=preset.name).module = name.upper()


def _in_add_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.menu("CMC_MT_add", icon="MESH_GRID")


CLASSES = (CMC_PT_complete, CMC_PT_symmetry, CMC_MT_add)
_register, _unregister = registration(CLASSES)


def register() -> None:
    _register()
    bpy.types.VIEW3D_MT_mesh_add.append(_in_add_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_mesh_add.remove(_in_add_menu)
    _unregister()
