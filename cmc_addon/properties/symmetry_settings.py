"""Settings of Complete by Symmetry: on `Object.cmc` of a plan, on the operator, in the panel."""

from functools import partial

import bpy
from bpy.props import EnumProperty, IntProperty, IntVectorProperty, PointerProperty, StringProperty

from ...solver.symmetry.complete import MOST_COPIES

_AS = [
    ("MESH", "One Mesh", "One object whose copies are welded along their seams"),
    ("INSTANCES", "Instances", "An object for every copy, all of them with the same mesh"),
]
_EXTENT = [
    ("UNIT", "Units", "All copies where they close up; else a unit that repeats, so many times along each direction"),
    ("COUNT", "Number", "The nearest so many copies, the shell itself included"),
    ("BOX", "Box", "The copies whose centre is within the bounding box of an object"),
]

_COMPLETE = {
    "complete_as": partial(EnumProperty, name="As", description="What the copies are", items=_AS),
    "complete_extent": partial(EnumProperty, name="CopySelection", description="Which copies there are", items=_EXTENT),
    "complete_repeat": partial(
        IntVectorProperty, name="Repeat", description="How often the unit is repeated along its first, second and "
        "third direction", size=3, default=(1, 1, 1), min=1, soft_max=20, max=1000),
    "complete_count": partial(
        IntProperty, name="Copies", description="How many copies there are, the shell itself included",
        default=8, min=1, soft_max=200, max=MOST_COPIES),
}
COMPLETE_SETTINGS = tuple(_COMPLETE)
"""Names of the settings shared by `Object.cmc` and the operator."""

_BOX = "Object whose bounding box holds the centres of the copies"


def complete_annotations(options=frozenset()) -> dict:
    """For the operator, where the box is an object's name."""
    found = {name: make(options=set(options)) for name, make in _COMPLETE.items()}
    return found | {"box": StringProperty(name="Box", description=_BOX, options=set(options))}


def stored_complete_annotations() -> dict:
    """For `Object.cmc`, where the box is a link."""
    found = {name: make() for name, make in _COMPLETE.items()}
    return found | {"complete_box": PointerProperty(name="Box", description=_BOX, type=bpy.types.Object)}


def draw_complete(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings, of an object or the operator; only the ones that count now."""
    layout.row().prop(owner, "complete_as", expand=True)
    layout.prop(owner, "complete_extent")
    if owner.complete_extent == "UNIT":
        layout.column(align=True).prop(owner, "complete_repeat")
    elif owner.complete_extent == "COUNT":
        layout.prop(owner, "complete_count")
    elif isinstance(owner, bpy.types.PropertyGroup):
        layout.prop(owner, "complete_box")
    else:
        layout.prop_search(owner, "box", bpy.data, "objects")
