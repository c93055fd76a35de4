"""The preferences of the extension; `get` reads one, or its default in scripts and batches without preferences.

The number of threads is not a preference: a solve is one sparse factorisation, which runs in one thread beside the
window however many BLAS may use.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import bpy
from bpy.props import FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from .registration import registration

PACKAGE = __package__.partition(".cmc_addon")[0]

CATEGORY = "CMC"

CATEGORY_CHANGED: list[Callable[[str], None]] = []
"""Called with the new name of the sidebar tab when the user changes it."""

_COLOUR = partial(FloatVectorProperty, size=3, subtype="COLOR", min=0.0, max=1.0)

_PREFERENCES = {
    "category": partial(
        StringProperty, name="Sidebar Tab", description="Tab of the sidebar with the panels", default=CATEGORY,
        update=lambda self, context: _tell_category(self.category)),
    "line_width": partial(
        FloatProperty, name="Line Width", description="Width of the lines of boundary groups, in pixels", default=3.0,
        min=1.0, max=20.0, soft_max=8.0, subtype="PIXEL"),
    "colour_ungrouped": partial(
        _COLOUR, name="Edges in No Group", description="Colour of boundary edges that are in no group",
        default=(0.62, 0.62, 0.62)),
    "colour_gaps": partial(
        _COLOUR, name="Gaps", description="Colour of the arrows across the gaps around holes",
        default=(1.0, 0.42, 0.1)),
    "colour_cut": partial(
        _COLOUR, name="Cut", description="Colour of the line where an open shell is cut",
        default=(1.0, 0.2, 0.55)),
    "live_limit": partial(
        IntProperty, name="Live Limit", description="Number of vertices up to which Live solves in full while you "
        "drag; a larger plan is solved roughly until the mouse rests", default=50_000, min=100, soft_max=500_000,
        max=10_000_000),
}
"""Name → property; `get` reads every one of them."""

_LOOKS = ("line_width", "colour_ungrouped", "colour_gaps", "colour_cut")


def get(name: str) -> Any:
    """A preference, or its default where the extension was enabled without preferences."""
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
    """Preferences that hold in all files"""

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
        note.label(text="Boundary groups take their colours from the theme: Themes > Bone Color Sets", icon="INFO")


register, unregister = registration((CmcPreferences,))
