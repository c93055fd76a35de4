"""Settings of Mesh Plan, for `Scene.cmc` and for the operator."""

from collections.abc import Iterable
from functools import partial

from bpy.props import EnumProperty, FloatProperty

from ...solver.meshing.rounding import ROUNDED

_PLAN_SETTINGS = {
    "edge_length": partial(
        FloatProperty, name="Edge Length", description="Length of the edges; 0: a fortieth of the plan's size",
        default=0.0, min=0.0, subtype="DISTANCE"),
    "corners": partial(
        EnumProperty, name="Round Corners", description="Which corners of the outline are rounded",
        items=[(name.upper().replace("-", "_"), *texts) for name, texts in ROUNDED.items()], default="ALL"),
    "corner_radius": partial(
        FloatProperty, name="Corner Radius",
        description="Radius of rounded corners, less where space is short; 0: for each outline a tenth of its size, "
        "less at short edges",
        default=0.0, min=0.0, subtype="DISTANCE"),
}
PLAN_SETTINGS = tuple(_PLAN_SETTINGS)
"""Names of the settings shared by `Scene.cmc` and Mesh Plan."""


def plan_annotations(options: Iterable[str] = ()) -> dict:
    """The settings of Mesh Plan as property annotations."""
    return {name: make(options=set(options)) for name, make in _PLAN_SETTINGS.items()}
