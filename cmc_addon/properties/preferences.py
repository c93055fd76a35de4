"""The preferences of the extension, and the way to read one that also works where there are none (scripts, batch).

How many threads are used is not among them: a solve is one factorisation of a sparse matrix and runs in one thread
beside the window, whatever BLAS is allowed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import bpy
from bpy.props import FloatProperty, FloatVectorProperty, IntProperty, StringProperty

PACKAGE = __package__.partition(".cmc_addon")[0]

CATEGORY = "CMC"

CATEGORY_CHANGED: list[Callable[[str], None]] = []
"""Called with the name of the sidebar's tab when the user changes it."""

_COLOUR = partial(FloatVectorProperty, size=3, subtype="COLOR", min=0.0, max=1.0)

_PREFERENCES = {
    "category": partial(
        StringProperty, name="Sidebar Tab", description="Tab of the sidebar in which the panels are", default=CATEGORY,
        update=lambda self, context: _tell_category(self.category)),
    "line_width": partial(
        FloatProperty, name="Line Width", description="Width of the lines of boundary groups, in pixels", default=3.0,
        min=1.0, max=20.0, soft_max=8.0, subtype="PIXEL"),
    "colour_ungrouped": partial(
        _COLOUR, name="Edges in No Group", description="Colour of boundary edges that are in no group",
        default=(0.62, 0.62, 0.62)),
    "colour_gaps": partial(
        _COLOUR, name="Periods", description="Colour of the arrows across the gaps around holes",
        default=(1.0, 0.42, 0.1)),
    "colour_cut": partial(
        _COLOUR, name="Cut", description="Colour of the line along which a shell is cut open",
        default=(1.0, 0.2, 0.55)),
    "live_limit": partial(
        IntProperty, name="Live Limit", description="Vertices of a plan up to which Live answers in full while you "
        "drag; a larger one gets a rough answer until the mouse rests", default=50_000, min=100, soft_max=500_000,
        max=10_000_000),
}
"""Name → property: one added here can be read by `get` everywhere."""

_LOOKS = ("line_width", "colour_ungrouped", "colour_gaps", "colour_cut")


def get(name: str) -> Any:
    """A preference, or what it is by default where the extension was not enabled by the preferences."""
    addon = bpy.context.preferences.addons.get(PACKAGE)
    if addon is not None and addon.preferences is not None:
        value = getattr(addon.preferences, name)
    else:
        value = _PREFERENCES[name].keywords["default"]
    return value if isinstance(value, (str, int, float)) else tuple(value)


def _tell_category(category: str) -> None:
    for listener in CATEGORY_CHANGED:
        listener(category)


class CmcPreferences(bpy.types.AddonPreferences):
    """What is the same in all files"""

    bl_idname = PACKAGE
    __annotations__ = {name: make() for name, make in _PREFERENCES.items()}

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        column.prop(self, "category")
        column.prop(self, "live_limit")
        column.separator()
        for name in _LOOKS:
            column.prop(self, name)
        note = self.layout.column(align=True)
        note.active = False
        note.label(text="Boundary groups have the colours of the theme: Themes > Bone Color Sets", icon="INFO")


def register() -> None:
    bpy.utils.register_class(CmcPreferences)


def unregister() -> None:
    if CmcPreferences.is_registered:
        bpy.utils.unregister_class(CmcPreferences)
