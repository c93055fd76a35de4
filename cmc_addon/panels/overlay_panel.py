"""Overlay: the switches of the viewport overlay, in the sidebar and in Blender's overlay popover."""

import bpy

from ..properties.links import plan_to_solve
from ..properties.overlay_settings import draw_overlay
from ..properties.registration import registration
from .tab import Tab


class CMC_PT_overlay(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_overlay"
    bl_label = "Overlay"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 5

    @classmethod
    def poll(cls, context):
        return plan_to_solve(context) is not None

    def draw_header(self, context):
        self.layout.prop(context.scene.cmc, "show_all", text="")

    def draw(self, context):
        draw_overlay(self.layout, context.scene.cmc)


class CMC_PT_overlay_popover(bpy.types.Panel):
    bl_idname = "CMC_PT_overlay_popover"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_parent_id = "VIEW3D_PT_overlay"
    bl_label = "CMC Plans"

    def draw(self, context):
        settings = context.scene.cmc
        layout = self.layout
        layout.active = context.space_data.overlay.show_overlays
        layout.prop(settings, "show_all", text="Plans and Shells")
        draw_overlay(layout, settings, columns=True)


CLASSES = (CMC_PT_overlay, CMC_PT_overlay_popover)
register, unregister = registration(CLASSES)
