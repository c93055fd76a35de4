"""The range of a result's colours, as stored on its object."""

from __future__ import annotations

import bpy

from .colour_maps import Range


def stored_range(result: bpy.types.Object) -> Range | None:
    """The range of a result's colours; None where it has none."""
    low, high, centre, has_centre, below, above = result.cmc.colour_range
    return Range(low, high, centre if has_centre else None, bool(below), bool(above)) if high > low else None
