"""Settings of Mesh Plan, for `Scene.cmc` and for the operator."""

from collections.abc import Iterable
from functools import partial

from bpy.props import BoolProperty, FloatProperty

_PLAN_SETTINGS = {
    "edge_length": partial(
        FloatProperty, name="Edge Length", description="Length of the edges; 0: a fortieth of the plan's size",
        default=0.0, min=0.0, subtype="DISTANCE"),
    "round_corners": partial(
        BoolProperty, name="Round Corners", default=True,
        description="Round sharp corners of the outline, where the rim normals would jump and the curvature diverge"),
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
