"""Settings that keep a shell closed around holes, a part of those of a solve, and of Repeat by Gaps."""

from collections.abc import Iterable
from functools import partial

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntVectorProperty

from ...solver.shells.closing_options import MOVING, ClosingOptions

_BY = [
    ("NORMALS", "Normals", "Change the normals along the rim, as little as possible"),
    ("TILTS", "Lean", "Turn the normals about the rim only: the shell leans more or less"),
    ("HOLE", "Holes", "Move the holes of the plan; the normals stay"),
    ("BOTH", "Both", "Change the normals and move the holes, a little of each"),
]
_AS = [
    ("MESH", "One Mesh", "One object, with the copies welded across the cuts"),
    ("INSTANCES", "Instances", "One object for each copy, all with the same mesh"),
]

CLOSING = {
    "keep_closed": partial(
        BoolProperty, name="Keep Closed Around Courts", description="Where the shell would be open around a hole of "
        "the plan, change it as little as needed until it closes; shells on lines close by themselves", default=True),
    "close_by": partial(
        EnumProperty, name="Close By", description="What may change to keep the shell closed", items=_BY),
    "close_weight": partial(
        FloatProperty, name="Keep Holes", description="Weight of moving holes against turning normals; the larger, the "
        "less the holes move", default=1.0, min=1e-4, soft_min=0.01, soft_max=100.0),
    "close_shift": partial(
        BoolProperty, name="Shift", description="Let holes shift along X and Y", default=True),
    "close_twist": partial(
        BoolProperty, name="Twist", description="Let holes turn about the vertical; their normals do not turn with "
        "them", default=True),
    "close_size": partial(BoolProperty, name="Size", description="Let holes grow and shrink", default=False),
}
"""Name of a setting → its property."""

_TILE = {
    "tile_as": partial(EnumProperty, name="As", description="Kind of the copies", items=_AS),
    "tile_repeat": partial(
        IntVectorProperty, name="Repeat", description="Number of copies along the gap of the first, second and "
        "third hole", size=3, default=(3, 1, 1), min=1, soft_max=20, max=1000),
}
TILE_SETTINGS = tuple(_TILE)
"""Names of the settings of Repeat by Gaps."""


def tile_annotations(options: Iterable[str] = ()) -> dict:
    return {name: make(options=set(options)) for name, make in _TILE.items()}


def stored_tile_annotations() -> dict:
    """For `Object.cmc`."""
    return {name: make() for name, make in _TILE.items()}


def closing_of(wanted) -> ClosingOptions | None:
    """The settings of a solve as the solver takes them: None where the shell is left open, or its normals are where
    nothing closes it. Raises `CmcError` if nothing may move."""
    if not wanted.keep_closed or wanted.sites != "VERTICES" or wanted.delaunay:
        return None
    moves = {"close_shift": ("x", "y"), "close_twist": ("twist",), "close_size": ("size",)}
    motions = tuple(motion for name, names in moves.items() if getattr(wanted, name) for motion in names)
    return ClosingOptions(by=wanted.close_by.lower(), weight=wanted.close_weight, move=motions)


def draw_closing(layout: bpy.types.UILayout, owner) -> None:
    """Rows for how the shell of an object or an operator is kept closed; only those in use."""
    layout.prop(owner, "close_by")
    if owner.close_by.lower() in MOVING:
        column = layout.column(heading="Holes May")
        for name in ("close_shift", "close_twist", "close_size"):
            column.prop(owner, name)
    if owner.close_by == "BOTH":
        layout.prop(owner, "close_weight")


def draw_tile(layout: bpy.types.UILayout, owner, count: int = 3) -> None:
    """Rows for the settings of Repeat by Gaps, for `count` holes."""
    layout.row().prop(owner, "tile_as", expand=True)
    column = layout.column(align=True)
    for k in range(min(count, 3)):
        column.prop(owner, "tile_repeat", index=k, text="Repeat" if k == 0 else " ")
