"""Settings of Export: on `Object.cmc` of a plan, on the operator, in the panel."""

from functools import partial

import bpy
from bpy.props import BoolProperty, EnumProperty

from ...solver.io.mesh_files import FORMATS

_TEXTS = {
    ".glb": ("glTF", "One file with normals and UVs, for viewers, renderers and the web; its up is Y, as in all glTF"),
    ".obj": ("OBJ", "Polygons with UVs, groups and materials by name, for CAD and other modellers; its up is Z"),
    ".ply": ("PLY", "Triangles with normals, for measuring; its up is Z"),
    ".stl": ("STL", "Triangles, for printing and milling; its up is Z"),
}
_FORMATS = [
    (suffix[1:].upper(), *_TEXTS.get(suffix, (suffix[1:].upper(), f"A {suffix} file")))
    for suffix in sorted(FORMATS, key=[*_TEXTS].index)
]
_WHAT = [
    ("AUTO", "Automatic", "The active result; of a plan what was made of it last: completed, fitted, or its shell"),
    ("SHELL", "Shell", "The shell that Solve has made"),
    ("FIT", "Fitted Shell", "The shell that Fit to Outline has made"),
    ("COMPLETED", "Completed", "The copies that Complete by Symmetry or Tile by Periods have made, as one mesh"),
    ("SELECTED", "Selected", "All selected results, as one mesh"),
]

_EXPORT = {
    "export_what": partial(EnumProperty, name="What", description="Which result is written", items=_WHAT),
    "export_format": partial(EnumProperty, name="Format", description="What kind of file is written", items=_FORMATS),
    "export_modifiers": partial(
        BoolProperty, name="With Modifiers", description="Write the mesh as its modifiers show it", default=True),
    "export_report": partial(
        BoolProperty, name="With Report", description="Write the report beside it, as a JSON file of the same name",
        default=True),
}
EXPORT_SETTINGS = tuple(_EXPORT)
"""Names of the settings of Export."""


def export_annotations(options=frozenset()) -> dict:
    return {name: make(options=set(options)) for name, make in _EXPORT.items()}


def stored_export_annotations() -> dict:
    """For `Object.cmc`."""
    return export_annotations()


def draw_export(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings, of an object or the operator."""
    layout.prop(owner, "export_what")
    layout.prop(owner, "export_format")
    column = layout.column(heading="Include")
    column.prop(owner, "export_modifiers", text="Modifiers")
    column.prop(owner, "export_report", text="Report")
