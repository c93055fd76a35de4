"""What results are coloured by, and which strokes are drawn on them: on `Object.cmc` of a plan, in the panel.

The settings themselves know nothing of meshes: `colours` and `curvature_lines_overlay` are told by `watchers`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty

from .attributes import ATTRIBUTES


@dataclass(frozen=True)
class Quantity:
    """Something to colour by. power: of a length that its unit is, 0 for none."""

    label: str
    description: str
    attribute: str
    power: int


QUANTITIES = {
    "MEAN_CURVATURE": Quantity(
        "Mean Curvature", "H, which is to be the same everywhere: the range is about its target",
        ATTRIBUTES["mean_curvature"], -1),
    "GAUSS_CURVATURE": Quantity(
        "Gauss Curvature", "K: above zero the shell is a dome, below a saddle", ATTRIBUTES["gauss_curvature"], -2),
    "DISTORTION": Quantity(
        "Distortion", "How much squares of the plan are stretched on the shell: 1 where they stay squares",
        ATTRIBUTES["distortion"], 0),
    "DEVIATION": Quantity(
        "Deviation", "Distance from what was wanted: of the rim from the outline, or from the surface approximated",
        ATTRIBUTES["deviation"], 1),
}
"""Identifier -> what results can be coloured by."""

_COLOUR_BY = [("NONE", "None", "The results as they are")] + [
    (name, quantity.label, quantity.description) for name, quantity in QUANTITIES.items()
]
_LINES = [
    ("NONE", "None", "No strokes"),
    ("MAX", "Most Curved", "Along the larger principal curvature"),
    ("MIN", "Least Curved", "Along the smaller principal curvature"),
    ("BOTH", "Both", "Along both principal curvatures: crosses"),
]

watchers: list[Callable[[bpy.types.Object, bpy.types.Context, str], None]] = []
"""Called with the plan of which one of these settings has changed, and the name of the setting."""


def _telling(name: str):
    def tell(owner, context) -> None:
        for told in watchers:
            told(owner.id_data, context, name)

    return tell


def stored_colour_annotations() -> dict:
    """For `Object.cmc`: the settings of a plan, and on a result the range of its colours."""
    return {
        "colour_by": EnumProperty(
            name="Colour by", description="What the colours of the results show", items=_COLOUR_BY,
            update=_telling("colour_by")),
        "colour_fit": BoolProperty(
            name="Fit Range", description="The range of the colours follows the results; else it is what you say",
            default=True, update=_telling("colour_fit")),
        "colour_min": FloatProperty(
            name="Min", description="Number of the first colour", precision=4, update=_telling("colour_min")),
        "colour_max": FloatProperty(
            name="Max", description="Number of the last colour", default=1.0, precision=4,
            update=_telling("colour_max")),
        "curvature_lines": EnumProperty(
            name="Strokes", description="Short strokes on the results along their lines of curvature", items=_LINES,
            update=_telling("curvature_lines")),
        "curvature_line_spacing": FloatProperty(
            name="Spacing", description="Distance between strokes; 0 chooses a fortieth of the shell's size",
            default=0.0, min=0.0, subtype="DISTANCE", update=_telling("curvature_line_spacing")),
        # On a result: low, high, centre, and 0 or 1 for: has a centre, numbers below, numbers above.
        "colour_range": FloatVectorProperty(
            name="Range", description="Low, high, centre and what of it counts, as last fitted", size=6),
    }
