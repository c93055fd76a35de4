"""Opening the sidebar at the tab of the panels: after a plan is added by hand, the next button is there."""

from __future__ import annotations

from contextlib import suppress
from functools import partial

import bpy

from ..properties import preferences

# Seconds between two looks at the sidebar, which knows its tabs only once it is drawn; and how often to look.
_WAIT = 0.05
_OFTEN = 20


class ByHand:
    """Mixin of operators that add a plan: from a menu they also open the tab; scripts leave the window alone."""

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        ended = self.execute(context)  # type: ignore[attr-defined]
        if "FINISHED" in ended and context.area is not None and context.area.type == "VIEW_3D":
            context.area.spaces.active.show_region_ui = True
            left = iter(range(_OFTEN))
            bpy.app.timers.register(partial(_choose, context.area, left), first_interval=_WAIT)
        return ended


def _choose(area: bpy.types.Area, left) -> float | None:
    """Choose the tab of a sidebar; returns seconds to the next try, None at the end."""
    with suppress(ReferenceError, AttributeError):  # the area is gone; a Blender in which nobody but the user chooses
        sidebar = next((region for region in area.regions if region.type == "UI"), None)
        if sidebar is None:
            return None
        try:
            sidebar.active_panel_category = preferences.get("category").strip() or preferences.CATEGORY
        except TypeError:  # not drawn yet
            return _WAIT if next(left, None) is not None else None
    return None
