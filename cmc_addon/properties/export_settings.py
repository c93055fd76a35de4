"""Settings of Export, for `Object.cmc` and for the operator."""

from collections.abc import Iterable
from functools import partial

import bpy
from bpy.props import BoolProperty, EnumProperty

from ...solver.io.mesh_files import FORMATS

_TEXTS = {
    ".glb": ("glTF", "One file with normals and UVs, for viewers, renderers and the web; Y is up, as in all glTF"),
    ".obj": ("OBJ", "Polygons with UVs, groups and materials by name, for CAD and other modellers; Z is up"),
    ".ply": ("PLY", "Triangles with normals, for measuring; Z is up"),
    ".stl": ("STL", "Triangles, for printing and milling; Z is up"),
}
_FORMATS = [
    (suffix[1:].upper(), *_TEXTS.get(suffix, (suffix[1:].upper(), f"A {suffix} file")))
    for suffix in sorted(FORMATS, key=[*_TEXTS].index)
]
_WHAT = [
    ("AUTO", "Automatic", "The active result; for a plan the first it has of: repeated, fitted, shell"),
    ("SHELL", "Shell", "The shell made by Solve"),
    ("COMPLETED", "Repeated", "The copies made by Repeat by Symmetry or Repeat by Gaps, as one mesh"),
    ("SELECTED", "Selected", "All selected results, as one mesh"),
]

_EXPORT = {
    "export_what": partial(EnumProperty, name="What", description="Result to write", items=_WHAT),
    "export_format": partial(EnumProperty, name="Format", description="Format of the file", items=_FORMATS),
    "export_modifiers": partial(
        BoolProperty, name="With Modifiers", description="Write the mesh with its modifiers applied", default=True),
    "export_report": partial(
        BoolProperty, name="With Report", description="Also write the report, as a JSON file of the same name",
        default=True),
}
EXPORT_SETTINGS = tuple(_EXPORT)
"""Names of the settings of Export."""


def export_annotations(options: Iterable[str] = ()) -> dict:
    return {name: make(options=set(options)) for name, make in _EXPORT.items()}


def stored_export_annotations() -> dict:
    """For `Object.cmc`."""
    return export_annotations()


def draw_export(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of an object or of the operator."""
    layout.prop(owner, "export_what")
    layout.prop(owner, "export_format")
    column = layout.column(heading="Include")
    column.prop(owner, "export_modifiers", text="Modifiers")
    column.prop(owner, "export_report", text="Report")
