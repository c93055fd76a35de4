"""Colours of the overlay.

Boundary groups take the colours of the theme's bone colour sets, whose icons stand beside them in the list. The other
colours are preferences of the extension.
"""

from __future__ import annotations

import bpy

from ..properties import preferences

Colour = tuple[float, float, float]

# Numbers of colour sets; first those unlike each other and unlike the orange of Blender's selection.
_SETS = (4, 3, 9, 6, 1, 7, 5, 8, 12, 14, 13, 11, 10, 15, 2)


def icon_of(uid: int) -> str:
    """The icon of a group's colour."""
    return f"COLORSET_{_number(uid):02d}_VEC"


def colour_of(uid: int) -> Colour:
    return tuple(bpy.context.preferences.themes[0].bone_color_sets[_number(uid) - 1].select)


def other_colour(name: str) -> Colour:
    """A colour of the preferences, by name."""
    return tuple(preferences.get(name))


def _number(uid: int) -> int:
    return _SETS[(uid - 1) % len(_SETS)]
