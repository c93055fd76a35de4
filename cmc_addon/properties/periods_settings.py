"""Settings of Close Periods and Tile by Periods: on `Object.cmc` of a plan, on the operators, in the panel."""

from functools import partial

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntVectorProperty

from ...solver.shells.close import MOVING, ClosingOptions

_BY = [
    ("NORMALS", "Normals", "The normals along the rim change, as little as can be"),
    ("TILTS", "Tilts", "The normals turn about the rim only: the shell leaves it steeper or flatter"),
    ("HOLE", "Hole", "The holes of the plan move; the normals stay"),
    ("BOTH", "Both", "Normals and holes change, a little of each"),
]
_AS = [
    ("MESH", "One Mesh", "One object whose copies are welded across the cuts"),
    ("INSTANCES", "Instances", "An object for every copy, all of them with the same mesh"),
]

_CLOSE = {
    "close_by": partial(EnumProperty, name="By", description="What changes for the shell to close", items=_BY),
    "close_weight": partial(
        FloatProperty, name="Keep Holes", description="How much holes that move count against normals that turn: the "
        "larger, the less they move", default=1.0, min=1e-4, soft_min=0.01, soft_max=100.0),
    "close_shift": partial(
        BoolProperty, name="Shift", description="Holes may be shifted, along X and Y", default=True),
    "close_twist": partial(
        BoolProperty, name="Twist", description="Holes may turn about the vertical; their normals do not turn with "
        "them", default=True),
    "close_size": partial(BoolProperty, name="Size", description="Holes may grow and shrink", default=False),
}
CLOSE_SETTINGS = tuple(_CLOSE)
"""Names of the settings of Close Periods."""

_TILE = {
    "tile_as": partial(EnumProperty, name="As", description="What the copies are", items=_AS),
    "tile_repeat": partial(
        IntVectorProperty, name="Repeat", description="How often the shell is there along the gap of the first, the "
        "second and the third hole", size=3, default=(3, 1, 1), min=1, soft_max=20, max=1000),
}
TILE_SETTINGS = tuple(_TILE)
"""Names of the settings of Tile by Periods."""


def close_annotations(options=frozenset()) -> dict:
    return {name: make(options=set(options)) for name, make in _CLOSE.items()}


def tile_annotations(options=frozenset()) -> dict:
    return {name: make(options=set(options)) for name, make in _TILE.items()}


def stored_period_annotations() -> dict:
    """For `Object.cmc`."""
    return {name: make() for name, make in (_CLOSE | _TILE).items()}


def closure_of(wanted) -> ClosingOptions:
    """What is wanted as the solver takes it. Raises `CmcError` where nothing may move."""
    moves = {"close_shift": ("x", "y"), "close_twist": ("twist",), "close_size": ("size",)}
    motions = tuple(motion for name, names in moves.items() if getattr(wanted, name) for motion in names)
    return ClosingOptions(by=wanted.close_by.lower(), weight=wanted.close_weight, move=motions)


def may_move(wanted) -> bool:
    """Whether the plan itself may change."""
    return wanted.close_by.lower() in MOVING


def draw_close(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of Close Periods, of an object or the operator; only the ones that count now."""
    layout.prop(owner, "close_by")
    if may_move(owner):
        column = layout.column(heading="Holes May")
        for name in ("close_shift", "close_twist", "close_size"):
            column.prop(owner, name)
    if owner.close_by == "BOTH":
        layout.prop(owner, "close_weight")


def draw_tile(layout: bpy.types.UILayout, owner, count: int = 3) -> None:
    """Rows for the settings of Tile by Periods; of `count` holes."""
    layout.row().prop(owner, "tile_as", expand=True)
    column = layout.column(align=True)
    for k in range(min(count, 3)):
        column.prop(owner, "tile_repeat", index=k, text="Repeat" if k == 0 else " ")
