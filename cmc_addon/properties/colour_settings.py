"""Colours and curvature lines of the results: settings on `Object.cmc` of a plan.

The settings know nothing of meshes: `results.colours` and `curvature_lines_overlay` watch them through `watchers`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty

from .attributes import ATTRIBUTES


@dataclass(frozen=True)
class Quantity:
    """A quantity to colour by. power: its unit is this power of a length, 0 for a pure number."""

    label: str
    description: str
    attribute: str
    power: int


QUANTITIES = {
    "MEAN_CURVATURE": Quantity(
        "Mean Curvature", "H, the same everywhere on an exact shell: the range is centred on that value",
        ATTRIBUTES["mean_curvature"], -1),
    "GAUSS_CURVATURE": Quantity(
        "Gauss Curvature", "K: above zero the shell is a dome, below a saddle", ATTRIBUTES["gauss_curvature"], -2),
    "DISTORTION": Quantity(
        "Distortion", "Stretch of the plan's squares on the shell: 1 where they stay squares",
        ATTRIBUTES["distortion"], 0),
    "DEVIATION": Quantity(
        "Deviation", "Distance of the rim from the outline, or of the shell from the surface it approximates",
        ATTRIBUTES["deviation"], 1),
}
"""Identifier -> quantity, in the order of the menu."""

_COLOUR_BY = [("NONE", "None", "No colours")] + [
    (name, quantity.label, quantity.description) for name, quantity in QUANTITIES.items()
]
_LINES = [
    ("NONE", "None", "No lines"),
    ("MAX", "Most Curved", "Along the larger principal curvature"),
    ("MIN", "Least Curved", "Along the smaller principal curvature"),
    ("BOTH", "Both", "Along both principal curvatures, which cross at right angles"),
]

watchers: list[Callable[[bpy.types.Object, bpy.types.Context, str], None]] = []
"""Called with the plan whose setting has changed, the context, and the name of the setting."""


def _notifying(name: str):
    def notify(owner, context) -> None:
        for watcher in watchers:
            watcher(owner.id_data, context, name)

    return notify


def stored_colour_annotations() -> dict:
    """For `Object.cmc`: the settings of a plan; on a result the range of its colours."""
    return {
        "colour_by": EnumProperty(
            name="Colour By", description="Quantity that the colours of the results show", items=_COLOUR_BY,
            update=_notifying("colour_by")),
        "colour_fit": BoolProperty(
            name="Fit Range", description="Fit the range of the colours to the results; off, set it by hand",
            default=True, update=_notifying("colour_fit")),
        "colour_min": FloatProperty(
            name="Min", description="Value of the first colour", precision=4, update=_notifying("colour_min")),
        "colour_max": FloatProperty(
            name="Max", description="Value of the last colour", default=1.0, precision=4,
            update=_notifying("colour_max")),
        "curvature_lines": EnumProperty(
            name="Curvature Lines", description="Draw short lines on the results along their principal curvatures",
            items=_LINES, update=_notifying("curvature_lines")),
        "curvature_line_spacing": FloatProperty(
            name="Spacing", description="Distance between the lines; 0: a fortieth of the shell's size",
            default=0.0, min=0.0, subtype="DISTANCE", update=_notifying("curvature_line_spacing")),
        # On a result: low, high, centre; then 0 or 1: has a centre, has values below, has values above.
        "colour_range": FloatVectorProperty(
            name="Range", description="Range of the colours as last fitted: low, high, centre and flags", size=6),
    }
