"""Settings of Repeat by Symmetry, for `Object.cmc` and for the operator."""

from collections.abc import Iterable
from functools import partial

import bpy
from bpy.props import EnumProperty, IntProperty, IntVectorProperty, PointerProperty, StringProperty

from ...solver.symmetry.complete import MOST_COPIES

_AS = [
    ("MESH", "One Mesh", "One object, with the copies welded along their seams"),
    ("INSTANCES", "Instances", "One object for each copy, all with the same mesh"),
]
_COPIES = [
    ("UNIT", "Units", "All copies if they close up; otherwise a unit, repeated along each direction"),
    ("COUNT", "Number", "The nearest copies, up to a number that includes the shell itself"),
    ("BOX", "Box", "The copies with their centre in the bounding box of an object"),
]

_COMPLETE = {
    "complete_as": partial(EnumProperty, name="As", description="Kind of the copies", items=_AS),
    "complete_extent": partial(EnumProperty, name="Copies", description="Which copies to make", items=_COPIES),
    "complete_repeat": partial(
        IntVectorProperty, name="Repeat", description="Number of units along the first, second and third "
        "direction", size=3, default=(1, 1, 1), min=1, soft_max=20, max=1000),
    "complete_count": partial(
        IntProperty, name="Number", description="Number of copies, the shell itself included",
        default=8, min=1, soft_max=200, max=MOST_COPIES),
}
COMPLETE_SETTINGS = tuple(_COMPLETE)
"""Names of the settings shared by `Object.cmc` and the operator."""

_BOX = "Object with the bounding box that the centres of the copies lie in"


def complete_annotations(options: Iterable[str] = ()) -> dict:
    """For the operator, which takes the box as an object's name."""
    settings = {name: make(options=set(options)) for name, make in _COMPLETE.items()}
    return settings | {"box": StringProperty(name="Box", description=_BOX, options=set(options))}


def stored_complete_annotations() -> dict:
    """For `Object.cmc`, which links the box."""
    settings = {name: make() for name, make in _COMPLETE.items()}
    return settings | {"complete_box": PointerProperty(name="Box", description=_BOX, type=bpy.types.Object)}


def draw_complete(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of an object or of the operator; only those in use."""
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
