"""Settings of Close Gaps and Repeat by Gaps, for `Object.cmc` and for the operators."""

from collections.abc import Iterable
from functools import partial

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntVectorProperty

from ...solver.shells.close import MOVING, ClosingOptions

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

_CLOSE = {
    "close_by": partial(EnumProperty, name="By", description="What may change to close the shell", items=_BY),
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
CLOSE_SETTINGS = tuple(_CLOSE)
"""Names of the settings of Close Gaps."""

_TILE = {
    "tile_as": partial(EnumProperty, name="As", description="Kind of the copies", items=_AS),
    "tile_repeat": partial(
        IntVectorProperty, name="Repeat", description="Number of copies along the gap of the first, second and "
        "third hole", size=3, default=(3, 1, 1), min=1, soft_max=20, max=1000),
}
TILE_SETTINGS = tuple(_TILE)
"""Names of the settings of Repeat by Gaps."""


def close_annotations(options: Iterable[str] = ()) -> dict:
    return {name: make(options=set(options)) for name, make in _CLOSE.items()}


def tile_annotations(options: Iterable[str] = ()) -> dict:
    return {name: make(options=set(options)) for name, make in _TILE.items()}


def stored_period_annotations() -> dict:
    """For `Object.cmc`."""
    return {name: make() for name, make in (_CLOSE | _TILE).items()}


def closure_of(wanted) -> ClosingOptions:
    """The settings as the solver takes them. Raises `CmcError` if nothing may move."""
    moves = {"close_shift": ("x", "y"), "close_twist": ("twist",), "close_size": ("size",)}
    motions = tuple(motion for name, names in moves.items() if getattr(wanted, name) for motion in names)
    return ClosingOptions(by=wanted.close_by.lower(), weight=wanted.close_weight, move=motions)


def may_move(wanted) -> bool:
    """Whether the plan may change."""
    return wanted.close_by.lower() in MOVING


def draw_close(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of Close Gaps, of an object or of the operator; only those in use."""
    layout.prop(owner, "close_by")
    if may_move(owner):
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
